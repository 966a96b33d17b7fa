// SPDX-License-Identifier: Apache-2.0
// What the surfaces that rays have met have beyond plain geometry and the constants of a material:
// normals of vertices and of maps, textures, what scattering needs to know, programs. Scenes of
// plain diffuse triangles never come here (met_surfaces.h).
//
// Rays of a packet that have met one instance and one material are a group: what they have in
// common is looked up once, their corners are put side by side, and registers do the rest
// (slave/core/surface/detail-inl.h), to the bit of plain arithmetic for each ray alone
// (tests/support/plain_surface.h).
//
// Threads. One object per thread, over memory of its own.
#pragma once

#include <cstddef>
#include <cstdint>

#include "slave/core/kernels/kernel_table.h"
#include "slave/core/primitive/triangle/triangle_store.h"
#include "slave/core/scene/prepared_scene_impl.h"
#include "slave/core/scene/surface_batch.h"
#include "slave/core/surface/surface.h"

namespace tessera::core {

class SurfaceDetail {
 public:
  // Points that are worked on together. Beyond their count stands what stood there before, so that
  // no index there leads anywhere else.
  struct Memory {
    DetailPoints points{};
    Surface* surface[kDetailPoints];
    std::uint32_t triangle[kDetailPoints];  // of the scene
    int ray[kDetailPoints];                 // of the packet
  };

  // Requires: all outlive it.
  SurfaceDetail(const PreparedScene::Impl& scene, const KernelTable& kernels, Memory& memory)
      : scene_(scene), kernels_(kernels), memory_(memory) {}

  // What a packet has met.
  struct Hits {
    const PacketPoints& points;
    const float (&direction)[3][kPacketRays];
    const std::uint32_t (&triangle)[kPacketRays];
    const std::uint32_t (&instance)[kPacketRays];  // that the triangle belongs to
  };

  // Adds to *to[i] for each of `rays`, bits of points.met. cones [kPacketRays]: the rays' cones
  // where they began; null: there are none. batch: takes the optional lobes of its surfaces; null:
  // lobes are not needed. Requires: the surfaces are as plain geometry and material make them.
  void add(const Hits& hits, std::uint64_t rays, const RayCone* cones, Surface* const* to,
           SurfaceBatch* batch);

 private:
  const Mesh& mesh_of(std::uint32_t instance) const;
  DetailGroup group_of(std::uint32_t instance, const Material& material) const;
  void put_textures(const Material& material, const Mesh& mesh, DetailGroup& group) const;
  std::ptrdiff_t number_of(const Material& material) const;
  void add_group(const DetailGroup& group, const Hits& hits, std::uint64_t rays, Surface* const* to,
                 SurfaceBatch* batch);
  // These functions work on the points in the memory.
  void fetch_corners(const DetailGroup& group, const Mesh& mesh) const;
  void put_corners(const DetailGroup& group, std::uint32_t instance);
  void put_tangents(std::uint32_t instance);
  void take(const DetailGroup& group, const Mesh& mesh);
  Vec3f color_at(const Mesh& mesh, int i) const;  // of vertices
  void run_program(const Material& material);
  void add_lobes(const DetailGroup& group, SurfaceBatch* batch);
  void pass_light(const DetailGroup& group, const Hits& hits, SurfaceBatch* batch);

  const PreparedScene::Impl& scene_;
  const KernelTable& kernels_;
  Memory& memory_;
  std::uint64_t first_triangle_ = 0;  // of the instance whose points are in the memory
};

}  // namespace tessera::core
