// SPDX-License-Identifier: Apache-2.0
// The surfaces that the rays of a packet have met. The kernels find the points for all rays at
// once; then materials are looked up, and what scenes of more than plain diffuse triangles add to
// that. What the scene needs is asked once for a packet and not once for a ray, so that plain
// scenes pay nothing for the others.
//
// Threads. One object per thread, over memory of its own.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "slave/core/kernels/kernel_table.h"
#include "slave/core/scene/surface_detail.h"
#include "slave/core/trace/scene_tracer.h"

namespace tessera::core {

class MetSurfaces {
 public:
  struct Memory {
    PacketPoints points;
    SurfaceDetail::Memory detail;
    // Used where a scene's triangles are not all stored: corners of those that were met, and the
    // hits with places in `corner` as primitives. Hits of patches are left out of them.
    float corner[kPacketRays][3][3];  // [triangle][corner][axis]
    PacketHits numbered;
    // Of the rays that have met something, in rich scenes: the instances that they have met.
    std::uint32_t instance[kPacketRays];
  };

  // Requires: all outlive it.
  MetSurfaces(const PreparedScene::Impl& scene, const KernelTable& kernels, Memory& memory)
      : scene_(scene),
        kernels_(kernels),
        memory_(memory),
        instances_(scene.triangles),
        detail_(scene, kernels, memory.detail) {}
  // The same for hits that the tracer has found, by its method for patches.
  MetSurfaces(const PreparedScene::Impl& scene, const SceneTracer& tracer, Memory& memory)
      : MetSurfaces(scene, tracer.kernels(), memory) {
    patch_method_ = tracer.patch_method();
  }

  // Finds the points. Requires: hits are those of the rays, and both stand as they are until the
  // last call for them.
  void find(const FanPacket& rays, const PacketHits& hits);
  void find(const RayPacket& rays, const PacketHits& hits);

  const PacketPoints& points() const { return memory_.points; }
  // Bits of the rays that have met patches.
  std::uint64_t on_patches() const { return kKnowsPatches ? on_patches_ : 0; }
  // Material of a triangle that was hit.
  const Material& material(std::uint32_t triangle) {
    if (triangle != known_) find_material(triangle);
    return scene_.materials[material_];
  }
  // The primitive that a ray has hit, or kNoPrimitive for a sliver and for a patch without horizon:
  // rays that leave these may meet them again.
  std::uint32_t sound_primitive(std::uint32_t primitive, int ray) const {
    return (points().sliver >> ray & 1u) != 0 ? kNoPrimitive : primitive;
  }
  float horizon(int ray) const {
    return (on_patches() >> ray & 1u) != 0 ? points().horizon[ray] : kPlaneHorizon;
  }

  // Makes *to[i] for each of `rays`, bits of points().met. cones [kPacketRays]: the rays' cones
  // where they began; null: there are none, and textures and patterns are not filtered. batch: the
  // batch that the surfaces belong to, which takes their optional lobes; null: lobes are not
  // needed. Weights are those of surfaces alone: see slave/core/bsdf/transmission.h.
  template <class Packet>
  void make(const Packet& packet, const PacketHits& hits, std::uint64_t rays, const RayCone* cones,
            Surface* const* to, SurfaceBatch* batch = nullptr) {
    make_lit({points(), packet.direction, hits.primitive, memory_.instance}, rays, cones, to,
             batch);
    if (scene_.features.has_unlit) blacken(rays, to, /*is_seen=*/false);
  }
  // Does the same for what the camera sees, directly or in mirrors: unlit surfaces show their
  // colour. In make() they are black.
  template <class Packet>
  void make_seen(const Packet& packet, const PacketHits& hits, std::uint64_t rays,
                 const RayCone* cones, Surface* const* to, SurfaceBatch* batch = nullptr) {
    make_lit({points(), packet.direction, hits.primitive, memory_.instance}, rays, cones, to,
             batch);
    if (scene_.features.has_unlit) blacken(rays, to, /*is_seen=*/true);
  }

 private:
  void make_lit(const SurfaceDetail::Hits& hits, std::uint64_t rays, const RayCone* cones,
                Surface* const* to, SurfaceBatch* batch);
  static void blacken(std::uint64_t rays, Surface* const* to, bool is_seen);
  void find_material(std::uint32_t triangle);
  const std::vector<std::uint32_t>& materials_of(std::uint32_t instance) const;
  // of: the materials of the instance.
  std::size_t material_number(const std::vector<std::uint32_t>& of, std::uint32_t instance,
                              std::uint32_t triangle) const;
  std::size_t material_number(std::uint32_t instance, std::uint32_t triangle) const;
  void look_ahead(const PacketHits& hits);
  void gather_corners(const PacketHits& hits);
  template <class Packet>
  void find_on_patches(const Packet& rays, const PacketHits& hits);
  const float* vertices() const {
    return scene_.triangles.is_flat() ? scene_.triangles.vertices.data() : &memory_.corner[0][0][0];
  }
  const PacketHits& numbered(const PacketHits& hits) const {
    return scene_.triangles.is_flat() ? hits : memory_.numbered;
  }

  const PreparedScene::Impl& scene_;
  const KernelTable& kernels_;
  Memory& memory_;
  std::uint32_t known_ = kNoPrimitive;          // whose material has number material_
  std::uint32_t even_instance_ = kNoPrimitive;  // all of it has that material, where there is one
  std::size_t material_ = 0;
  PatchMethod patch_method_ = PatchMethod::kAuto;
  std::uint64_t on_patches_ = 0;  // bits of the rays that have met patches
  InstanceFinder instances_;
  SurfaceDetail detail_;
};

}  // namespace tessera::core
