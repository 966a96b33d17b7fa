// SPDX-License-Identifier: Apache-2.0
#include "slave/core/integrate/planes/plane_tile.h"

#include <algorithm>
#include <array>
#include <bit>
#include <limits>

#include "common/base/check.h"
#include "slave/core/integrate/frame_light.h"
#include "slave/core/integrate/planes/plane_values.h"
#include "slave/core/integrate/tile_parts.h"
#include "slave/core/kernels/kernel_table.h"
#include "slave/core/ray/ray_bits.h"
#include "slave/core/scene/met_surfaces.h"
#include "slave/core/trace/scene_tracer.h"

namespace tessera::core {
namespace {

// A plane as the loop over samples needs it.
struct OnePlane {
  PlaneValue value = nullptr;
  PlaneMerge merge = PlaneMerge::kMean;
  std::size_t channels = 0;
  float* to = nullptr;  // of the tile
};

}  // namespace

struct PlaneTile::Memory {
  PacketHits hits;
  MetSurfaces::Memory met;
  Surface surface[kPacketRays];
  float nearest[kBatchMax];  // distance of the pixel's nearest hit so far, by pixel of the part
};

// The work on one tile.
class PlaneTile::Work {
 public:
  // Shape: values [tile.pixel_count() * channel_count(settings.planes)].
  Work(const RenderContext& context, Memory& memory, const TileRect& tile, std::span<float> values);

  // Returns: rays traced.
  std::uint64_t render();

 private:
  std::span<const OnePlane> all() const { return std::span(planes_).first(plane_count_); }
  CameraSample sample_of(int ray);
  void add(const CameraSample& sample, float distance, std::size_t pixel, float& nearest_so_far,
           bool is_first) const;
  void add_packet(int x_px, int y_px, bool is_first);
  std::uint64_t render_part(const TileRect& part);

  const RenderContext& context_;
  Memory& memory_;
  const TileRect tile_;
  const CameraSample miss_;  // of a ray that meets nothing
  CameraPacket camera_;
  MetSurfaces met_;
  InstanceFinder instances_;
  RayCone cones_[kPacketRays];
  Surface* to_[kPacketRays];
  std::array<OnePlane, kPlanesMax> planes_;
  std::size_t plane_count_ = 0;
};

PlaneTile::Work::Work(const RenderContext& context, Memory& memory, const TileRect& tile,
                      std::span<float> values)
    : context_(context),
      memory_(memory),
      tile_(tile),
      miss_{nullptr, context.settings.camera.eye,
            normalize(context.settings.camera.target - context.settings.camera.eye), 0, 0},
      camera_(context),
      met_(context.scene, context.tracer, memory.met),
      instances_(context.scene.triangles) {
  std::fill_n(cones_, kPacketRays, camera_.cone());
  for (int ray = 0; ray < kPacketRays; ++ray) to_[ray] = &memory.surface[ray];
  const auto pixel_count = static_cast<std::size_t>(tile.pixel_count());
  std::size_t before = 0;
  context.settings.planes.for_each([&](Plane plane) {
    const PlaneRow& row = plane_row(plane);
    planes_[plane_count_++] = {plane_value(plane), row.merge, row.channel_count(),
                               values.data() + before * pixel_count};
    before += row.channel_count();
  });
}

CameraSample PlaneTile::Work::sample_of(int ray) {
  CameraSample sample = miss_;
  if (memory_.hits.primitive[ray] == kNoPrimitive) return sample;
  const auto material = memory_.surface[ray].material - context_.scene.materials.data();
  sample.surface = &memory_.surface[ray];
  sample.object = instances_.of(memory_.hits.primitive[ray]) + 1;
  sample.material = static_cast<std::uint32_t>(material) + 1;
  return sample;
}

void PlaneTile::Work::add(const CameraSample& sample, float distance, std::size_t pixel,
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

// Adds the packet whose corner is (x_px, y_px) of the tile.
void PlaneTile::Work::add_packet(int x_px, int y_px, bool is_first) {
  met_.find(camera_.rays, memory_.hits);
  met_.make_seen(camera_.rays, memory_.hits, met_.points().met, cones_, to_);
  for_each_ray(camera_.rays.active, [&](int ray) {
    const int x = x_px + camera_.column(ray), y = y_px + camera_.row(ray);
    const CameraSample sample = sample_of(ray);
    const float distance = sample.surface != nullptr ? met_.points().distance[ray]
                                                     : std::numeric_limits<float>::infinity();
    const int in_part = y % kPartEdgePx * kPartEdgePx + x % kPartEdgePx;
    add(sample, distance, static_cast<std::size_t>(y * tile_.width_px + x),
        memory_.nearest[in_part], is_first);
  });
}

// part: of the tile, at a multiple of kPartEdgePx. Returns: rays traced.
std::uint64_t PlaneTile::Work::render_part(const TileRect& part) {
  const int left = tile_.x_px + part.x_px, top = tile_.y_px + part.y_px;
  std::uint64_t rays = 0;
  camera_.enter({left, top, part.width_px, part.height_px});
  for (std::uint32_t sample = 0;
       sample < static_cast<std::uint32_t>(context_.settings.samples_per_pixel); ++sample) {
    for (int y = 0; y < part.height_px; y += camera_.height_px()) {
      for (int x = 0; x < part.width_px; x += camera_.width_px()) {
        if (context_.is_over()) return rays;
        camera_.set(left + x, top + y, sample);
        context_.tracer.closest(camera_.rays, memory_.hits);
        rays += static_cast<std::uint64_t>(std::popcount(camera_.rays.active));
        add_packet(part.x_px + x, part.y_px + y, sample == 0);
      }
    }
  }
  return rays;
}

// Renders all parts, then turns sums of samples into their means.
std::uint64_t PlaneTile::Work::render() {
  std::uint64_t rays = 0;
  for (int y = 0; y < tile_.height_px; y += kPartEdgePx) {
    for (int x = 0; x < tile_.width_px; x += kPartEdgePx) {
      rays += render_part({x, y, std::min(kPartEdgePx, tile_.width_px - x),
                           std::min(kPartEdgePx, tile_.height_px - y)});
    }
  }
  const float scale = 1 / static_cast<float>(context_.settings.samples_per_pixel);
  const auto pixel_count = static_cast<std::size_t>(tile_.pixel_count());
  for (const OnePlane& plane : all()) {
    if (plane.merge != PlaneMerge::kMean) continue;
    for (std::size_t i = 0; i < pixel_count * plane.channels; ++i) plane.to[i] *= scale;
  }
  return rays;
}

PlaneTile::PlaneTile() = default;
PlaneTile::~PlaneTile() = default;

RayCounts PlaneTile::render(const PreparedScene& prepared, const FrameSettings& settings, Isa isa,
                            const TileRect& rect, std::span<float> to,
                            const std::atomic<bool>* is_cancelled) {
  TESSERA_CHECK_EQ(to.size(),
                   static_cast<std::size_t>(rect.pixel_count()) * channel_count(settings.planes));
  if (memory_ == nullptr) memory_ = std::make_unique<Memory>();
  const PreparedScene::Impl& scene = prepared.impl();
  const SceneTracer tracer(scene.index, kernels_for(isa), scene.alpha.get(), settings.patch_method);
  const CameraRays camera(settings.camera, settings.width_px, settings.height_px);
  FrameLight none;
  const RenderContext context{scene, tracer, settings, camera, none, is_cancelled};
  RayCounts counts;
  counts.primary = Work(context, *memory_, rect, to).render();
  return counts;
}

}  // namespace tessera::core
