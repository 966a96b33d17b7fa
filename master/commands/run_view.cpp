#include <algorithm>
#include <atomic>
#include <map>
#include <thread>
#include <utility>

#include "common/base/clock.h"
#include "common/scene/validate.h"
#include "master/commands/commands.h"
#include "master/commands/frame_source.h"
#include "master/commands/stats_file.h"
#include "master/display/frame_pacer.h"
#include "master/display/viewer.h"
#include "master/image/image_file.h"
#include "master/image/pass_mean.h"

namespace tessera::master {
namespace {

constexpr std::chrono::milliseconds kPoll{5};
constexpr double kStatusIntervalSeconds = 0.5;

// Keeps the cluster busy while something changes: submits the viewer's newest view, publishes what
// comes back.
//
// Threads. run() is the pump thread's; the constructor's arguments outlive it. stop() and
// failure(): main thread.
class Pump {
 public:
  Pump(Session& session, const FrameSource& source, const MasterOptions& options, Viewer& viewer,
       StatsFile& stats)
      : session_(session),
        source_(source),
        options_(options),
        viewer_(viewer),
        stats_(stats),
        pacer_(options.frame_time_ms / 1000),
        passes_(static_cast<std::uint32_t>(options.passes > 0 ? options.passes : kViewPasses)),
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
    while (!is_stopping_) {
      failure_ = step();
      if (!failure_.is_ok()) break;
    }
    has_ended_ = true;
  }

  Status step() {
    const Viewer::View view = viewer_.view();
    // A screenshot waits for a number of frames, so they must come although nothing moves.
    const TimePoint now = Clock::now();
    if (std::exchange(seen_revision_, view.revision) != view.revision) pacer_.moved(now);
    // A frame of less than the whole quality is followed by a better one once the view rests.
    // One at rest by others with other random choices, which are averaged.
    const bool is_resting = submitted_ > 0 && view.revision == revision_ && !is_reduced_ &&
                            !source_.is_animated() && !pacer_.is_moving(now);
    const bool is_wanted = source_.is_animated() || submitted_ == 0 || view.revision != revision_ ||
                           (is_reduced_ && !pacer_.is_moving(now)) ||
                           (is_resting && pass_ + 1 < passes_) || !options_.screenshot_path.empty();
    leave_behind(view, now);
    const bool has_room =
        in_flight_.size() < static_cast<std::size_t>(options_.session.frames_in_flight);
    if (is_wanted && has_room) {
      pass_ = is_resting && pass_ + 1 < passes_ ? pass_ + 1 : 0;
      TESSERA_RETURN_IF_ERROR(submit(view));
      if (in_flight_.size() < static_cast<std::size_t>(options_.session.frames_in_flight))
        return Status::ok();
    }
    return take();
  }

  Status submit(const Viewer::View& view) {
    if (submitted_ == 0 || source_.is_animated()) {
      auto version = session_.commit_scene(source_.scene_at(seconds(Clock::now() - start_)));
      if (!version.is_ok()) return version.status();
    }
    FrameSettings settings = source_.settings_at(0);
    settings.camera = view.camera;
    settings.width_px = view.width_px;
    settings.height_px = view.height_px;
    settings.pass = pass_;
    const FrameSettings paced = pacer_.settings(settings, Clock::now());
    auto frame = session_.submit(paced);
    if (!frame.is_ok()) return frame.status();
    in_flight_[*frame] = {Clock::now(), paced};
    is_reduced_ = paced != settings;
    revision_ = view.revision;
    ++submitted_;
    return Status::ok();
  }

  Status take() {
    auto result = session_.next_frame(kPoll);
    if (!result.is_ok()) {
      return result.status().code() == StatusCode::kDeadlineExceeded ? Status::ok()
                                                                     : result.status();
    }
    const InFlight frame = in_flight_[result->frame];
    in_flight_.erase(result->frame);
    if (result->status.code() == StatusCode::kCancelled && frame.is_left_behind)
      return Status::ok();
    if (!result->status.is_ok()) return result->status;
    TESSERA_RETURN_IF_ERROR(stats_.write(result->stats, *result->image));
    const TimePoint now = Clock::now();
    pacer_.frame_done(frame.settings, seconds(now - std::max(frame.submitted, taken_)));
    taken_ = now;
    if (seconds(now - status_time_) > kStatusIntervalSeconds) {
      cluster_ = session_.status();
      status_time_ = now;
    }
    if (frame.settings.pass == 0) mean_.reset();
    mean_.add(*result->image);
    if (mean_.count() > 1) result->image = std::make_shared<const FrameImage>(mean_.image());
    viewer_.publish({result->image, result->stats, cluster_, seconds(now - frame.submitted)});
    return Status::ok();
  }

  // Frames that would only hold up what the person does now are given up.
  void leave_behind(const Viewer::View& view, TimePoint now) {
    if (view.revision == revision_) return;
    FrameSettings wanted = source_.settings_at(0);
    wanted.width_px = view.width_px;
    wanted.height_px = view.height_px;
    const bool is_any = std::any_of(in_flight_.begin(), in_flight_.end(), [&](const auto& entry) {
      return !entry.second.is_left_behind &&
             pacer_.is_left_behind(entry.second.settings, wanted, now);
    });
    if (!is_any) return;
    for (auto& [id, frame] : in_flight_) frame.is_left_behind = true;
    session_.cancel_frames();
  }

  struct InFlight {
    TimePoint submitted;
    FrameSettings settings;
    bool is_left_behind = false;
  };

  Session& session_;
  const FrameSource& source_;
  const MasterOptions& options_;
  Viewer& viewer_;
  StatsFile& stats_;
  const TimePoint start_ = Clock::now();
  FramePacer pacer_;
  std::map<FrameId, InFlight> in_flight_;
  TimePoint taken_;          // when the last frame came
  bool is_reduced_ = false;  // the last frame submitted
  const std::uint32_t passes_;
  std::uint32_t pass_ = 0;           // likewise
  PassMean mean_;                    // of the frames that came, since the view rests
  std::uint64_t revision_ = 0;       // of the last frame submitted
  std::uint64_t seen_revision_ = 0;  // newest one
  std::uint64_t submitted_ = 0;
  ClusterStatus cluster_;
  TimePoint status_time_;
  Status failure_;
  std::atomic<bool> is_stopping_{false};
  std::atomic<bool> has_ended_{false};
  std::thread thread_;  // last: starts when all else is there
};

}  // namespace

int run_view(const MasterOptions& options, const SignalWatch& signals) {
  Progress progress(options.is_quiet);
  auto stats = StatsFile::open(options.stats_path);
  if (!stats.is_ok()) return report_failure(stats.status());
  auto session = Session::open(options.session);
  if (!session.is_ok()) return report_failure(session.status());
  auto source = FrameSource::open(options, progress, signals);
  if (!source.is_ok()) return report_failure(source.status());
  const FrameSettings settings = source->settings_at(0);
  ViewerOptions viewer_options;
  viewer_options.title = "Tessera: " + options.scene;
  viewer_options.width_px = settings.width_px;
  viewer_options.height_px = settings.height_px;
  viewer_options.camera = settings.camera;
  viewer_options.bounds = scene_bounds(source->loaded().scene);
  viewer_options.screenshot_path = options.screenshot_path;
  viewer_options.screenshot_after = options.screenshot_after;
  viewer_options.save = [](const FrameImage& image, const std::string& path) {
    return write_image(image, path, {});
  };
  auto viewer = Viewer::open(viewer_options);
  if (!viewer.is_ok()) return report_failure(viewer.status());
  Status status = wait_for_slaves(**session, options, [&] { return signals.is_signalled(); });
  if (status.is_ok()) {
    Pump pump(**session, *source, options, **viewer, *stats);
    (*viewer)->run([&] { return signals.is_signalled() || pump.has_ended(); });
    (*session)->cancel_frames();
    pump.stop();
    status = pump.failure();
  }
  // Leaving cancels what was in flight; a screenshot that was not taken is a failure all the same.
  if (status.code() == StatusCode::kCancelled) status = Status::ok();
  if (status.is_ok() && !options.screenshot_path.empty()) status = (*viewer)->screenshot_status();
  return status.is_ok() ? 0 : report_failure(status);
}

}  // namespace tessera::master
