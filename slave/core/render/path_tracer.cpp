#include "slave/core/render/path_tracer.h"

#include <limits>

#include "slave/core/geometry/barycentric.h"
#include "slave/core/sampling/hemisphere.h"
#include "slave/core/sampling/sample_sequence.h"

namespace tessera::core {
namespace {

// Keys of a depth are mixed from the pixel's; each use of them has a number of its own.
constexpr std::uint32_t kDimensionScatter = 0x40000001u, kDimensionNextDepth = 0x40000003u;

}  // namespace

// From the surfaces of a batch, in their order.
struct PathTracer::Rays {
  int count = 0;
  Vec3f start[kBatchMax], direction[kBatchMax];
  Vec3f weight[kBatchMax];  // of what the ray meets, in the pixel
  std::uint16_t pixel[kBatchMax];
  std::uint32_t key[kBatchMax];
};

PathTracer::PathTracer() : rays_(std::make_unique<Rays>()) {}
PathTracer::~PathTracer() = default;

void PathTracer::begin(const PreparedScene::Impl& scene, const SceneTracer& tracer, int bounces,
                       const std::atomic<bool>* is_cancelled) {
  scene_ = &scene;
  tracer_ = &tracer;
  bounces_ = bounces;
  is_cancelled_ = is_cancelled;
  direct_.begin(scene, tracer, 1, DirectLight::Kind::kPartOfPath, is_cancelled);
}

RayCounts PathTracer::add(SurfaceBatch& batch, Vec3f* radiance) {
  RayCounts counts;
  counts.shadow += direct_.add(batch, radiance);
  const int bounces = scene_->lights.has_environment ? bounces_ + 1 : bounces_;
  for (int depth = 1; depth <= bounces && batch.count > 0 && !is_over(); ++depth) {
    scatter(batch, static_cast<std::uint32_t>(depth));
    counts.secondary += follow(batch, radiance);
    // Where light of the environment is the last that counts, surfaces have nothing more to add.
    if (depth <= bounces_) counts.shadow += direct_.add(batch, radiance);
  }
  return counts;
}

// A surface's albedo holds the path's weight up to it: a direction of density cosine / pi leaves
// albedo as the weight of the next.
void PathTracer::scatter(const SurfaceBatch& batch, std::uint32_t depth) {
  Rays& rays = *rays_;
  rays.count = 0;
  for (int i = 0; i < batch.count; ++i) {
    const Surface& s = batch.surface[i];
    if (is_black(s.albedo)) continue;
    const std::uint32_t key = hash_combine(batch.key[i], kDimensionNextDepth + depth);
    const Vec2f x = shuffled_2d(hash_combine(key, kDimensionScatter), batch.sample_index);
    const Vec3f direction = cosine_direction(s.shading_normal, x);
    if (!(dot(direction, s.normal) > 0)) continue;  // below the surface, by an interpolated normal
    const int ray = rays.count++;
    rays.start[ray] = s.point + s.normal * s.offset;
    rays.direction[ray] = direction;
    rays.weight[ray] = s.albedo;
    rays.pixel[ray] = batch.pixel[i];
    rays.key[ray] = key;
  }
}

// Replaces the batch by what the rays hit. Returns: rays traced.
std::uint64_t PathTracer::follow(SurfaceBatch& batch, Vec3f* radiance) {
  const Rays& rays = *rays_;
  batch.count = 0;
  RayPacket packet;
  PacketHits hits;
  std::fill_n(packet.t_min, kPacketRays, 0.0f);
  std::fill_n(packet.t_max, kPacketRays, std::numeric_limits<float>::infinity());
  for (int first = 0; first < rays.count && !is_over(); first += kPacketRays) {
    const int count = std::min(kPacketRays, rays.count - first);
    packet.active = ~std::uint64_t{0} >> (kPacketRays - count);
    for (int i = 0; i < count; ++i) {
      for (int a = 0; a < 3; ++a) {
        packet.origin[a][i] = rays.start[first + i][a];
        packet.direction[a][i] = rays.direction[first + i][a];
      }
    }
    tracer_->closest(packet, hits);
    for (int i = 0; i < count; ++i) arrive(batch, first + i, hits.primitive[i], radiance);
  }
  return static_cast<std::uint64_t>(rays.count);
}

// Emission is not counted here: the surface before has sampled it.
void PathTracer::arrive(SurfaceBatch& batch, int ray, std::uint32_t triangle, Vec3f* radiance) {
  const Rays& rays = *rays_;
  if (triangle == kNoPrimitive) {
    Vec3f& sum = radiance[rays.pixel[ray]];
    sum = sum + rays.weight[ray] * scene_->lights.environment;
    return;
  }
  const TriangleStore& triangles = scene_->triangles;
  const Vec3f d = rays.direction[ray];
  const Vec2f uv = barycentric(rays.start[ray], d, triangles.vertex(triangle, 0),
                               triangles.vertex(triangle, 1), triangles.vertex(triangle, 2));
  Surface& s = batch.surface[batch.count];
  s = surface_at(*scene_, triangle, uv.x, uv.y, d);
  s.albedo = s.albedo * rays.weight[ray];
  batch.key[batch.count] = rays.key[ray];
  batch.pixel[batch.count++] = rays.pixel[ray];
}

}  // namespace tessera::core
