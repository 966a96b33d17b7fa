#include "slave/core/render/met_surfaces.h"

#include <bit>
#include <new>

namespace tessera::core {
namespace {

static_assert(kPlacesMax >= kPacketRays);

// Calls for each ray of the mask.
template <class Function>
void for_each_ray(std::uint64_t rays, const Function& function) {
  for (; rays != 0; rays &= rays - 1) function(std::countr_zero(rays));
}

Vec3f at(const float (*values)[kPacketRays], int ray) {
  return {values[0][ray], values[1][ray], values[2][ray]};
}

}  // namespace

void MetSurfaces::begin(const PreparedScene::Impl& scene, const KernelTable& kernels) {
  scene_ = &scene;
  kernels_ = &kernels;
  known_ = shape_.number = kNoPrimitive;
}

template <class Packet>
void MetSurfaces::keep(const Packet& rays, const PacketHits& hits) {
  direction_ = rays.direction;
  hits_ = &hits;
}

void MetSurfaces::find(const FanPacket& rays, const PacketHits& hits) {
  keep(rays, hits);
  kernels_->fan_points(scene_->triangles.vertices.data(), rays, hits, points_);
}

void MetSurfaces::find(const RayPacket& rays, const PacketHits& hits) {
  keep(rays, hits);
  kernels_->packet_points(scene_->triangles.vertices.data(), rays, hits, points_);
}

void MetSurfaces::make(std::uint64_t rays, const RayCone* cones, Surface* const* to) {
  for_each_ray(rays, [&](int ray) {
    const Material& m = material(ray);
    Surface& s = *new (to[ray]) Surface;  // in its place: this is the path of every bounce
    s.point = at(points_.point, ray);
    s.normal = s.shading_normal = at(points_.normal, ray);
    s.offset = points_.offset[ray];
    s.albedo = m.albedo;
    s.is_front = (points_.front >> ray & 1u) != 0;
    if (s.is_front) s.emission = m.emission;
    s.material = &m;
    s.sound_triangle = sound_triangle(ray);
  });
  if (scene_->features.is_rich) enrich_all(rays, cones, to);
}

const SurfaceTriangle& MetSurfaces::triangle_of(int ray) {
  if (shape_.number != hits_->primitive[ray])
    shape_ = surface_triangle(*scene_, hits_->primitive[ray]);
  return shape_;
}

SurfaceHit MetSurfaces::hit_of(int ray, const RayCone& cone) const {
  return {points_.u[ray], points_.v[ray], at(direction_, ray), cone};
}

[[gnu::noinline]] void MetSurfaces::enrich_all(std::uint64_t rays, const RayCone* cones,
                                               Surface* const* to) {
  std::uint64_t programmed = 0;
  for_each_ray(rays, [&](int ray) {
    const RayCone cone = cones == nullptr ? RayCone{} : cones[ray].advanced(points_.distance[ray]);
    enrich(*scene_, triangle_of(ray), hit_of(ray, cone), *to[ray]);
    if (to[ray]->material->surface.kind != SurfaceKind::kConstant)
      programmed |= std::uint64_t{1} << ray;
  });
  if (programmed != 0) run_programs(programmed, to);
}

// One material after the other.
void MetSurfaces::run_programs(std::uint64_t rays, Surface* const* to) {
  const Noise noise(kernels_->noise);
  SurfacePlaces places;
  while (rays != 0) {
    const Material* const material = to[std::countr_zero(rays)]->material;
    places.count = 0;
    for_each_ray(rays, [&](int ray) {
      if (to[ray]->material != material) return;
      add_place(triangle_of(ray), hit_of(ray, to[ray]->cone), *to[ray], places);
      rays &= ~(std::uint64_t{1} << ray);
    });
    apply_surface_program(material->surface, noise, places);
  }
}

}  // namespace tessera::core
