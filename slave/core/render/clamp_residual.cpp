#include "slave/core/render/clamp_residual.h"

#include <algorithm>
#include <bit>
#include <cmath>

#include "slave/core/geometry/barycentric.h"
#include "slave/core/render/path_tracer.h"
#include "slave/core/sampling/hemisphere.h"
#include "slave/core/sampling/sample_sequence.h"

namespace tessera::core {
namespace {

// Keys of a pixel that no path uses.
constexpr std::uint32_t kDimensionRay = 0x10000001u, kDimensionPath = 0x10000003u;

}  // namespace

struct ClampResidual::Scratch {
  PathTracer paths;
  SurfaceBatch batch;  // what the rays have met; pixel: number of the point
  Vec3f light[kGatherMax];
  RayPacket rays;
  PacketHits hits;
};

ClampResidual::ClampResidual() : scratch_(std::make_unique<Scratch>()) {}
ClampResidual::~ClampResidual() = default;

void ClampResidual::begin(const PreparedScene::Impl& scene, const SceneTracer& tracer,
                          const GeometryBounds& bounds, int bounces,
                          const std::atomic<bool>* is_cancelled) {
  scene_ = &scene;
  tracer_ = &tracer;
  bounds_ = bounds;
  bounces_ = bounces;
  scratch_->paths.begin(scene, tracer, std::max(0, bounces_ - 1), is_cancelled);
  std::fill_n(scratch_->rays.t_min, kPacketRays, 0.0f);
  std::fill_n(scratch_->rays.t_max, kPacketRays, 1 / std::sqrt(bounds_.vpl));
}

RayCounts ClampResidual::add(GatherPoints& points, std::uint32_t sequence_index) {
  Scratch& s = *scratch_;
  RayCounts counts;
  s.batch.count = 0;
  s.batch.sample_index = sequence_index;
  std::fill_n(s.light, points.count, Vec3f{});
  for (int first = 0; first < points.count; first += kPacketRays) {
    follow(points, first, std::min(kPacketRays, points.count - first));
    counts.secondary += static_cast<std::uint64_t>(std::popcount(s.rays.active));
  }
  if (bounces_ > 0 && s.batch.count > 0) counts += s.paths.add(s.batch, s.light);
  for (int i = 0; i < points.count; ++i) {
    for (int c = 0; c < 3; ++c) points.light[c][i] += s.light[i][c];
  }
  return counts;
}

void ClampResidual::follow(const GatherPoints& points, int first, int count) {
  Scratch& s = *scratch_;
  Vec3f direction[kPacketRays];
  s.rays.active = 0;
  for (int i = 0; i < count; ++i) {
    const int p = first + i;
    const Vec3f normal{points.normal[0][p], points.normal[1][p], points.normal[2][p]};
    const Vec3f shading{points.shading[0][p], points.shading[1][p], points.shading[2][p]};
    direction[i] = cosine_direction(
        shading, shuffled_2d(hash_combine(points.key[p], kDimensionRay), s.batch.sample_index));
    if (!(dot(direction[i], normal) > 0)) continue;
    for (int a = 0; a < 3; ++a) {
      s.rays.origin[a][i] = points.point[a][p] + normal[a] * points.offset[p];
      s.rays.direction[a][i] = direction[i][a];
    }
    s.rays.active |= std::uint64_t{1} << i;
  }
  tracer_->closest(s.rays, s.hits);
  for (std::uint64_t left = s.rays.active; left != 0; left &= left - 1) {
    const int i = std::countr_zero(left);
    if (s.hits.primitive[i] != kNoPrimitive)
      arrive(points, first + i, s.hits.primitive[i], direction[i]);
  }
}

void ClampResidual::arrive(const GatherPoints& points, int point, std::uint32_t triangle,
                           Vec3f direction) {
  Scratch& s = *scratch_;
  const int i = point % kPacketRays;
  const Vec3f origin{s.rays.origin[0][i], s.rays.origin[1][i], s.rays.origin[2][i]};
  const TriangleStore& t = scene_->triangles;
  const Vec2f uv = barycentric(origin, direction, t.vertex(triangle, 0), t.vertex(triangle, 1),
                               t.vertex(triangle, 2));
  Surface y = surface_at(*scene_, triangle, uv.x, uv.y, direction);
  const Vec3f shading{points.shading[0][point], points.shading[1][point], points.shading[2][point]};
  const float distance = s.hits.t[i] * length(direction);
  const float geometry =
      dot(shading, direction) * -dot(y.normal, direction) / (distance * distance);
  if (!(geometry > bounds_.vpl)) return;
  if (geometry > bounds_.emitter)
    s.light[point] = s.light[point] + y.emission * (1 - bounds_.emitter / geometry);
  if (is_specular(y)) return;  // no VPL is there
  y.weight = y.weight * (1 - bounds_.vpl / geometry);
  SurfaceBatch& batch = s.batch;
  batch.surface[batch.count] = y;
  batch.key[batch.count] = hash_combine(points.key[point], kDimensionPath);
  batch.pixel[batch.count++] = static_cast<std::uint16_t>(point);
}

}  // namespace tessera::core
