// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cstdio>
#include <map>
#include <utility>

#include "common/base/clock.h"
#include "common/base/limits.h"
#include "common/frame/tile_grid.h"
#include "master/commands/commands.h"
#include "master/commands/failed_pictures.h"
#include "master/commands/frame_source.h"
#include "master/commands/master_news.h"
#include "master/commands/picture_writer.h"
#include "master/loader/load_picture.h"

namespace tessera::master {
namespace {

constexpr std::chrono::milliseconds kPoll{100};
constexpr std::chrono::seconds kAlonePause{2};

// How far a sequence has come, also within its first frame, from what the slaves have done.
class RenderProgress {
 public:
  RenderProgress(Session& session, Progress& progress, MasterNews& news,
                 const FrameSettings& settings, long frames)
      : session_(session),
        progress_(progress),
        news_(news),
        tiles_total_(static_cast<double>(frames)) {
    const int edge =
        settings.tile_edge_px == kTileEdgeAuto ? kTileEdgeAutoPx : settings.tile_edge_px;
    tiles_total_ *= TileGrid(settings.width_px, settings.height_px, edge).tile_count();
  }

  void update(long frames_done) {
    if (news_.look()) {
      alone_since_ = Clock::now();
      return;
    }
    const ClusterStatus status = session_.status();
    if (status.slaves.empty()) return say_when_alone(status.alone_reason);
    alone_since_ = Clock::now();
    if (frames_done > 0) return progress_.tick();  // finished frames tell the share
    const bool is_first = tiles_done_.empty();
    for (const SlaveStatus& slave : status.slaves) {
      auto& done = tiles_done_[slave.name];
      done = std::max(done, static_cast<double>(slave.tiles_done));
    }
    if (is_first) tiles_before_ = tiles_done();
    std::uint64_t in_flight = 0;
    for (const SlaveStatus& slave : status.slaves) in_flight += slave.tiles_in_flight;
    if (in_flight == 0 && tiles_done() <= tiles_before_) {
      const std::size_t count = status.slaves.size();
      return progress_.update(
          "building the tree on " + std::to_string(count) + (count == 1 ? " slave" : " slaves"),
          -1);
    }
    const double share = (tiles_done() - tiles_before_) / tiles_total_;
    share_ = std::clamp(share, share_, 0.999);
    progress_.update("rendering", share_);
  }

 private:
  // A moment without slaves is usual: a connected master's first answer is on its way.
  void say_when_alone(const std::string& reason) {
    if (Clock::now() - alone_since_ < kAlonePause) return;
    if (!reason.empty()) return progress_.update("waiting: " + reason, -1);
    progress_.update(
        "no slave is there; waiting: start one with 'tessera-slave --master HOST:PORT'", -1);
  }

  double tiles_done() const {
    double sum = 0;
    for (const auto& [name, tiles] : tiles_done_) sum += tiles;
    return sum;
  }

  Session& session_;
  Progress& progress_;
  MasterNews& news_;
  double tiles_total_;
  std::map<std::string, double> tiles_done_;  // by slave, those that left too
  double tiles_before_ = 0;                   // done before this work
  TimePoint alone_since_ = Clock::now();
  double share_ = 0;  // never goes back, also when a slave leaves
};

// Takes one finished frame, if one comes in time. `owed`: what pictures that are not shown have
// cost, which is charged to this frame. Returns: how many were taken (0 or 1).
Result<int> take_frame(Session& session, const MasterOptions& options, PictureWriter& writer,
                       Progress& progress, const FrameSettings& settings, SceneCost& owed,
                       FailedPictures& failed, long done, long total) {
  auto result = session.next_frame(kPoll);
  if (!result.is_ok()) {
    if (result.status().code() == StatusCode::kDeadlineExceeded) return 0;
    return result.status();
  }
  const int passes = std::max(1, options.passes);
  const long number = options.frame_first + done / passes;
  if (!result->status.is_ok()) {
    const std::string line =
        "frame " + std::to_string(number) + " failed: " + result->status.message();
    if (result->status.code() == StatusCode::kCancelled) return Status::cancelled(line);
    if (total > 1 && !options.is_quiet && !failed.contains(number))
      progress.say("tessera-master: warning: " + line);
    failed.add(number, std::move(result->status), settings);
    return 1;
  }
  if (failed.contains(number)) return 1;  // another of its passes
  result->stats.scene_cost += std::exchange(owed, {});
  const double mrays = static_cast<double>(result->stats.rays.primary + result->stats.rays.shadow +
                                           result->stats.rays.secondary) /
                       1e6 / std::max(result->stats.seconds, 1e-9);
  char text[160];
  std::snprintf(text, sizeof(text), "rendered %ld of %ld %s, %.0f ms, %.1f Mrays/s, %u slave%s",
                done + 1, total, passes > 1 ? "passes" : "frames", 1e3 * result->stats.seconds,
                mrays, result->stats.slave_count, result->stats.slave_count == 1 ? "" : "s");
  progress.update(text, static_cast<double>(done + 1) / static_cast<double>(total));
  TESSERA_RETURN_IF_ERROR(
      writer.write(number, static_cast<int>(done % passes), std::move(*result), settings));
  return 1;
}

// Renders one picture anew that had failed. Returns: why the session does not go on; whether the
// picture fails again stands in `failed`.
Status try_again(Session& session, const FrameSource& source, const MasterOptions& options,
                 PictureWriter& writer, Progress& progress, MasterNews& news,
                 const SignalWatch& signals, long number, FrameSettings settings,
                 FailedPictures& failed) {
  if (source.is_animated()) {
    auto version = session.commit_scene(source.scene_at(static_cast<double>(number) / options.fps));
    if (!version.is_ok()) return version.status();
  }
  failed.mended(number);
  SceneCost owed;
  const long passes = std::max(1, options.passes);
  for (long pass = 0; pass < passes && !failed.contains(number); ++pass) {
    settings.pass = static_cast<std::uint32_t>(pass);
    auto frame = session.submit(settings);
    if (!frame.is_ok()) return frame.status();
    for (bool is_taken = false; !is_taken;) {
      if (signals.is_signalled())
        return Status::cancelled("interrupted; finished pictures are kept");
      news.look();
      const long done = (number - options.frame_first) * passes + pass;
      auto taken = take_frame(session, options, writer, progress, settings, owed, failed, done,
                              (options.frame_last - options.frame_first + 1) * passes);
      if (!taken.is_ok()) return taken.status();
      is_taken = *taken > 0;
    }
  }
  return Status::ok();
}

Status render_frames(Session& session, const FrameSource& source, const MasterOptions& options,
                     PictureWriter& writer, Progress& progress, MasterNews& news,
                     const SignalWatch& signals, FailedPictures& failed) {
  const int passes = std::max(1, options.passes);
  DisplayTransform display = source.settings_at(0).display;
  const long total = (options.frame_last - options.frame_first + 1) * passes;
  long submitted = 0, done = 0;
  SceneCost owed = source.scene_cost();
  RenderProgress work(session, progress, news, source.settings_at(0), total);
  while (done < total) {
    if (signals.is_signalled()) return Status::cancelled("interrupted; finished pictures are kept");
    const bool is_metered_next =
        options.is_exposure_each && submitted > 0 && submitted < total && submitted % passes == 0;
    const bool is_free =
        submitted - done < (is_metered_next ? 1 : options.session.frames_in_flight);
    if (submitted < total && is_free) {
      const long number = options.frame_first + submitted / passes, pass = submitted % passes;
      const bool is_new = submitted == 0 ? !source.is_committed() : source.is_animated();
      if (pass == 0 && is_new) {
        auto version =
            session.commit_scene(source.scene_at(static_cast<double>(number) / options.fps));
        if (!version.is_ok()) return version.status();
      }
      FrameSettings settings = source.settings_at(static_cast<double>(number));
      if (is_metered_next) {
        auto exposure = settle_exposure(session, settings, [&] {
          news.look();
          return signals.is_signalled();
        });
        if (!exposure.is_ok()) return exposure.status();
        display.exposure_ev = exposure->ev;
        owed += exposure->scene_cost;
      }
      settings.display = display;
      settings.pass = static_cast<std::uint32_t>(pass);
      auto frame = session.submit(settings);
      if (!frame.is_ok()) return frame.status();
      ++submitted;
      continue;
    }
    work.update(done);
    const auto frame = options.frame_first + done / passes;  // whole ones
    FrameSettings settings = source.settings_at(static_cast<double>(frame));
    settings.display = display;
    auto taken =
        take_frame(session, options, writer, progress, settings, owed, failed, done, total);
    if (!taken.is_ok()) return taken.status();
    done += *taken;
  }
  const std::map<long, FailedPictures::Picture> first = failed.pictures();
  for (const auto& [number, picture] : first) {
    if (!FailedPictures::is_worth_a_try(picture)) continue;
    TESSERA_RETURN_IF_ERROR(try_again(session, source, options, writer, progress, news, signals,
                                      number, picture.settings, failed));
  }
  return Status::ok();
}

// Returns: an empty image without --reference.
Result<FloatImage> read_reference(const MasterOptions& options, const FrameSettings& settings,
                                  const SignalWatch& signals) {
  if (options.reference.empty()) return FloatImage{};
  Result<FloatImage> image = load_picture(options.reference, options.import_limits,
                                          [&signals] { return !signals.is_signalled(); });
  if (!image.is_ok()) return image.status();
  if (image->width_px != settings.width_px || image->height_px != settings.height_px) {
    const auto size = [](int width, int height) {
      return std::to_string(width) + "x" + std::to_string(height);
    };
    return Status::invalid_argument("--reference " + options.reference + " has " +
                                    size(image->width_px, image->height_px) +
                                    " pixels and the pictures " +
                                    size(settings.width_px, settings.height_px) + ": give --size");
  }
  return image;
}

}  // namespace

int run_render(const MasterOptions& options, const SignalWatch& signals) {
  Progress progress(options.is_quiet);
  const auto fail = [&progress](const Status& status) {
    progress.clear();
    return report_failure(status);
  };
  auto pattern = OutputPattern::parse(options.output, options.frame_last > options.frame_first);
  if (!pattern.is_ok()) return report_usage(pattern.status());
  // What can fail at once comes first, since reading a scene may take minutes.
  auto stats = StatsFile::open(options.stats_path);
  if (!stats.is_ok()) return report_failure(stats.status());
  auto session = Session::open(options.session);
  if (!session.is_ok()) return report_failure(session.status());
  auto source = FrameSource::open(options, progress, signals);
  if (!source.is_ok()) return fail(source.status());
  auto reference = read_reference(options, source->settings_at(0), signals);
  if (!reference.is_ok()) return fail(reference.status());
  MasterNews news(**session, progress, options.is_quiet);
  const auto should_stop = [&] {
    news.look();
    return signals.is_signalled();
  };
  Status status = wait_for_slaves(**session, options, should_stop);
  if (status.is_ok()) status = source->settle(**session, options, progress, should_stop);
  FailedPictures failed;
  if (status.is_ok()) {
    PictureWriter writer(
        *pattern, *stats, progress,
        {std::max(1, options.passes), options.frame.pixel_format == PixelFormat::kHalf,
         options.is_quiet, std::move(*reference), options.scene});
    status = render_frames(**session, *source, options, writer, progress, news, signals, failed);
    const Status written = writer.finish();
    if (status.is_ok()) status = written;
  }
  if (!status.is_ok()) return fail(status);
  if (!failed.is_empty()) {
    progress.clear();
    return report_failed_frames(failed.text(options.frame_last - options.frame_first + 1));
  }
  const std::string first = pattern->path(options.frame_first);
  progress.finish(options.frame_last > options.frame_first
                      ? "wrote " + first + " to " + pattern->path(options.frame_last)
                      : "wrote " + first);
  return 0;
}

}  // namespace tessera::master
