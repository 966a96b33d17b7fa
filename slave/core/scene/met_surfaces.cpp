// SPDX-License-Identifier: Apache-2.0
#include "slave/core/scene/met_surfaces.h"

#include <new>

#include "slave/core/ray/ray_bits.h"
#include "slave/core/simd/axis_arrays.h"

namespace tessera::core {
namespace {

// A surface that scatters nothing and shows `seen`.
void show_alone(Surface& s, Vec3f seen) {
  s.bsdf = BsdfKind::kDiffuse;
  s.weight = {1, 1, 1};
  s.emission = seen;
  s.albedo = {};
}

}  // namespace

void MetSurfaces::find(const FanPacket& rays, const PacketHits& hits) {
  if (!scene_.triangles.is_flat()) gather_corners(hits);
  kernels_.fan_points(vertices(), rays, numbered(hits), memory_.points);
}

void MetSurfaces::find(const RayPacket& rays, const PacketHits& hits) {
  if (!scene_.triangles.is_flat()) gather_corners(hits);
  kernels_.packet_points(vertices(), rays, numbered(hits), memory_.points);
}

// Rays that meet one triangle after another share its corners.
void MetSurfaces::gather_corners(const PacketHits& hits) {
  std::uint32_t count = 0, last = kNoPrimitive;
  for (std::size_t i = 0; i < kPacketRays; ++i) {
    const std::uint32_t number = hits.primitive[i];
    memory_.numbered.t[i] = hits.t[i];
    if (number == kNoPrimitive) {
      memory_.numbered.primitive[i] = kNoPrimitive;
      continue;
    }
    if (number != last) {
      const std::uint32_t instance = instances_.of(number);
      for (int k = 0; k < 3; ++k) {
        const Vec3f p = scene_.triangles.vertex_of(instance, number, k);
        float* const to = memory_.corner[count][k];
        to[0] = p.x;
        to[1] = p.y;
        to[2] = p.z;
      }
      last = number;
      ++count;
    }
    memory_.numbered.primitive[i] = count - 1;
  }
}

// Unlit surfaces show their colour where they are seen, and are black elsewhere.
void MetSurfaces::blacken(std::uint64_t rays, Surface* const* to, bool is_seen) {
  for_each_ray(rays, [&](int ray) {
    Surface& s = *to[ray];
    if (s.material->is_unlit) show_alone(s, is_seen ? s.albedo : Vec3f{});
  });
}

void MetSurfaces::make_lit(const SurfaceDetail::Hits& hits, std::uint64_t rays,
                           const RayCone* cones, Surface* const* to, SurfaceBatch* batch) {
  const PacketPoints& at = hits.points;
  for_each_ray(rays, [&](int ray) {
    const std::uint32_t triangle = hits.triangle[ray];
    const Material& m = material(triangle);
    Surface& s = *new (to[ray]) Surface;  // constructed in place: every bounce comes here
    s.point = vector_at(at.point, ray);
    s.normal = s.shading_normal = vector_at(at.normal, ray);
    s.offset = at.offset[ray];
    s.albedo = m.albedo;
    s.is_front = (at.front >> ray & 1u) != 0;
    if (s.is_front || m.is_double_sided) s.emission = m.emission;
    s.material = &m;
    s.sound_triangle = sound_triangle(triangle, ray);
  });
  if (scene_.features.is_rich) detail_.add(hits, rays, cones, to, batch);
}

std::size_t MetSurfaces::material_number(std::uint32_t triangle) {
  const std::uint32_t instance = instances_.of(triangle);
  const auto& materials = scene_.meshes[scene_.instances[instance].mesh]->materials;
  return materials[materials.size() == 1 ? 0 : triangle - instances_.first_triangle()];
}

}  // namespace tessera::core
