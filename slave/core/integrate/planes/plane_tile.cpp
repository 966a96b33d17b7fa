// SPDX-License-Identifier: Apache-2.0
#include "slave/core/integrate/planes/plane_tile.h"

#include <algorithm>
#include <array>
#include <bit>
#include <limits>

#include "common/base/check.h"
#include "slave/core/integrate/camera_packet.h"
#include "slave/core/integrate/planes/plane_values.h"
#include "slave/core/kernels/kernel_table.h"
#include "slave/core/ray/ray_bits.h"
#include "slave/core/scene/met_surfaces.h"
#include "slave/core/trace/scene_tracer.h"

namespace tessera::core {
namespace {

constexpr int kPartEdgePx = 32;  // as CameraPacket::enter() likes it

// A plane as the loop over samples needs it.
struct OnePlane {
  PlaneValue value = nullptr;
  PlaneMerge merge = PlaneMerge::kMean;
  std::size_t channels = 0;
  float* to = nullptr;  // of the tile
};

// What the packets of a tile share.
struct TileWork {
  const PreparedScene::Impl& scene;
  const SceneTracer& tracer;
  const TileRect tile;
  const CameraSample miss;  // of a ray that meets nothing
  const std::uint32_t samples;
  const std::atomic<bool>* is_cancelled;

  bool is_over() const {
    return is_cancelled != nullptr && is_cancelled->load(std::memory_order_relaxed);
  }
};

}  // namespace

struct PlaneTile::Scratch {
  CameraPacket camera;
  PacketHits hits;
  MetSurfaces met;
  InstanceFinder instances;
  RayCone cones[kPacketRays];
  Surface surface[kPacketRays];
  Surface* to[kPacketRays];
  float nearest[kPartEdgePx * kPartEdgePx];  // distance of the pixel's nearest hit so far
  std::array<OnePlane, kPlanesMax> planes;
  std::size_t plane_count = 0;

  std::span<const OnePlane> all() const { return std::span(planes).first(plane_count); }
  void set_planes(PlaneSet set, std::size_t pixel_count, std::span<float> values);
  CameraSample sample_of(const TileWork& work, int ray);
  void add(const CameraSample& sample, float distance, std::size_t pixel, float& nearest_so_far,
           bool is_first) const;
  void add_packet(const TileWork& work, int x_px, int y_px, bool is_first);
  std::uint64_t render_part(const TileWork& work, const TileRect& part);
};

// Shape: values [pixel_count * channel_count(set)].
void PlaneTile::Scratch::set_planes(PlaneSet set, std::size_t pixel_count,
                                    std::span<float> values) {
  plane_count = 0;
  std::size_t before = 0;
  set.for_each([&](Plane plane) {
    const PlaneRow& row = plane_row(plane);
    planes[plane_count++] = {plane_value(plane), row.merge, row.channel_count(),
                             values.data() + before * pixel_count};
    before += row.channel_count();
  });
}

CameraSample PlaneTile::Scratch::sample_of(const TileWork& work, int ray) {
  CameraSample sample = work.miss;
  if (hits.primitive[ray] == kNoPrimitive) return sample;
  const auto material = surface[ray].material - work.scene.materials.data();
  sample.surface = &surface[ray];
  sample.object = instances.of(met.triangle(ray)) + 1;
  sample.material = static_cast<std::uint32_t>(material) + 1;
  return sample;
}

void PlaneTile::Scratch::add(const CameraSample& sample, float distance, std::size_t pixel,
                             float& nearest_so_far, bool is_first) const {
  const bool is_nearest = is_first || distance < nearest_so_far;
  if (is_nearest) nearest_so_far = distance;
  for (const OnePlane& plane : all()) {
    if (plane.merge == PlaneMerge::kNearest && !is_nearest) continue;
    float value[3] = {};
    plane.value(sample, value);
    float* const at = plane.to + pixel * plane.channels;
    const bool is_sum = !is_first && plane.merge != PlaneMerge::kNearest;
    for (std::size_t c = 0; c < plane.channels; ++c) at[c] = is_sum ? at[c] + value[c] : value[c];
  }
}

// The packet whose corner is (x_px, y_px) of the tile.
void PlaneTile::Scratch::add_packet(const TileWork& work, int x_px, int y_px, bool is_first) {
  met.find(camera.rays, hits);
  met.make_seen(met.points().met, cones, to);
  for_each_ray(camera.rays.active, [&](int ray) {
    const int x = x_px + camera.column(ray), y = y_px + camera.row(ray);
    const CameraSample sample = sample_of(work, ray);
    const float distance = sample.surface != nullptr ? met.points().distance[ray]
                                                     : std::numeric_limits<float>::infinity();
    const int in_part = y % kPartEdgePx * kPartEdgePx + x % kPartEdgePx;
    add(sample, distance, static_cast<std::size_t>(y * work.tile.width_px + x), nearest[in_part],
        is_first);
  });
}

// part: of the tile, at a multiple of kPartEdgePx. Returns: rays traced.
std::uint64_t PlaneTile::Scratch::render_part(const TileWork& work, const TileRect& part) {
  const int left = work.tile.x_px + part.x_px, top = work.tile.y_px + part.y_px;
  std::uint64_t rays = 0;
  camera.enter({left, top, part.width_px, part.height_px});
  for (std::uint32_t sample = 0; sample < work.samples; ++sample) {
    for (int y = 0; y < part.height_px; y += camera.height_px()) {
      for (int x = 0; x < part.width_px; x += camera.width_px()) {
        if (work.is_over()) return rays;
        camera.set(left + x, top + y, sample);
        work.tracer.closest(camera.rays, hits);
        rays += static_cast<std::uint64_t>(std::popcount(camera.rays.active));
        add_packet(work, part.x_px + x, part.y_px + y, sample == 0);
      }
    }
  }
  return rays;
}

PlaneTile::PlaneTile() = default;
PlaneTile::~PlaneTile() = default;

RayCounts PlaneTile::render(const PreparedScene& prepared, const FrameSettings& settings, Isa isa,
                            const TileRect& rect, std::span<float> to,
                            const std::atomic<bool>* is_cancelled) {
  const auto pixel_count = static_cast<std::size_t>(rect.pixel_count());
  TESSERA_CHECK_EQ(to.size(), pixel_count * channel_count(settings.planes));
  if (scratch_ == nullptr) scratch_ = std::make_unique<Scratch>();
  Scratch& s = *scratch_;
  const PreparedScene::Impl& scene = prepared.impl();
  const SceneTracer tracer(scene.index, kernels_for(isa), scene.alpha.get());
  const CameraRays camera(settings.camera, settings.width_px, settings.height_px);
  s.camera.begin(settings, camera, tracer);
  s.met.begin(scene, tracer.kernels());
  s.instances.begin(scene.triangles);
  std::fill_n(s.cones, kPacketRays, s.camera.cone());
  for (int ray = 0; ray < kPacketRays; ++ray) s.to[ray] = &s.surface[ray];
  s.set_planes(settings.planes, pixel_count, to);

  const Vec3f view = normalize(settings.camera.target - settings.camera.eye);
  const TileWork work{scene,
                      tracer,
                      rect,
                      {nullptr, settings.camera.eye, view, 0, 0},
                      static_cast<std::uint32_t>(settings.samples_per_pixel),
                      is_cancelled};
  RayCounts counts;
  for (int y = 0; y < rect.height_px; y += kPartEdgePx) {
    for (int x = 0; x < rect.width_px; x += kPartEdgePx) {
      counts.primary += s.render_part(work, {x, y, std::min(kPartEdgePx, rect.width_px - x),
                                             std::min(kPartEdgePx, rect.height_px - y)});
    }
  }
  const float scale = 1 / static_cast<float>(work.samples);
  for (const OnePlane& plane : s.all()) {
    if (plane.merge != PlaneMerge::kMean) continue;
    for (std::size_t i = 0; i < pixel_count * plane.channels; ++i) plane.to[i] *= scale;
  }
  return counts;
}

}  // namespace tessera::core
