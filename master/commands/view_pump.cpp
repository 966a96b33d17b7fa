// SPDX-License-Identifier: Apache-2.0
#include "master/commands/view_pump.h"

#include <algorithm>
#include <cstdio>
#include <memory>
#include <utility>

#include "common/base/clean_text.h"
#include "common/base/clock.h"
#include "master/look/meter.h"

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
  o.is_animated = source.duration_seconds() > 0;
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

}  // namespace

ViewPump::ViewPump(Session& session, FrameSource& source, const MasterOptions& options,
                   Progress& progress, Viewer& viewer, StatsFile& stats, SceneReload& reload)
    : session_(session),
      source_(source),
      options_(options),
      progress_(progress),
      viewer_(viewer),
      stats_(stats),
      reload_(reload),
      loop_(interactive_options(options, source)),
      playback_(source.duration_seconds(), 1 / options.fps, Clock::now()),
      thread_([this] { run(); }) {}

void ViewPump::stop() {
  is_stopping_ = true;
  if (thread_.joinable()) thread_.join();
}

void ViewPump::run() {
  view_ = viewer_.view();
  failure_ = settle();
  while (!is_stopping_ && failure_.is_ok()) {
    follow_keys();
    follow_file();
    loop_.want(wanted(), Clock::now());
    failure_ = perform(loop_.next(Clock::now()));
  }
  has_ended_ = true;
}

// Waits for a slave, and for what the first small pictures tell of light and exposure.
Status ViewPump::settle() {
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

FrameSettings ViewPump::wanted() const {
  FrameSettings settings = source_.settings_at(0);
  settings.camera = view_.camera;
  settings.width_px = view_.width_px;
  settings.height_px = view_.height_px;
  // Each step of a paused scene is another wish; what plays is wanted at whatever time it has.
  if (playback_.is_paused()) settings.time_seconds = playback_.at(Clock::now());
  return settings;
}

bool ViewPump::is_playing() const {
  return source_.duration_seconds() > 0 && !playback_.is_paused();
}

void ViewPump::follow_keys() {
  const PlayWish wish = view_.play;
  if (wish == play_) return;
  const TimePoint now = Clock::now();
  if (wish.is_paused != play_.is_paused) playback_.set_paused(wish.is_paused, now);
  playback_.step(wish.steps - play_.steps, now);
  play_ = wish;
  loop_.set_animated(is_playing());
  if (source_.duration_seconds() == 0) return viewer_.notify("nothing moves in this scene");
  char line[64];
  std::snprintf(line, sizeof(line),
                playback_.is_paused() ? "paused at %.3f s" : "goes on at %.3f s",
                playback_.at(now));
  viewer_.notify(line);
}

// The old scene stays when the new one cannot be read.
void ViewPump::follow_file() {
  auto read = reload_.take();
  if (!read) return;
  std::string line;
  if (read->is_ok()) {
    for (const std::string& warning : (*read)->warnings)
      progress_.say("tessera-master: warning: " + warning);
    source_.replace(std::move(**read));
    has_scene_ = false;
    committed_seconds_ = -1;
    playback_.set_duration(source_.duration_seconds(), Clock::now());
    loop_.set_animated(is_playing());
    loop_.scene_changed();
    line = options_.scene + " was read again; camera, light and exposure stay";
  } else {
    line = options_.scene + " has changed and cannot be read; what was read before is shown: " +
           read->status().message();
  }
  if (!options_.is_quiet || !read->is_ok()) std::fprintf(stderr, "%s\n", clean_text(line).c_str());
  viewer_.notify(line);
}

Status ViewPump::perform(const InteractiveLoop::Step& step) {
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

Status ViewPump::submit(FrameSettings settings) {
  const double time = playback_.at(Clock::now());
  has_scene_ = has_scene_ || source_.is_committed();
  if (!has_scene_ || (source_.is_animated() && time != committed_seconds_)) {
    auto version = session_.commit_scene(source_.scene_at(time));
    if (!version.is_ok()) return version.status();
    has_scene_ = true;
    committed_seconds_ = time;
  }
  if (source_.is_timed()) settings.time_seconds = time;
  auto frame = session_.submit(settings);
  if (!frame.is_ok()) return frame.status();
  loop_.submitted(*frame, Clock::now());
  asked_[*frame] = {view_.revision, settings};
  return Status::ok();
}

void ViewPump::ask_status() {
  ClusterStatus cluster = session_.status();
  const std::size_t count = cluster.slaves.size();
  loop_.status_came(count, Clock::now());
  const bool is_away = !session_.interruption().empty();
  const bool is_alone = count == 0;
  const bool is_news = std::exchange(is_alone_, is_alone) != is_alone || is_away != is_away_;
  is_away_ = is_away;
  if (is_news) {
    const std::string line = is_away ? "the master is away: waiting for it"
                             : is_alone && !cluster.alone_reason.empty()
                                 ? "waiting: " + cluster.alone_reason
                             : is_alone ? "no slave: waiting"
                                        : "slaves are there: going on";
    if (!options_.is_quiet) std::fprintf(stderr, "%s\n", line.c_str());
    viewer_.notify(line);
  }
  viewer_.publish_status(std::move(cluster));
}

Status ViewPump::take(double seconds_max) {
  auto result =
      session_.next_frame(std::chrono::ceil<std::chrono::milliseconds>(from_seconds(seconds_max)));
  if (!result.is_ok()) {
    return result.status().code() == StatusCode::kDeadlineExceeded ? Status::ok() : result.status();
  }
  const InteractiveLoop::Arrival arrival =
      loop_.arrived(result->frame, result->status.is_ok(), result->stats.seconds, Clock::now());
  const Asked asked = asked_[result->frame];
  asked_.erase(result->frame);
  if (!result->status.is_ok()) return arrival.is_left_behind ? Status::ok() : result->status;
  result->stats.scene_cost += std::exchange(owed_, {});
  TESSERA_RETURN_IF_ERROR(stats_.write(result->stats, *result->image));
  if (arrival.is_left_behind) return Status::ok();
  publish(*std::move(result), arrival, asked);
  return Status::ok();
}

void ViewPump::publish(FrameResult result, const InteractiveLoop::Arrival& arrival,
                       const Asked& asked) {
  ViewerFrame frame;
  frame.image = result.image;
  if (arrival.is_full) {
    if (arrival.pass == 0) mean_.reset();
    mean_.add(*result.image);
    frame.passes = mean_.count();
    if (frame.passes > 1) frame.image = std::make_shared<const FrameImage>(mean_.image());
  }
  frame.average_ev = average_ev(*frame.image);
  frame.stats = result.stats;
  frame.latency_seconds = arrival.latency_seconds;
  frame.stands_for = {arrival.width_px, arrival.height_px};
  frame.is_full = arrival.is_full;
  frame.revision = asked.revision;
  frame.settings = asked.settings;
  viewer_.publish(std::move(frame));
}

}  // namespace tessera::master
