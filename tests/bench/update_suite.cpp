// SPDX-License-Identifier: Apache-2.0
#include "tests/bench/update_suite.h"

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <memory>
#include <thread>
#include <utility>

#include "common/base/json.h"
#include "common/base/log.h"
#include "master/session/session.h"
#include "tests/bench/contender.h"
#include "tests/bench/slave_process.h"
#include "tests/bench/update_scene.h"

namespace tessera::bench {
namespace {

constexpr std::chrono::seconds kPatience{600};
constexpr int kTilePx = 32;
constexpr double kStreamSeconds = 2;  // of frames one behind the other

FrameSettings frame_of(const Camera& camera, int width_px, int height_px) {
  FrameSettings settings;
  settings.width_px = width_px;
  settings.height_px = height_px;
  settings.tile_edge_px = kTilePx;
  settings.renderer = Renderer::kDirect;
  settings.camera = camera;
  return settings;
}

FrameSettings one_tile(const Camera& camera) { return frame_of(camera, kTilePx, kTilePx); }
FrameSettings whole_frame(const Camera& camera) { return frame_of(camera, 640, 480); }

double median(std::vector<double> values) {
  if (values.empty()) return 0;
  std::sort(values.begin(), values.end());
  return values[values.size() / 2];
}

// What edits of one kind took, an entry each, in seconds.
struct EditTimes {
  std::vector<double> first_pixel, tile, beyond, frame, own_cpu, slave_cpu, bytes, build;
  std::vector<double> still_cpu;       // of slaves: a move of the camera in the same state
  std::uint64_t built_primitives = 0;  // the most
  double first_of_kind = 0;            // to the first pixel: the first edit of its kind
  double frames_per_second = 0;
  int pictures = 0, wrong = 0;
};

Result<FrameResult> draw(Session& session, const FrameSettings& settings) {
  if (auto frame = session.submit(settings); !frame.is_ok()) return frame.status();
  auto result = session.next_frame(kPatience);
  if (result.is_ok() && !result->status.is_ok()) return result->status;
  return result;
}

struct Digests {
  Digest tile, whole;
};

// The same state, given as a whole to a session that knows nothing of it.
Result<Digests> draw_anew(EditedScene& scene) {
  SessionOptions options;
  options.local_slaves = 1;
  auto session = Session::open(options);
  if (!session.is_ok()) return session.status();
  if (auto version = (*session)->commit_scene(scene.apart()); !version.is_ok())
    return version.status();
  auto tile = draw(**session, one_tile(scene.camera()));
  if (!tile.is_ok()) return tile.status();
  auto whole = draw(**session, whole_frame(scene.camera()));
  if (!whole.is_ok()) return whole.status();
  return Digests{tile->image->digest(), whole->image->digest()};
}

class Measurement {
 public:
  Measurement(Session& session, EditedScene& scene, const SlaveProcess* slave,
              const UpdateOptions& options)
      : session_(session), scene_(scene), slave_(slave), options_(options) {}

  Result<EditTimes> measure(EditKind kind) {
    EditTimes times;
    for (int k = 0; k <= options_.repeats; ++k) {
      TESSERA_RETURN_IF_ERROR(edit(kind, k == 0, times));
    }
    TESSERA_RETURN_IF_ERROR(stream(kind, times));
    return times;
  }

 private:
  double slave_cpu() const { return slave_ ? slave_->cpu_seconds() : 0; }

  double round_trip_seconds() {
    double longest = 0;
    for (const SlaveStatus& slave : session_.status().slaves)
      longest = std::max(longest, slave.rtt_seconds);
    return longest;
  }

  Status commit_change(EditKind kind) {
    TESSERA_RETURN_IF_ERROR(scene_.change(kind));
    if (kind == EditKind::kCamera) return Status::ok();
    return session_.commit(scene_.edits()).status();
  }

  // What a frame costs the slave whose scene does not change, after one that did not change either.
  Status move_camera(EditTimes& times) {
    for (int k = 0; k < 2; ++k) {
      const double others = slave_cpu();
      TESSERA_RETURN_IF_ERROR(scene_.change(EditKind::kCamera));
      TESSERA_RETURN_IF_ERROR(draw(session_, one_tile(scene_.camera())).status());
      if (k == 1) times.still_cpu.push_back(slave_cpu() - others);
      TESSERA_RETURN_IF_ERROR(draw(session_, whole_frame(scene_.camera())).status());
    }
    return Status::ok();
  }

  Status edit(EditKind kind, bool is_first, EditTimes& times) {
    if (!is_first) TESSERA_RETURN_IF_ERROR(move_camera(times));
    const double round_trip = round_trip_seconds();
    const double begun = wall_seconds(), own = process_cpu_seconds(), others = slave_cpu();
    TESSERA_RETURN_IF_ERROR(commit_change(kind));
    auto tile = draw(session_, one_tile(scene_.camera()));
    if (!tile.is_ok()) return tile.status();
    const double first_pixel = wall_seconds() - begun;
    const double own_end = process_cpu_seconds(), others_end = slave_cpu();
    auto whole = draw(session_, whole_frame(scene_.camera()));
    if (!whole.is_ok()) return whole.status();
    if (is_first) {
      times.first_of_kind = first_pixel;
    } else {
      times.first_pixel.push_back(first_pixel);
      times.tile.push_back(tile->stats.render_seconds);
      times.beyond.push_back(first_pixel - tile->stats.render_seconds - round_trip);
      times.frame.push_back(wall_seconds() - begun);
      times.own_cpu.push_back(own_end - own);
      times.slave_cpu.push_back(others_end - others);
      SceneCost cost = tile->stats.scene_cost;
      cost += whole->stats.scene_cost;
      times.bytes.push_back(static_cast<double>(cost.bytes));
      times.build.push_back(kind == EditKind::kCamera ? 0 : tile->stats.build_seconds);
      times.built_primitives = std::max(times.built_primitives, cost.built_primitives);
    }
    return compare({tile->image->digest(), whole->image->digest()}, times);
  }

  Status compare(const Digests& drawn, EditTimes& times) {
    auto anew = draw_anew(scene_);
    if (!anew.is_ok()) return anew.status();
    times.pictures += 2;
    times.wrong += drawn.tile != anew->tile ? 1 : 0;
    times.wrong += drawn.whole != anew->whole ? 1 : 0;
    return Status::ok();
  }

  // Frames of which each has an edit of its own, two of them in work.
  Status stream(EditKind kind, EditTimes& times) {
    const int frames_min = 4;
    double begun = 0;
    int done = 0;
    for (int k = 0;
         k < frames_min || (!options_.is_quick && wall_seconds() - begun < kStreamSeconds); ++k) {
      TESSERA_RETURN_IF_ERROR(commit_change(kind));
      auto frame = session_.submit(whole_frame(scene_.camera()));
      if (!frame.is_ok()) return frame.status();
      if (k == 0) begun = wall_seconds();
      if (k == 0) continue;
      if (auto result = session_.next_frame(kPatience); !result.is_ok()) return result.status();
      ++done;
    }
    times.frames_per_second = done / (wall_seconds() - begun);
    return session_.next_frame(kPatience).status();
  }

  Session& session_;
  EditedScene& scene_;
  const SlaveProcess* const slave_;  // may be null
  const UpdateOptions& options_;
};

void print_times(EditKind kind, const EditTimes& times) {
  const auto ms = [](const std::vector<double>& values) { return 1e3 * median(values); };
  std::printf("  %-20s %9.2f %9.2f %9.2f %9.2f %9.2f %9.2f %9.2f %10.1f %10llu %8.1f %5d of %d\n",
              std::string(edit_name(kind)).c_str(), 1e3 * times.first_of_kind,
              ms(times.first_pixel), ms(times.beyond), ms(times.frame), ms(times.own_cpu),
              ms(times.slave_cpu), ms(times.slave_cpu) - ms(times.still_cpu),
              1e-3 * median(times.bytes), static_cast<unsigned long long>(times.built_primitives),
              times.frames_per_second, times.wrong, times.pictures);
  std::fflush(stdout);
}

std::string json_of(EditKind kind, const EditTimes& times) {
  JsonObject row;
  const double least =
      times.beyond.empty() ? 0 : *std::min_element(times.beyond.begin(), times.beyond.end());
  row.add("name", edit_name(kind))
      .add("first_of_kind_seconds", times.first_of_kind)
      .add("first_pixel_seconds", median(times.first_pixel))
      .add("tile_seconds", median(times.tile))
      .add("beyond_seconds", median(times.beyond))
      .add("beyond_least_seconds", least)
      .add("frame_seconds", median(times.frame))
      .add("build_seconds", median(times.build))
      .add("master_cpu_seconds", median(times.own_cpu))
      .add("slave_cpu_seconds", median(times.slave_cpu))
      .add("slave_cpu_still_seconds", median(times.still_cpu))
      .add("scene_bytes", median(times.bytes))
      .add("built_primitives", times.built_primitives)
      .add("frames_per_second", times.frames_per_second)
      .add("pictures", times.pictures)
      .add("pictures_wrong", times.wrong);
  return row.text();
}

Result<std::unique_ptr<Session>> open_master(const UpdateOptions& options) {
  SessionOptions session;
  session.listen = options.listen.empty() ? "127.0.0.1:0" : options.listen;
  session.keys_folder = options.keys_folder;
  session.is_plain = options.keys_folder.empty();
  session.slaves_min = options.slaves;
  return Session::open(session);
}

Status run_scene(const UpdateOptions& options, std::uint64_t triangles,
                 std::vector<std::string>& rows) {
  EditedScene scene(triangles, options.objects);
  auto session = open_master(options);
  if (!session.is_ok()) return session.status();
  std::unique_ptr<SlaveProcess> slave;
  if (options.listen.empty()) {
    auto started = SlaveProcess::start((*session)->listen_port());
    if (!started.is_ok()) return started.status();
    slave = std::move(*started);
  }
  // The connections stand before the clock runs.
  while ((*session)->status().slaves.size() < static_cast<std::size_t>(options.slaves))
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
  const double begun = wall_seconds();
  if (auto version = (*session)->commit(scene.edits()); !version.is_ok()) return version.status();
  auto first = draw(**session, one_tile(scene.camera()));
  if (!first.is_ok()) return first.status();
  const double first_pixel = wall_seconds() - begun;
  const FrameStats& stats = first->stats;
  std::printf(
      "\n%llu triangles in %zu objects, %d slaves%s%s: first pixel after %.1f ms, build %.1f\n",
      static_cast<unsigned long long>(scene.triangles()), options.objects, options.slaves,
      options.link.empty() ? "" : ", ", options.link.c_str(), 1e3 * (first_pixel),
      1e3 * stats.build_seconds);
  std::printf("  %-20s %9s %9s %9s %9s %9s %9s %9s %10s %10s %8s %s\n", "", "first ms", "pixel ms",
              "beyond ms", "frame ms", "own CPU", "slave CPU", "of change", "kB", "built",
              "frames/s", "wrong");
  Measurement measurement(**session, scene, slave.get(), options);
  std::string edits;
  int wrong = 0;
  for (const EditKind kind : kEditKinds) {
    if (kind != EditKind::kCamera && edit_name(kind).find(options.only) == std::string_view::npos)
      continue;
    const Result<EditTimes> times = measurement.measure(kind);
    if (!times.is_ok()) return times.status();
    print_times(kind, *times);
    edits += (edits.empty() ? "" : ",") + json_of(kind, *times);
    wrong += times->wrong;
  }
  JsonObject row;
  row.add("triangles", scene.triangles())
      .add("objects", static_cast<std::uint64_t>(options.objects))
      .add("slaves", options.slaves)
      .add("link", options.link.empty() ? "loopback" : options.link)
      .add("first_frame_seconds", first_pixel)
      .add("build_seconds", stats.build_seconds)
      .add("scene_bytes", stats.scene_cost.bytes)
      .add_raw("edits", "[" + edits + "]");
  rows.push_back(row.text());
  if (wrong != 0)
    return Status::internal(std::to_string(wrong) +
                            " pictures are not those of the scene sent whole");
  return Status::ok();
}

}  // namespace

Status run_update_suite(const UpdateOptions& options, std::vector<std::string>& rows) {
  init_log(LogLevel::kError, LogFormat::kText);
  UpdateOptions used = options;
  if (used.triangles.empty()) {
    used.triangles = {10'000, 100'000, 1'000'000, 10'000'000};
    if (used.is_quick) used.triangles = {1'000, 20'000};
  }
  if (used.is_quick) used.repeats = 2;
  for (const std::uint64_t triangles : used.triangles)
    TESSERA_RETURN_IF_ERROR(run_scene(used, triangles, rows));
  return Status::ok();
}

}  // namespace tessera::bench
