// SPDX-License-Identifier: Apache-2.0
#include "slave/core/scene/met_surfaces.h"

#include <new>

#include "slave/core/primitive/freeform/patch_point.h"
#include "slave/core/primitive/patch/patch_horizon.h"
#include "slave/core/ray/ray_bits.h"
#include "slave/core/simd/axis_arrays.h"

namespace tessera::core {
namespace {

// Where a ray of a packet comes from.
struct CastFrom {
  float origin[3], direction[3];

  CastFrom(const FanPacket& rays, int i) {
    for (int a = 0; a < 3; ++a) {
      origin[a] = rays.origin[a];
      direction[a] = rays.direction[a][i];
    }
  }
  CastFrom(const RayPacket& rays, int i) {
    for (int a = 0; a < 3; ++a) {
      origin[a] = rays.origin[a][i];
      direction[a] = rays.direction[a][i];
    }
  }
};

// A surface that scatters nothing and shows `seen`.
void show_alone(Surface& s, Vec3f seen) {
  s.bsdf = BsdfKind::kDiffuse;
  s.weight = {1, 1, 1};
  s.emission = seen;
  s.albedo = {};
}

}  // namespace

// Finds the instances that the rays have met, and asks the memory for what will be read of the
// triangles: scattered rays meet what nobody has looked at lately.
void MetSurfaces::look_ahead(const PacketHits& hits) {
  const bool is_flat = scene_.triangles.is_flat();
  const float* const corners = scene_.triangles.vertices.data();
  for (std::size_t i = 0; i < kPacketRays; ++i) {
    const std::uint32_t triangle = hits.primitive[i];
    if (triangle == kNoPrimitive) continue;
    const std::uint32_t instance = memory_.instance[i] = instances_.of(triangle);
    if (!is_flat) continue;
    __builtin_prefetch(corners + std::size_t{9} * triangle);
    __builtin_prefetch(corners + std::size_t{9} * triangle + 8);
    const Mesh& mesh = *scene_.meshes[scene_.instances[instance].mesh];
    const std::uint64_t number = triangle - instances_.first_triangle();
    __builtin_prefetch(&mesh.triangles[number]);
    if (mesh.materials.size() > 1) __builtin_prefetch(&mesh.materials[number]);
  }
}

void MetSurfaces::find(const FanPacket& rays, const PacketHits& hits) {
  if (scene_.features.is_rich) look_ahead(hits);
  if (!scene_.triangles.is_flat()) gather_corners(hits);
  kernels_.fan_points(vertices(), rays, numbered(hits), memory_.points);
  if (on_patches() != 0) find_on_patches(rays, hits);
}

void MetSurfaces::find(const RayPacket& rays, const PacketHits& hits) {
  if (scene_.features.is_rich) look_ahead(hits);
  if (!scene_.triangles.is_flat()) gather_corners(hits);
  kernels_.packet_points(vertices(), rays, numbered(hits), memory_.points);
  if (on_patches() != 0) find_on_patches(rays, hits);
}

// Rays that meet one triangle after another share its corners.
void MetSurfaces::gather_corners(const PacketHits& hits) {
  std::uint32_t count = 0, last = kNoPrimitive;
  bool is_patch = false;  // whether `last` is one's
  on_patches_ = 0;
  for (std::size_t i = 0; i < kPacketRays; ++i) {
    const std::uint32_t number = hits.primitive[i];
    memory_.numbered.t[i] = hits.t[i];
    if (number == kNoPrimitive) {
      memory_.numbered.primitive[i] = kNoPrimitive;
      continue;
    }
    if (number != last) {
      const std::uint32_t instance = instances_.of(number);
      last = number;
      is_patch = scene_.is_patched(instance);
      for (int k = 0; k < 3 && !is_patch; ++k) {
        const Vec3f p = scene_.triangles.vertex_of(instance, number, k);
        float* const to = memory_.corner[count][k];
        to[0] = p.x;
        to[1] = p.y;
        to[2] = p.z;
      }
      if (!is_patch) ++count;
    }
    memory_.numbered.primitive[i] = is_patch ? kNoPrimitive : count - 1;
    if (is_patch) on_patches_ |= std::uint64_t{1} << i;
  }
}

template <class Packet>
void MetSurfaces::find_on_patches(const Packet& rays, const PacketHits& hits) {
  PacketPoints& points = memory_.points;
  for_each_ray(on_patches_, [&](int i) {
    const std::uint32_t number = hits.primitive[i];
    const PartInWorld there = scene_.part(instances_.of(number), number);
    const CastFrom from(rays, i);
    const PatchSurfacePoint at = patch_point(*there.patch, *there.part, from.origin, from.direction,
                                             hits.t[i], patch_method_);
    const Vec3f direction{from.direction[0], from.direction[1], from.direction[2]};
    const bool is_front = dot(at.normal, direction) < 0;
    put_vector(at.point, points.point, i);
    const Vec3f normal = is_front ? at.normal : -at.normal;
    const float horizon =
        horizon_at(*there.patch, *there.part, at.u, at.v, at.point, normal).value_or(kNoHorizon);
    put_vector(normal, points.normal, i);
    points.offset[i] = at.offset;
    points.horizon[i] = horizon;
    points.u[i] = at.u;
    points.v[i] = at.v;
    points.distance[i] = hits.t[i] * length(direction);
    points.met |= std::uint64_t{1} << i;
    points.front |= std::uint64_t{is_front} << i;
    points.sliver |= std::uint64_t{!(horizon < 1)} << i;
  });
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
  const auto make = [&](int ray, const Material& m) {
    Surface& s = *new (to[ray]) Surface;  // constructed in place: every bounce comes here
    s.point = vector_at(at.point, ray);
    const Vec3f normal = vector_at(at.normal, ray);  // loads wait for stores of other widths
    s.normal = normal;
    s.shading_normal = normal;
    s.offset = at.offset[ray];
    s.albedo = m.albedo;
    s.is_front = (at.front >> ray & 1u) != 0;
    if (s.is_front || m.is_double_sided) s.emission = m.emission;
    s.material = &m;
    s.sound_primitive = sound_primitive(hits.triangle[ray], ray);
  };
  // Triangles keep the horizon that a surface begins with.
  const auto set_horizons = [&] {
    for_each_ray(rays & on_patches(), [&](int ray) { to[ray]->horizon = horizon(ray); });
  };
  if (!scene_.features.is_rich) {
    for_each_ray(rays, [&](int ray) { make(ray, material(hits.triangle[ray])); });
    set_horizons();
    return;
  }
  for_each_ray(rays, [&](int ray) {
    make(ray, scene_.materials[material_number(hits.instance[ray], hits.triangle[ray])]);
  });
  set_horizons();
  detail_.add(hits, rays, cones, to, batch);
}

const std::vector<std::uint32_t>& MetSurfaces::materials_of(std::uint32_t instance) const {
  const std::uint32_t number = scene_.instances[instance].mesh;
  return scene_.is_patched(instance) ? scene_.geometry->surfaces[number]->materials
                                     : scene_.meshes[number]->materials;
}

std::size_t MetSurfaces::material_number(const std::vector<std::uint32_t>& of,
                                         std::uint32_t instance, std::uint32_t triangle) const {
  if (of.size() == 1) return of[0];
  if (scene_.is_patched(instance)) return of[scene_.patch_of_part(instance, triangle)];
  return of[triangle - scene_.triangles.instance_first[instance]];
}

std::size_t MetSurfaces::material_number(std::uint32_t instance, std::uint32_t triangle) const {
  return material_number(materials_of(instance), instance, triangle);
}

// Most instances have one material, and most rays meet the instance that the last one has met.
void MetSurfaces::find_material(std::uint32_t triangle) {
  known_ = triangle;
  const std::uint32_t instance = instances_.of(triangle);
  if (instance == even_instance_) return;
  const std::vector<std::uint32_t>& of = materials_of(instance);
  material_ = material_number(of, instance, triangle);
  even_instance_ = of.size() == 1 ? instance : kNoPrimitive;
}

}  // namespace tessera::core
