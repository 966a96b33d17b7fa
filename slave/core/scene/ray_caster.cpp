// SPDX-License-Identifier: Apache-2.0
#include "slave/core/scene/ray_caster.h"

#include <algorithm>
#include <cmath>

#include "common/base/check.h"
#include "slave/core/accel/run_tasks.h"
#include "slave/core/primitive/freeform/patch_point.h"
#include "slave/core/primitive/triangle/barycentric.h"
#include "slave/core/scene/prepared_scene_impl.h"
#include "slave/core/trace/scene_tracer.h"

namespace tessera::core {
namespace {

constexpr std::size_t kRaysPerTask = 4096;

// Computed in double, since a product of edges may leave float32 in scenes of 1e-20 or 1e15.
Vec3f normal_of(Vec3f a, Vec3f b, Vec3f c) {
  const double p[3] = {double{b.x} - a.x, double{b.y} - a.y, double{b.z} - a.z};
  const double q[3] = {double{c.x} - a.x, double{c.y} - a.y, double{c.z} - a.z};
  const double n[3] = {p[1] * q[2] - p[2] * q[1], p[2] * q[0] - p[0] * q[2],
                       p[0] * q[1] - p[1] * q[0]};
  const double largest = std::max({std::fabs(n[0]), std::fabs(n[1]), std::fabs(n[2])});
  const double x = n[0] / largest, y = n[1] / largest, z = n[2] / largest;
  const double l = std::sqrt(x * x + y * y + z * z);
  return {static_cast<float>(x / l), static_cast<float>(y / l), static_cast<float>(z / l)};
}

bool is_same(Vec3f p, Vec3f q) { return p.x == q.x && p.y == q.y && p.z == q.z; }

class Caster {
 public:
  Caster(const PreparedScene::Impl& scene, const CastOptions& options)
      : scene_(scene),
        tracer_(scene.index, kernels_for(options.isa), nullptr, options.patch_method),
        options_(options) {}

  void cast(std::span<const CastRay> rays, std::span<CastHit> hits) const {
    const auto bundle = static_cast<std::size_t>(options_.bundle);
    for (std::size_t first = 0; first < rays.size(); first += bundle) {
      const std::size_t count = std::min(bundle, rays.size() - first);
      cast_bundle(rays.subspan(first, count), hits.subspan(first, count));
    }
  }

 private:
  void cast_bundle(std::span<const CastRay> rays, std::span<CastHit> hits) const {
    if (options_.bundle == 1) return cast_single(rays[0], hits[0]);
    const bool is_fan = std::all_of(rays.begin(), rays.end(), [&](const CastRay& ray) {
      return is_same(ray.origin, rays[0].origin) && ray.t_min == rays[0].t_min;
    });
    if (is_fan && rays[0].t_min >= 0) {
      trace(fan_of(rays), rays, hits);
    } else {
      trace(packet_of(rays), rays, hits);
    }
  }

  void cast_single(const CastRay& ray, CastHit& hit) const {
    const Vec3f o = ray.origin, d = ray.direction;
    const SingleRay single{{o.x, o.y, o.z}, {d.x, d.y, d.z}, ray.t_min, ray.t_max};
    if (options_.is_any) {
      hit = {};
      hit.is_hit = tracer_.occluded(single);
      return;
    }
    const SingleHit found = tracer_.closest(single);
    hit = hit_of(ray, found.primitive, found.t);
  }

  static FanPacket fan_of(std::span<const CastRay> rays) {
    FanPacket packet;
    for (int a = 0; a < 3; ++a) packet.origin[a] = rays[0].origin[a];
    packet.t_min = rays[0].t_min;
    fill(rays, packet);
    return packet;
  }

  static RayPacket packet_of(std::span<const CastRay> rays) {
    RayPacket packet;
    for (std::size_t i = 0; i < rays.size(); ++i) {
      for (int a = 0; a < 3; ++a) packet.origin[a][i] = rays[i].origin[a];
      packet.t_min[i] = rays[i].t_min;
    }
    fill(rays, packet);
    return packet;
  }

  template <typename Packet>
  static void fill(std::span<const CastRay> rays, Packet& packet) {
    packet.active = ~std::uint64_t{0} >> (kPacketRays - static_cast<int>(rays.size()));
    for (std::size_t i = 0; i < rays.size(); ++i) {
      for (int a = 0; a < 3; ++a) packet.direction[a][i] = rays[i].direction[a];
      packet.t_max[i] = rays[i].t_max;
    }
  }

  template <typename Packet>
  void trace(const Packet& packet, std::span<const CastRay> rays, std::span<CastHit> hits) const {
    if (options_.is_any) {
      const std::uint64_t blocked = tracer_.occluded(packet);
      for (std::size_t i = 0; i < rays.size(); ++i) {
        hits[i] = {};
        hits[i].is_hit = (blocked >> i & 1u) != 0;
      }
      return;
    }
    PacketHits found;
    tracer_.closest(packet, found);
    for (std::size_t i = 0; i < rays.size(); ++i)
      hits[i] = hit_of(rays[i], found.primitive[i], found.t[i]);
  }

  CastHit hit_of(const CastRay& ray, std::uint32_t primitive, float t) const {
    CastHit hit;
    if (primitive == kNoPrimitive) return hit;
    if (scene_.patches != nullptr) {
      const std::uint32_t instance = scene_.triangles.instance_of(primitive);
      if (scene_.is_patched(instance)) return hit_of_patch(ray, instance, primitive, t);
      hit = hit_of_triangle(ray, primitive, t);
      hit.primitive =
          static_cast<std::uint32_t>(primitive - scene_.triangles.instance_first[instance] +
                                     scene_.geometry->first_number[instance]);
      return hit;
    }
    return hit_of_triangle(ray, primitive, t);
  }

  CastHit hit_of_patch(const CastRay& ray, std::uint32_t instance, std::uint32_t primitive,
                       float t) const {
    const PartInWorld there = scene_.part(instance, primitive);
    const float origin[3] = {ray.origin.x, ray.origin.y, ray.origin.z};
    const float direction[3] = {ray.direction.x, ray.direction.y, ray.direction.z};
    const PatchSurfacePoint at =
        patch_point(*there.patch, *there.part, origin, direction, t, options_.patch_method);
    const std::uint64_t number =
        scene_.patch_of_part(instance, primitive) + scene_.geometry->first_number[instance];
    return {true, static_cast<std::uint32_t>(number), t, at.u, at.v, at.normal};
  }

  CastHit hit_of_triangle(const CastRay& ray, std::uint32_t primitive, float t) const {
    const Vec3f a = scene_.triangles.vertex(primitive, 0),
                b = scene_.triangles.vertex(primitive, 1),
                c = scene_.triangles.vertex(primitive, 2);
    const Vec2f uv = barycentric(ray.origin, ray.direction, a, b, c);
    return {true, primitive, t, uv.x, uv.y, normal_of(a, b, c)};
  }

  const PreparedScene::Impl& scene_;
  SceneTracer tracer_;
  const CastOptions& options_;
};

}  // namespace

void cast_rays(const PreparedScene& scene, std::span<const CastRay> rays,
               const CastOptions& options, std::span<CastHit> hits) {
  TESSERA_CHECK_EQ(rays.size(), hits.size());
  const Caster caster(scene.impl(), options);
  const auto tasks = static_cast<int>((rays.size() + kRaysPerTask - 1) / kRaysPerTask);
  run_tasks(tasks, options.threads, [&](int task) {
    const std::size_t first = static_cast<std::size_t>(task) * kRaysPerTask;
    const std::size_t count = std::min(kRaysPerTask, rays.size() - first);
    caster.cast(rays.subspan(first, count), hits.subspan(first, count));
  });
}

}  // namespace tessera::core
