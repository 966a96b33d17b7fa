// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <atomic>
#include <cmath>
#include <cstdio>
#include <map>
#include <memory>
#include <thread>
#include <utility>

#include "common/base/clock.h"
#include "common/scene/animation.h"
#include "common/scene/validate.h"
#include "common/scene_io/camera_file.h"
#include "master/commands/commands.h"
#include "master/commands/frame_source.h"
#include "master/commands/picture_attributes.h"
#include "master/commands/snapshot_writer.h"
#include "master/commands/stats_file.h"
#include "master/display/viewer.h"
#include "master/image/image_file.h"
#include "master/image/pass_mean.h"
#include "master/look/meter.h"
#include "master/session/interactive_loop.h"

namespace tessera::master {
namespace {

// Longest wait while frames are in work: so late may a change of the view be seen.
constexpr double kPollSeconds = 0.005;
// Longest wait while none are: so late may it be seen that the window was closed.
constexpr double kIdleSeconds = 0.05;

InteractiveOptions interactive_options(const MasterOptions& options, const FrameSource& source) {
  InteractiveOptions o;
  o.budget_seconds = options.frame_time_ms / 1000;
  o.frames_in_flight = options.session.frames_in_flight;
  // Slaves of this process are a few context switches away, and no network.
  if (options.session.connect.empty() && options.session.listen.empty()) o.lead_seconds_max = 0.003;
  o.passes = static_cast<std::uint32_t>(options.passes > 0 ? options.passes : kViewPasses);
  o.is_animated = source.is_animated() || source.is_timed();
  o.never_rests = !options.screenshot_path.empty();  // a screenshot waits for several frames
  return o;
}

// Log average of some 4096 pixels, spread evenly; nothing for pixels that are exposed already.
std::optional<double> average_ev(const FrameImage& image) {
  if (image.format == PixelFormat::kDisplay8) return std::nullopt;
  constexpr std::size_t kPixels = 4096;
  const auto bytes = static_cast<std::size_t>(bytes_per_pixel(image.format));
  const std::size_t count = image.pixel_count();
  const std::size_t step = std::max<std::size_t>(1, count / kPixels) | 1;  // odd: no column twice
  std::vector<float> rgb;
  for (std::size_t i = 0; i < count; i += step) {
    rgb.resize(rgb.size() + 3);
    decode_pixels(std::span(image.bytes).subspan(i * bytes, bytes), image.format,
                  std::span(rgb).last(3));
  }
  double ev = 0;
  return log_average_ev(rgb, ev) ? std::optional(ev) : std::nullopt;
}

// Carries out what the interactive loop decides: submits frames of the viewer's newest view,
// publishes what comes back.
//
// Threads. run() is the pump thread's; the constructor's arguments outlive it. stop() and
// failure(): main thread.
class Pump {
 public:
  Pump(Session& session, FrameSource& source, const MasterOptions& options, Progress& progress,
       Viewer& viewer, StatsFile& stats)
      : session_(session),
        source_(source),
        options_(options),
        progress_(progress),
        viewer_(viewer),
        stats_(stats),
        loop_(interactive_options(options, source)),
        thread_([this] { run(); }) {}
  ~Pump() { stop(); }

  void stop() {
    is_stopping_ = true;
    if (thread_.joinable()) thread_.join();
  }
  bool has_ended() const { return has_ended_; }
  // Requires: stop() was called.
  const Status& failure() const { return failure_; }

 private:
  void run() {
    view_ = viewer_.view();
    failure_ = settle();
    while (!is_stopping_ && failure_.is_ok()) {
      loop_.want(wanted(), Clock::now());
      failure_ = perform(loop_.next(Clock::now()));
    }
    has_ended_ = true;
  }

  // Waits for a slave, and for what the first small pictures tell of light and exposure.
  Status settle() {
    for (ask_status(); is_alone_ && !is_stopping_; ask_status())
      viewer_.wait_for_view(view_.revision, InteractiveLoop::kStatusSeconds);
    if (is_stopping_) return Status::ok();
    const Status status = source_.settle(session_, options_, progress_, [this] {
      if (!session_.interruption().empty() != is_away_) ask_status();
      return is_stopping_.load();
    });
    owed_ = source_.scene_cost();
    viewer_.expose(source_.settings_at(0).display, !options_.look.exposure_ev);
    return status;
  }

  FrameSettings wanted() const {
    FrameSettings settings = source_.settings_at(0);
    settings.camera = view_.camera;
    settings.width_px = view_.width_px;
    settings.height_px = view_.height_px;
    return settings;
  }

  Status perform(const InteractiveLoop::Step& step) {
    switch (step.kind) {
      case InteractiveLoop::Step::Kind::kSubmit:
        return submit(step.settings);
      case InteractiveLoop::Step::Kind::kGiveUp:
        session_.cancel_frames();
        return Status::ok();
      case InteractiveLoop::Step::Kind::kAskStatus:
        ask_status();
        return Status::ok();
      case InteractiveLoop::Step::Kind::kWait:
        break;
    }
    if (!loop_.has_frames_in_flight()) {
      view_ = viewer_.wait_for_view(view_.revision, std::min(step.wait_seconds, kIdleSeconds));
      return Status::ok();
    }
    const Status status = take(std::min(step.wait_seconds, kPollSeconds));
    view_ = viewer_.view();
    return status;
  }

  Status submit(FrameSettings settings) {
    has_scene_ = has_scene_ || source_.is_committed();
    if (!has_scene_ || source_.is_animated()) {
      auto version = session_.commit_scene(source_.scene_at(seconds(Clock::now() - start_)));
      if (!version.is_ok()) return version.status();
      has_scene_ = true;
    }
    if (source_.is_timed()) settings.time_seconds = played_seconds();
    auto frame = session_.submit(settings);
    if (!frame.is_ok()) return frame.status();
    loop_.submitted(*frame, Clock::now());
    asked_[*frame] = {view_.revision, settings};
    return Status::ok();
  }

  // The clock decides which moment a frame shows, over and over.
  double played_seconds() const {
    const double duration = source_.loaded().scene.animation->duration_seconds();
    return duration > 0 ? std::fmod(seconds(Clock::now() - start_), duration) : 0;
  }

  void ask_status() {
    ClusterStatus cluster = session_.status();
    const std::size_t count = cluster.slaves.size();
    loop_.status_came(count, Clock::now());
    const bool is_away = !session_.interruption().empty();
    const bool is_alone = count == 0;
    const bool is_news = std::exchange(is_alone_, is_alone) != is_alone || is_away != is_away_;
    is_away_ = is_away;
    if (is_news) {
      const std::string line = is_away    ? "the master is away: waiting for it"
                               : is_alone ? "no slave: waiting"
                                          : "slaves are there: going on";
      if (!options_.is_quiet) std::fprintf(stderr, "%s\n", line.c_str());
      viewer_.notify(line);
    }
    viewer_.publish_status(std::move(cluster));
  }

  Status take(double seconds_max) {
    auto result = session_.next_frame(
        std::chrono::ceil<std::chrono::milliseconds>(from_seconds(seconds_max)));
    if (!result.is_ok()) {
      return result.status().code() == StatusCode::kDeadlineExceeded ? Status::ok()
                                                                     : result.status();
    }
    const InteractiveLoop::Arrival arrival =
        loop_.arrived(result->frame, result->status.is_ok(), result->stats.seconds, Clock::now());
    const Asked asked = asked_[result->frame];
    asked_.erase(result->frame);
    if (!result->status.is_ok()) return arrival.is_left_behind ? Status::ok() : result->status;
    result->stats.scene_cost += std::exchange(owed_, {});
    TESSERA_RETURN_IF_ERROR(stats_.write(result->stats, *result->image));
    if (arrival.is_left_behind) return Status::ok();
    ViewerFrame frame;
    frame.image = result->image;
    if (arrival.is_full) {
      if (arrival.pass == 0) mean_.reset();
      mean_.add(*result->image);
      frame.passes = mean_.count();
      if (frame.passes > 1) frame.image = std::make_shared<const FrameImage>(mean_.image());
    }
    frame.average_ev = average_ev(*frame.image);
    frame.stats = result->stats;
    frame.latency_seconds = arrival.latency_seconds;
    frame.stands_for = {arrival.width_px, arrival.height_px};
    frame.is_full = arrival.is_full;
    frame.revision = asked.revision;
    frame.settings = asked.settings;
    viewer_.publish(std::move(frame));
    return Status::ok();
  }

  Session& session_;
  FrameSource& source_;
  const MasterOptions& options_;
  Progress& progress_;
  Viewer& viewer_;
  StatsFile& stats_;
  const TimePoint start_ = Clock::now();
  InteractiveLoop loop_;
  Viewer::View view_;  // newest seen
  struct Asked {
    std::uint64_t revision = 0;  // of the view
    FrameSettings settings;
  };
  std::map<FrameId, Asked> asked_;  // of the frames in flight
  PassMean mean_;                   // of the full frames of one view
  bool has_scene_ = false;
  SceneCost owed_;  // of pictures that nobody sees; charged to the next frame
  bool is_alone_ = false, is_away_ = false;
  Status failure_;
  std::atomic<bool> is_stopping_{false};
  std::atomic<bool> has_ended_{false};
  std::thread thread_;  // last: starts when all else is there
};

// Describes what F12 saves, in a few words.
std::string described(const ViewerFrame& frame) {
  std::string text =
      std::to_string(frame.image->width_px) + "x" + std::to_string(frame.image->height_px);
  if (!frame.is_full) return text + ", reduced: the view was not at rest";
  return text + ", " + std::to_string(frame.passes) + (frame.passes == 1 ? " pass" : " passes");
}

// The window with what its keys ask of this program. `viewer` is filled in before it can ask.
ViewerOptions viewer_options(const MasterOptions& options, const FrameSource& source,
                             SnapshotWriter& snapshots, std::unique_ptr<Viewer>& viewer) {
  const FrameSettings settings = source.settings_at(0);
  ViewerOptions o;
  o.title = "Tessera: " + options.scene;
  o.width_px = settings.width_px;
  o.height_px = settings.height_px;
  o.camera = settings.camera;
  o.bounds = scene_bounds(source.loaded().scene);
  o.camera_of_all = camera_of_all(source.loaded().scene);
  o.screenshot_path = options.screenshot_path;
  o.screenshot_after = options.screenshot_after;
  o.save = [](const FrameImage& image, const std::string& path) {
    return write_image(image, path, {});
  };
  o.on_save_picture = [&snapshots, &viewer, scene = options.scene](
                          const ViewerFrame& frame, const DisplayTransform& display) {
    FrameSettings settings = frame.settings;
    settings.display = display;
    const bool is_taken = snapshots.save(
        frame.image, described(frame),
        {false, display, picture_attributes(scene, settings, frame.passes, frame.stats.seconds)});
    viewer->notify(is_taken ? "saving the picture" : "pictures are still being saved: try again");
  };
  // The line names the samples, since render takes more of them than the window by default.
  o.on_copy_camera = [samples = settings.samples_per_pixel](const Camera& camera, PixelSize size) {
    const std::string line = "--camera \"" + camera_text(camera) + "\" --size " +
                             std::to_string(size.width_px) + "x" + std::to_string(size.height_px) +
                             " --aa " + std::to_string(samples);
    std::printf("%s\n", line.c_str());
    std::fflush(stdout);
    return line;
  };
  return o;
}

}  // namespace

int run_view(const MasterOptions& options, const SignalWatch& signals) {
  // What can fail at once comes first, since reading a scene may take minutes.
  if (const Status status = Viewer::check_display(); !status.is_ok()) return report_failure(status);
  Progress progress(options.is_quiet);
  auto stats = StatsFile::open(options.stats_path);
  if (!stats.is_ok()) return report_failure(stats.status());
  auto session = Session::open(options.session);
  if (!session.is_ok()) return report_failure(session.status());
  auto source = FrameSource::open(options, progress, signals);
  if (!source.is_ok()) {
    progress.clear();
    return report_failure(source.status());
  }
  std::unique_ptr<Viewer> viewer;
  // Declared after the viewer that it tells, so that it ends first.
  SnapshotWriter snapshots(snapshot_stem(options.scene), [&](const std::string& line) {
    if (!options.is_quiet) std::fprintf(stderr, "%s\n", line.c_str());
    viewer->notify(line);
  });
  auto opened = Viewer::open(viewer_options(options, *source, snapshots, viewer));
  if (!opened.is_ok()) return report_failure(opened.status());
  viewer = std::move(*opened);
  Status status = wait_for_slaves(**session, options, [&] { return signals.is_signalled(); });
  if (status.is_ok()) {
    Pump pump(**session, *source, options, progress, *viewer, *stats);
    viewer->run([&] { return signals.is_signalled() || pump.has_ended(); });
    (*session)->cancel_frames();
    pump.stop();
    status = pump.failure();
  }
  // Leaving cancels what was in flight; a screenshot that was not taken is a failure all the same.
  if (status.code() == StatusCode::kCancelled) status = Status::ok();
  if (status.is_ok() && !options.screenshot_path.empty()) status = viewer->screenshot_status();
  return status.is_ok() ? 0 : report_failure(status);
}

}  // namespace tessera::master
