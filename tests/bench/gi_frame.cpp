// SPDX-License-Identifier: Apache-2.0
#include "tests/bench/gi_frame.h"

#include <x86intrin.h>

#include <algorithm>
#include <numeric>
#include <utility>

#include "common/base/cpu_count.h"
#include "common/frame/tile_grid.h"
#include "slave/core/accel/run_tasks.h"
#include "slave/core/integrate/frame_light.h"
#include "slave/core/integrate/igi/gi_tile.h"
#include "slave/core/integrate/tile_renderer.h"
#include "slave/core/kernels/kernel_table.h"
#include "slave/core/scene/prepared_scene_impl.h"
#include "tests/bench/contender.h"

namespace tessera::bench {
namespace {

// State of the kernels below that keep time. One object is enough, since the benchmark renders with
// one thread at a time.
struct Watch {
  const core::KernelTable* real = nullptr;
  std::array<std::uint64_t, kGiParts> cycles{};
  // Shadow rays that are recorded:
  Workload* rays = nullptr;
  int one_in = 1, seen = 0;
  const core::FanTargets* pending = nullptr;  // grouped, origin not known yet
};
Watch watch;

class Timed {
 public:
  explicit Timed(GiPart part) : part_(static_cast<std::size_t>(part)), start_(__rdtsc()) {}
  ~Timed() { watch.cycles[part_] += __rdtsc() - start_; }

 private:
  std::size_t part_;
  std::uint64_t start_;
};

void group_fans(core::FanTargets& targets) {
  const Timed timed(GiPart::kGroup);
  watch.real->group_fans(targets);
  if (watch.rays != nullptr && ++watch.seen % watch.one_in == 0) watch.pending = &targets;
}
void record(const float* origin) {
  const core::FanTargets& targets = *watch.pending;
  watch.pending = nullptr;
  watch.rays->blocks.emplace_back();
  RayBlock& block = watch.rays->blocks.back();
  block.count = targets.count;
  watch.rays->ray_count += static_cast<std::uint64_t>(targets.count);
  for (int i = 0; i < targets.count; ++i) {
    for (int a = 0; a < 3; ++a) {
      block.origin[a][i] = origin[a] + targets.direction[a][i];
      block.direction[a][i] = -targets.direction[a][i];
    }
    block.t_max[i] = 1 - 0x1p-20f;  // ends before the VPL's own surface
  }
}

template <class View>
void enter_fans(const View& view, const core::FanWindow& window, core::FanEntry& entry) {
  const Timed timed(GiPart::kCamera);
  kernels_of(*watch.real, view).enter_fans(view, window, entry);
}
template <class View>
void closest_fan(const View& view, const core::Fan& rays, const core::HitArrays& hits) {
  const Timed timed(GiPart::kCamera);
  kernels_of(*watch.real, view).closest_fan(view, rays, hits);
}
template <class View>
void occluded_fans(const View& view, const core::ShadowFans& fans, std::uint64_t* blocked) {
  if (watch.pending != nullptr) record(fans.origin);
  const Timed timed(GiPart::kShadow);
  kernels_of(*watch.real, view).occluded_fans(view, fans, blocked);
}
template <class View>
void occluded_many(const View& view, const core::ManyRays& rays, std::uint64_t* blocked) {
  watch.pending = nullptr;  // parallel rays have no common origin
  const Timed timed(GiPart::kShadow);
  kernels_of(*watch.real, view).occluded_many(view, rays, blocked);
}

template <class View>
void closest_many(const View& view, const core::ManyRays& rays, const core::HitArrays& hits) {
  const Timed timed(GiPart::kBounce);
  kernels_of(*watch.real, view).closest_many(view, rays, hits);
}

template <class View>
void put_watch(core::ViewKernels<View>& kernels) {
  kernels.enter_fans = enter_fans<View>;
  kernels.closest_fan = closest_fan<View>;
  kernels.occluded_fans = occluded_fans<View>;
  kernels.occluded_many = occluded_many<View>;
  kernels.closest_many = closest_many<View>;
}

// Replaces a kernel by itself with its time taken.
template <GiPart kPart, auto kKernel, class Result, class... Args>
void put_timed(core::KernelTable& table, Result (*core::KernelTable::*)(Args...)) {
  table.*kKernel = [](Args... args) -> Result {
    const Timed timed(kPart);
    return (watch.real->*kKernel)(args...);
  };
}
template <GiPart kPart, auto... kKernels>
void put_timed(core::KernelTable& table) {
  (put_timed<kPart, kKernels>(table, kKernels), ...);
}

// The same for the kernels of a slot of BSDFs, where it has them.
template <int kSlot, auto kKernel, class... Args>
void put_timed(core::KernelTable& table, void (*core::BsdfKernel::*)(Args...)) {
  if (table.bsdfs.of[kSlot].*kKernel == nullptr) return;
  table.bsdfs.of[kSlot].*kKernel = [](Args... args) {
    const Timed timed(GiPart::kSample);
    (watch.real->bsdfs.of[kSlot].*kKernel)(args...);
  };
}
template <int... kSlots>
void put_timed_bsdfs(core::KernelTable& table, std::integer_sequence<int, kSlots...>) {
  constexpr auto kSample = &core::BsdfKernel::sample, kEvaluate = &core::BsdfKernel::evaluate;
  (put_timed<kSlots, kSample>(table, kSample), ...);
  (put_timed<kSlots, kEvaluate>(table, kEvaluate), ...);
}

core::KernelTable watched(const core::KernelTable& real) {
  core::KernelTable table = real;
  table.group_fans = group_fans;
  using T = core::KernelTable;
  put_timed<GiPart::kStrength, &T::begin_gather, &T::bound_points>(table);
  put_timed<GiPart::kAdd, &T::end_gather>(table);
  put_timed<GiPart::kFilter, &T::filter>(table);
  put_timed<GiPart::kSurface, &T::fan_points, &T::packet_points, &T::surface_detail, &T::noise>(
      table);
  put_timed<GiPart::kSample, &T::camera_rays, &T::sample_points, &T::emitter_samples, &T::sky_light,
            &T::sky_samples>(table);
  put_timed_bsdfs(table, std::make_integer_sequence<int, core::kBsdfSlots>());
  put_watch(table.bvh8);
  put_watch(table.bvh16);
  put_watch(table.kd8);
  put_watch(table.kd16);
  return table;
}

// Copies a tile to its place.
void place(const TileRect& rect, const std::vector<float>& tile, int width_px,
           std::vector<float>& rgb) {
  const auto row = 3 * static_cast<std::size_t>(rect.width_px);
  for (int y = 0; y < rect.height_px; ++y) {
    const auto from = tile.begin() + static_cast<std::ptrdiff_t>(static_cast<std::size_t>(y) * row);
    std::copy_n(from, row, rgb.begin() + 3 * ((rect.y_px + y) * width_px + rect.x_px));
  }
}

std::size_t floats_of(int width_px, int height_px) {
  return 3 * static_cast<std::size_t>(width_px) * static_cast<std::size_t>(height_px);
}

}  // namespace

const char* gi_part_name(GiPart part) {
  constexpr const char* kNames[] = {"camera rays", "shadow rays", "grouping",          "strengths",
                                    "sums",        "filter",      "bounces",           "surfaces",
                                    "samples",     "walks",       "outside of kernels"};
  return kNames[static_cast<int>(part)];
}

GiFrame render_gi(const core::PreparedScene& scene, const FrameSettings& settings, Isa isa) {
  GiFrame frame;
  frame.rgb.resize(floats_of(settings.width_px, settings.height_px));
  watch.real = &core::kernels_for(isa);
  watch.cycles = {};
  const core::KernelTable table = watched(*watch.real);
  const core::SceneTracer tracer(scene.impl().index, table);
  const core::CameraRays camera(settings.camera, settings.width_px, settings.height_px);
  const TileGrid grid(settings.width_px, settings.height_px, settings.tile_edge_px);
  core::FrameLight light;
  const core::RenderContext context{scene.impl(), tracer, settings, camera, light};
  core::GiTile renderer;
  std::vector<float> tile;
  const double start = thread_cpu_seconds();
  const std::uint64_t start_cycles = __rdtsc();
  light.vpls(context, frame.rays.secondary);
  const std::uint64_t walk_cycles =
      std::accumulate(watch.cycles.begin(), watch.cycles.end(), std::uint64_t{0});
  watch.cycles = {};
  for (TileIndex i = 0; i < grid.tile_count(); ++i) {
    const TileRect rect = grid.rect(i);
    tile.resize(floats_of(rect.width_px, rect.height_px));
    frame.rays += renderer.render(context, rect, tile);
    place(rect, tile, settings.width_px, frame.rgb);
  }
  const auto all = static_cast<double>(__rdtsc() - start_cycles);
  frame.cpu_seconds = thread_cpu_seconds() - start;
  double rest = 1;
  watch.cycles[static_cast<std::size_t>(GiPart::kWalks)] = walk_cycles;
  for (std::size_t part = 0; part + 1 < kGiParts; ++part) {
    frame.share[part] = static_cast<double>(watch.cycles[part]) / all;
    rest -= frame.share[part];
  }
  frame.share[static_cast<std::size_t>(GiPart::kRest)] = rest;
  return frame;
}

Workload shadow_rays_of(const core::PreparedScene& scene, const FrameSettings& settings, Isa isa,
                        int one_in) {
  Workload work;
  work.kind = RayKind::kShadow;
  watch.rays = &work;
  watch.one_in = one_in;
  watch.seen = 0;
  render_gi(scene, settings, isa);
  watch.rays = nullptr;
  watch.pending = nullptr;
  return work;
}

std::vector<float> render_fast(const core::PreparedScene& scene, const FrameSettings& settings,
                               Isa isa) {
  std::vector<float> rgb(floats_of(settings.width_px, settings.height_px));
  const TileGrid grid(settings.width_px, settings.height_px, settings.tile_edge_px);
  core::FrameLight light;
  core::run_tasks(static_cast<int>(grid.tile_count()), available_cpu_count(), [&](int i) {
    static thread_local core::TileRenderer renderer;
    const TileRect rect = grid.rect(static_cast<TileIndex>(i));
    std::vector<float> tile(floats_of(rect.width_px, rect.height_px));
    renderer.render(scene, settings, isa, rect, tile, nullptr, &light);
    place(rect, tile, settings.width_px, rgb);
  });
  return rgb;
}

double median(std::vector<double> values) {
  std::sort(values.begin(), values.end());
  const std::size_t n = values.size();
  return n == 0 ? 0 : (values[n / 2] + values[(n - 1) / 2]) / 2;
}

}  // namespace tessera::bench
