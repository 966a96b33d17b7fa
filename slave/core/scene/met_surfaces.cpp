// SPDX-License-Identifier: Apache-2.0
#include "slave/core/scene/met_surfaces.h"

#include <new>

#include "slave/core/ray/ray_bits.h"
#include "slave/core/simd/axis_arrays.h"

namespace tessera::core {
namespace {

// A surface that scatters nothing and shows `seen`.
void blacken(Surface& s, Vec3f seen) {
  s.bsdf = BsdfKind::kDiffuse;
  s.weight = {1, 1, 1};
  s.emission = seen;
  s.albedo = {};
}

}  // namespace

void MetSurfaces::begin(const PreparedScene::Impl& scene, const KernelTable& kernels) {
  scene_ = &scene;
  kernels_ = &kernels;
  known_ = kNoPrimitive;
  instances_.begin(scene.triangles);
  if (scene.features.is_rich) detail_.begin(scene, kernels);
}

template <class Packet>
void MetSurfaces::keep(const Packet& rays, const PacketHits& hits) {
  direction_ = rays.direction;
  hits_ = &hits;
}

void MetSurfaces::find(const FanPacket& rays, const PacketHits& hits) {
  keep(rays, hits);
  if (!scene_->triangles.is_flat()) gather_corners(hits);
  kernels_->fan_points(vertices(), rays, numbered(hits), points_);
}

void MetSurfaces::find(const RayPacket& rays, const PacketHits& hits) {
  keep(rays, hits);
  if (!scene_->triangles.is_flat()) gather_corners(hits);
  kernels_->packet_points(vertices(), rays, numbered(hits), points_);
}

// Rays that meet one triangle after another share its corners.
void MetSurfaces::gather_corners(const PacketHits& hits) {
  std::uint32_t count = 0, last = kNoPrimitive;
  for (std::size_t i = 0; i < kPacketRays; ++i) {
    const std::uint32_t number = hits.primitive[i];
    gathered_.hits.t[i] = hits.t[i];
    if (number == kNoPrimitive) {
      gathered_.hits.primitive[i] = kNoPrimitive;
      continue;
    }
    if (number != last) {
      const std::uint32_t instance = instances_.of(number);
      for (int k = 0; k < 3; ++k) {
        const Vec3f p = scene_->triangles.vertex_of(instance, number, k);
        float* const to = gathered_.corner[count][k];
        to[0] = p.x;
        to[1] = p.y;
        to[2] = p.z;
      }
      last = number;
      ++count;
    }
    gathered_.hits.primitive[i] = count - 1;
  }
}

void MetSurfaces::make(std::uint64_t rays, const RayCone* cones, Surface* const* to,
                       SurfaceBatch* batch) {
  make_lit(rays, cones, to, batch);
  if (scene_->features.has_unlit) {
    for_each_ray(rays, [&](int ray) {
      if (to[ray]->material->is_unlit) blacken(*to[ray], {});
    });
  }
}

void MetSurfaces::make_seen(std::uint64_t rays, const RayCone* cones, Surface* const* to,
                            SurfaceBatch* batch) {
  make_lit(rays, cones, to, batch);
  if (scene_->features.has_unlit) {
    for_each_ray(rays, [&](int ray) {
      if (to[ray]->material->is_unlit) blacken(*to[ray], to[ray]->albedo);
    });
  }
}

void MetSurfaces::make_lit(std::uint64_t rays, const RayCone* cones, Surface* const* to,
                           SurfaceBatch* batch) {
  for_each_ray(rays, [&](int ray) {
    const Material& m = material(ray);
    Surface& s = *new (to[ray]) Surface;  // in its place: this is the path of every bounce
    s.point = vector_at(points_.point, ray);
    s.normal = s.shading_normal = vector_at(points_.normal, ray);
    s.offset = points_.offset[ray];
    s.albedo = m.albedo;
    s.is_front = (points_.front >> ray & 1u) != 0;
    if (s.is_front || m.is_double_sided) s.emission = m.emission;
    s.material = &m;
    s.sound_triangle = sound_triangle(ray);
  });
  if (scene_->features.is_rich)
    detail_.add({points_, direction_, hits_->primitive}, rays, cones, to, batch);
}

const Material& MetSurfaces::material_of(std::uint32_t triangle) {
  const std::uint32_t instance = instances_.of(triangle);
  const auto& materials = scene_->meshes[scene_->instances[instance].mesh]->materials;
  return scene_
      ->materials[materials.size() == 1 ? materials[0]
                                        : materials[triangle - instances_.first_triangle()]];
}

}  // namespace tessera::core
