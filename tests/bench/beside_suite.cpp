// SPDX-License-Identifier: Apache-2.0
#include "tests/bench/beside_suite.h"

#include <algorithm>
#include <atomic>
#include <cstdio>
#include <memory>
#include <thread>
#include <utility>

#include "common/base/bounded_queue.h"
#include "common/base/json.h"
#include "common/scene/scene_codec.h"
#include "slave/render_service.h"
#include "slave/scene_builder.h"
#include "tests/bench/contender.h"
#include "tests/bench/deform_scene.h"

namespace tessera::bench {
namespace {

constexpr int kVersions = 4;
constexpr float kFramesPerSecond = 24;
constexpr std::size_t kTilesAhead = 64;  // that wait to be rendered

double median(std::vector<double> values) {
  std::sort(values.begin(), values.end());
  return values[values.size() / 2];
}

wire::FrameBegin frame_of(const Deforming& scene, const CoreSuiteOptions& options) {
  wire::FrameBegin begin;
  begin.isa = options.isa;
  begin.settings.width_px = begin.settings.height_px = options.size_px / 2;
  begin.settings.tile_edge_px = 32;
  begin.settings.samples_per_pixel = 4;
  begin.settings.renderer = Renderer::kDirect;
  begin.settings.camera = scene.camera;
  return begin;
}

// A slave's threads, without a master: frames of one scene are rendered, and others are built.
class Slave {
 public:
  Slave(int threads, std::vector<EncodedScene> versions)
      : versions_(std::move(versions)),
        built_(kVersions),
        done_(kTilesAhead),
        builder_({threads, nullptr, core::Structure::kAuto},
                 [this](slave::BuildOutcome outcome) { on_built(std::move(outcome)); }),
        render_(
            threads, {}, coder_,
            [this](const slave::TileJob&, std::optional<wire::TileResult>) {
              (void)done_.try_push(0);
            },
            [this, threads](int idle) { builder_.set_rendering(threads - idle); }) {}

  // Returns: how long the build took.
  Result<double> build() {
    push();
    auto outcome = built_.pop();
    if (!outcome->scene.is_ok()) return outcome->scene.status();
    scene_ = *outcome->scene;
    return outcome->seconds;
  }

  // Renders frames of the scene that was built first. Returns: seconds.
  double render(const wire::FrameBegin& begin, int frames) {
    const auto frame = std::make_shared<slave::FrameWork>(begin, scene_, 1);
    const std::uint32_t tiles = frame->grid.tile_count();
    const std::size_t all = static_cast<std::size_t>(frames) * tiles;
    const double begun = wall_seconds();
    std::size_t sent = 0;
    for (std::size_t done = 0; done < all; ++done) {
      while (sent < all && sent - done < kTilesAhead)
        (void)render_.queue().try_push({frame, static_cast<TileIndex>(sent++ % tiles), 1, {}});
      (void)done_.pop();
    }
    return wall_seconds() - begun;
  }

  // Builds one version after the other from now on, until stop_builds().
  void start_builds() {
    is_building_ = true;
    push();
  }
  void stop_builds() {
    is_building_ = false;
    (void)built_.pop();
  }
  // Returns: builds since the last call, and the seconds that they took.
  std::pair<int, double> take_builds() { return {count_.exchange(0), seconds_.exchange(0)}; }
  void push() {
    const auto version = ++version_;
    (void)builder_.try_push({1, version, versions_[version % versions_.size()]});
  }
  double finish_build() { return built_.pop()->seconds; }

 private:
  void on_built(slave::BuildOutcome outcome) {
    ++count_;
    seconds_ = seconds_ + outcome.seconds;
    if (is_building_) return push();
    (void)built_.try_push(std::move(outcome));
  }

  const std::vector<EncodedScene> versions_;
  std::shared_ptr<const core::PreparedScene> scene_;
  std::atomic<bool> is_building_ = false;
  std::atomic<int> count_ = 0;
  std::atomic<double> seconds_ = 0;
  std::atomic<SceneVersion> version_ = 0;
  BoundedQueue<slave::BuildOutcome> built_;
  BoundedQueue<int> done_;
  slave::PixelCoder coder_;
  slave::SceneBuilder builder_;
  slave::RenderService render_;
};

// Seconds, an entry each repeat.
struct Times {
  std::vector<double> lost, alone, beside, caught_up;
};

Status measure(Slave& slave, const wire::FrameBegin& begin, int frames, Times& times) {
  const double undisturbed = slave.render(begin, frames);
  slave.start_builds();
  slave.take_builds();
  const double disturbed = slave.render(begin, frames);
  const auto [count, seconds] = slave.take_builds();
  slave.stop_builds();
  times.lost.push_back(1 - undisturbed / disturbed);
  if (count > 0) times.beside.push_back(seconds / count);
  auto alone = slave.build();
  if (!alone.is_ok()) return alone.status();
  times.alone.push_back(*alone);
  // A build that is begun beside a frame, which ends before it does.
  slave.push();
  const double begun = wall_seconds();
  (void)slave.render(begin, 1);
  const double frame = wall_seconds() - begun;
  times.caught_up.push_back(std::max(0.0, slave.finish_build() - frame));
  return Status::ok();
}

Result<std::string> run_scene(const Deforming& scene, const CoreSuiteOptions& options) {
  std::vector<EncodedScene> versions;
  SceneEncoder encoder;
  for (int v = 0; v < kVersions; ++v)
    versions.push_back(encoder.encode(scene.at(static_cast<float>(v) / kFramesPerSecond)));
  const int threads = std::max(1, static_cast<int>(std::thread::hardware_concurrency()));
  Slave slave(threads, std::move(versions));
  for (int v = 0; v < 2; ++v) {
    if (auto built = slave.build(); !built.is_ok()) return built.status();
  }
  const wire::FrameBegin begin = frame_of(scene, options);
  const double frame = slave.render(begin, 1);
  const int frames = options.is_quick ? 1 : std::max(1, static_cast<int>(1.5 / frame));
  Times times;
  for (int repeat = 0; repeat < options.repeats; ++repeat)
    TESSERA_RETURN_IF_ERROR(measure(slave, begin, frames, times));
  const double beside = times.beside.empty() ? 0 : median(times.beside);
  std::printf(
      "\n%s: a frame %.1f ms, builds take %.1f %% of render speed; a build takes %.1f ms "
      "alone, %.1f beside rendering, %.1f after a frame that it was begun beside\n",
      scene.name.c_str(), 1e3 * frame, 100 * median(times.lost), 1e3 * median(times.alone),
      1e3 * beside, 1e3 * median(times.caught_up));
  JsonObject json;
  json.add("scene", scene.name)
      .add("threads", threads)
      .add("frame_seconds", frame)
      .add("lost_share", median(times.lost))
      .add("alone_seconds", median(times.alone))
      .add("beside_seconds", beside)
      .add("caught_up_seconds", median(times.caught_up));
  return json.text();
}

}  // namespace

Status run_beside_suite(const CoreSuiteOptions& options, std::vector<std::string>& json) {
  std::vector<Deforming> scenes = {waves()};
  if (!options.is_quick) scenes.push_back(swell());
  for (const Deforming& scene : scenes) {
    Result<std::string> row = run_scene(scene, options);
    if (!row.is_ok()) return row.status();
    json.push_back(std::move(*row));
  }
  return Status::ok();
}

}  // namespace tessera::bench
