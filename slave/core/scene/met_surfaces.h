// SPDX-License-Identifier: Apache-2.0
// The surfaces that the rays of a packet have met: where, by the kernels for all rays at once, then
// materials, and what scenes of more than plain diffuse triangles add to that. Asked once a packet and
// not once a ray what the scene needs, plain scenes pay nothing for the others.
//
// Threads. One object per thread.
#pragma once

#include <cstdint>

#include "slave/core/kernels/kernel_table.h"
#include "slave/core/scene/surface_detail.h"

namespace tessera::core {

class MetSurfaces {
 public:
  // Keeps references until the next call. Requires: both outlive the calls of the others.
  void begin(const PreparedScene::Impl& scene, const KernelTable& kernels);

  // Requires: rays and hits stand as they are until the last call for them.
  void find(const FanPacket& rays, const PacketHits& hits);
  void find(const RayPacket& rays, const PacketHits& hits);

  const PacketPoints& points() const { return points_; }
  // Requires: the ray has met something; so for the next.
  const Material& material(int ray) {
    if (hits_->primitive[ray] != known_) {
      known_ = hits_->primitive[ray];
      material_ = &material_of(known_);
    }
    return *material_;
  }
  std::uint32_t triangle(int ray) const { return hits_->primitive[ray]; }
  // The same, or kNoPrimitive for a sliver.
  std::uint32_t sound_triangle(int ray) const {
    return (points_.sliver >> ray & 1u) != 0 ? kNoPrimitive : triangle(ray);
  }

  // Makes *to[i] for each of `rays`, bits of points().met. cones [kPacketRays]: the
  // rays' where they began; null: they have none, and textures and patterns are not filtered.
  // batch: the one that the surfaces are of, which takes their optional lobes; null: lobes are not asked
  // for. Weights are those of surfaces alone: see slave/core/bsdf/transmission.h.
  void make(std::uint64_t rays, const RayCone* cones, Surface* const* to,
            SurfaceBatch* batch = nullptr);
  // The same of what the camera sees, directly or in mirrors: surfaces that are not lit show their
  // colour. To all others they are black.
  void make_seen(std::uint64_t rays, const RayCone* cones, Surface* const* to,
                 SurfaceBatch* batch = nullptr);

 private:
  void make_lit(std::uint64_t rays, const RayCone* cones, Surface* const* to, SurfaceBatch* batch);
  template <class Packet>
  void keep(const Packet& rays, const PacketHits& hits);
  const Material& material_of(std::uint32_t triangle);
  // Of scenes whose triangles are not all stored: the corners of those that are met, and the hits with
  // the places of their corners there for numbers.
  void gather_corners(const PacketHits& hits);
  const float* vertices() const {
    return scene_->triangles.is_flat() ? scene_->triangles.vertices.data()
                                       : &gathered_.corner[0][0][0];
  }
  const PacketHits& numbered(const PacketHits& hits) const {
    return scene_->triangles.is_flat() ? hits : gathered_.hits;
  }

  const PreparedScene::Impl* scene_ = nullptr;
  const KernelTable* kernels_ = nullptr;
  const float (*direction_)[kPacketRays] = nullptr;
  const PacketHits* hits_ = nullptr;
  PacketPoints points_;
  std::uint32_t known_ = kNoPrimitive;  // material_ is that triangle's
  const Material* material_ = nullptr;
  InstanceFinder instances_;
  SurfaceDetail detail_;
  struct {
    float corner[kPacketRays][3][3];  // [triangle][corner][axis]
    PacketHits hits;
  } gathered_;
};

}  // namespace tessera::core
