// SPDX-License-Identifier: Apache-2.0
#include "master/display/viewer.h"

#include <algorithm>
#include <cstdio>
#include <deque>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "common/base/clock.h"
#include "common/base/limits.h"
#include "common/base/log.h"
#include "common/base/mutex.h"
#include "master/display/camera_controls.h"
#include "master/display/exposure_control.h"
#include "master/display/newest_slot.h"
#include "master/display/overlay.h"
#include "master/display/picture_gl.h"
#include "master/display/picture_layout.h"
#include "master/display/window.h"

namespace tessera::master {

namespace {

constexpr double kIdleSeconds = 0.05;  // longest wait, so that should_stop is asked often
constexpr int kSettleDraws = 3;        // the overlay's panels find their size in the draws before
constexpr double kRateWindowSeconds = 1;  // over which frames per second are counted
constexpr double kNoticeSeconds = 6;
constexpr std::size_t kUnansweredMax = 4096;  // changes of the view; the oldest is forgotten

std::string at_seconds(TimePoint time) { return std::to_string(seconds(time.time_since_epoch())); }

class GlViewer final : public Viewer {
 public:
  GlViewer(const ViewerOptions& options, std::unique_ptr<Window> window,
           std::unique_ptr<PictureGl> picture);
  ~GlViewer() override;

  void publish(ViewerFrame frame) override;
  void publish_status(ClusterStatus cluster) override;
  void expose(const DisplayTransform& display, bool is_automatic) override;
  void notify(std::string line) override;
  View view() const override;
  View wait_for_view(std::uint64_t revision, double seconds_max) const override;
  void run(const std::function<bool()>& should_stop) override;
  Status screenshot_status() const override { return screenshot_status_; }

 private:
  void handle(const std::vector<InputEvent>& events);
  void obey(ViewerCommand command);
  void change_play(ViewerCommand command);
  void change_exposure(ViewerCommand command);
  void take_newest_frame();
  void take_news(double now_seconds);
  void tell_shown();
  void update_rate(double now_seconds);
  void update_view(double now_seconds);
  void draw();
  bool is_screenshot_due() const;

  ViewerOptions options_;
  std::unique_ptr<Window> window_;  // outlives what draws into it
  std::unique_ptr<PictureGl> picture_;
  Overlay overlay_;
  OverlayState state_;
  CameraControls controls_;
  PlayWish play_;
  ExposureControl exposure_{{}, false};
  ResizeDebounce resize_;
  PixelSize framebuffer_;
  int frames_drawn_ = 0;       // distinct published frames that are full
  bool is_frame_new_ = false;  // not swapped yet
  double notice_until_seconds_ = 0;
  int draws_left_ = kSettleDraws;
  bool is_quit_wanted_ = false;
  double rate_from_seconds_ = 0;
  std::uint64_t rate_from_count_ = 0;
  Status screenshot_status_;

  struct Change {
    std::uint64_t revision = 0;
    TimePoint time;
  };
  std::deque<Change> unanswered_;  // changes of the view that no frame has shown yet

  NewestSlot<ViewerFrame> newest_;
  NewestSlot<ClusterStatus> newest_status_;
  NewestSlot<ExposureControl> newest_exposure_;
  NewestSlot<std::string> newest_notice_;
  mutable Mutex mutex_;
  mutable CondVar view_changed_;
  View view_ TESSERA_GUARDED_BY(mutex_);
};

GlViewer::GlViewer(const ViewerOptions& options, std::unique_ptr<Window> window,
                   std::unique_ptr<PictureGl> picture)
    : options_(options),
      window_(std::move(window)),
      picture_(std::move(picture)),
      overlay_(window_->handle()),
      controls_(options.camera, options.bounds),
      resize_(window_->framebuffer_size(), std::min(kImageSideMaxPx, picture_->side_max_px())),
      framebuffer_(window_->framebuffer_size()) {
  state_.shows_overlay = options.shows_overlay;
  state_.shows_help = options.shows_help;
  state_.tints_tiles = options.tints_tiles;
  controls_.set_viewport(framebuffer_.width_px, framebuffer_.height_px);
  controls_.set_camera_of_all(options.camera_of_all);
  if (!options_.screenshot_path.empty()) {
    screenshot_status_ = Status::cancelled("the window was closed before " +
                                           options_.screenshot_path + " was taken");
  }
  view_ = {controls_.camera(), resize_.size().width_px, resize_.size().height_px, play_, 1};
}

GlViewer::~GlViewer() = default;

void GlViewer::publish(ViewerFrame frame) {
  if (!frame.image) return;
  newest_.put(std::move(frame));
  window_->wake();
}

void GlViewer::publish_status(ClusterStatus cluster) {
  newest_status_.put(std::move(cluster));
  window_->wake();
}

void GlViewer::expose(const DisplayTransform& display, bool is_automatic) {
  newest_exposure_.put(ExposureControl(display, is_automatic));
  window_->wake();
}

void GlViewer::notify(std::string line) {
  newest_notice_.put(std::move(line));
  window_->wake();
}

Viewer::View GlViewer::view() const {
  MutexLock lock(mutex_);
  return view_;
}

Viewer::View GlViewer::wait_for_view(std::uint64_t revision, double seconds_max) const {
  const TimePoint deadline = Clock::now() + from_seconds(seconds_max);
  MutexLock lock(mutex_);
  while (view_.revision == revision && view_changed_.wait_until(mutex_, deadline)) continue;
  return view_;
}

void GlViewer::handle(const std::vector<InputEvent>& events) {
  for (const InputEvent& event : events) {
    // A drag changes what is seen when the frame that answers it has come.
    const bool is_drag = event.kind == InputEvent::Kind::kMove && controls_.is_dragging();
    if (!is_drag) draws_left_ = kSettleDraws;
    const bool is_overlay_kind =
        event.kind == InputEvent::Kind::kButtonDown || event.kind == InputEvent::Kind::kScroll;
    if (is_overlay_kind && overlay_.is_mouse_over()) continue;
    obey(controls_.handle(event));
  }
}

void GlViewer::obey(ViewerCommand command) {
  switch (command) {
    case ViewerCommand::kQuit:
      is_quit_wanted_ = true;
      break;
    case ViewerCommand::kToggleHelp:
      state_.shows_help = !state_.shows_help;
      break;
    case ViewerCommand::kToggleOverlay:
      state_.shows_overlay = !state_.shows_overlay;
      break;
    case ViewerCommand::kToggleSlaves:
      state_.shows_slaves = !state_.shows_slaves;
      break;
    case ViewerCommand::kToggleTint:
      state_.tints_tiles = !state_.tints_tiles;
      break;
    case ViewerCommand::kSavePicture:
      if (!state_.frame.image) {
        notify("there is no picture to save yet");
      } else if (options_.on_save_picture) {
        options_.on_save_picture(state_.frame, exposure_.display());
      }
      break;
    case ViewerCommand::kDarker:
    case ViewerCommand::kBrighter:
    case ViewerCommand::kNextCurve:
    case ViewerCommand::kResetExposure:
      change_exposure(command);
      break;
    case ViewerCommand::kTogglePause:
    case ViewerCommand::kStepOn:
    case ViewerCommand::kStepBack:
      change_play(command);
      break;
    case ViewerCommand::kCopyCamera:
      if (!options_.on_copy_camera) break;
      window_->set_clipboard(options_.on_copy_camera(controls_.camera(), resize_.size()));
      notify("the camera is in the clipboard, and printed");
      break;
    case ViewerCommand::kNone:
    case ViewerCommand::kFitScene:  // CameraControls carried out these two
    case ViewerCommand::kResetCamera:
      break;
  }
}

void GlViewer::change_play(ViewerCommand command) {
  play_.is_paused = command != ViewerCommand::kTogglePause || !play_.is_paused;
  if (command == ViewerCommand::kStepOn) ++play_.steps;
  if (command == ViewerCommand::kStepBack) --play_.steps;
}

void GlViewer::change_exposure(ViewerCommand command) {
  if (state_.frame.image && state_.frame.image->format == PixelFormat::kDisplay8)
    return notify("display8 pixels are exposed where they are rendered: start with --pixels half");
  if (command == ViewerCommand::kDarker) exposure_.nudge(-ExposureControl::kKeyEv);
  if (command == ViewerCommand::kBrighter) exposure_.nudge(ExposureControl::kKeyEv);
  if (command == ViewerCommand::kNextCurve) exposure_.next_curve();
  if (command == ViewerCommand::kResetExposure) exposure_.reset();
  exposure_.advance(0);
  char line[96];
  const std::string curve(tone_curve_name(exposure_.display().tone));
  std::snprintf(line, sizeof(line), "--exposure %.2f --tone %s", exposure_.display().exposure_ev,
                curve.c_str());
  notify(line);
}

void GlViewer::take_newest_frame() {
  if (auto exposure = newest_exposure_.take()) exposure_ = *exposure;
  std::optional<ViewerFrame> frame = newest_.take();
  if (!frame) return;
  if (const Status shown = picture_->show(*frame->image, frame->stands_for); !shown.is_ok()) {
    log_warn("frame-not-shown", shown.message());
    return;
  }
  state_.frame = *std::move(frame);
  if (state_.frame.average_ev) exposure_.measured(*state_.frame.average_ev);
  is_frame_new_ = true;
  frames_drawn_ += state_.frame.is_full;
  draws_left_ = std::max(draws_left_, 1);
}

void GlViewer::take_news(double now_seconds) {
  if (auto cluster = newest_status_.take()) {
    const bool had_slaves = state_.cluster && !state_.cluster->slaves.empty();
    state_.cluster = std::move(cluster);
    if (state_.shows_overlay || had_slaves == state_.cluster->slaves.empty())
      draws_left_ = std::max(draws_left_, 1);
  }
  if (auto notice = newest_notice_.take()) {
    state_.notice = *std::move(notice);
    notice_until_seconds_ = now_seconds + kNoticeSeconds;
    draws_left_ = kSettleDraws;
  } else if (!state_.notice.empty() && now_seconds >= notice_until_seconds_) {
    state_.notice.clear();
    draws_left_ = std::max(draws_left_, 1);
  }
}

// Logs, for measurements, when a frame came to be seen and how long the oldest change of the view
// that the frame answers has waited for that.
void GlViewer::tell_shown() {
  const TimePoint now = Clock::now();
  const ViewerFrame& frame = state_.frame;
  double waited_seconds = 0;
  while (!unanswered_.empty() && unanswered_.front().revision <= frame.revision) {
    waited_seconds = std::max(waited_seconds, seconds(now - unanswered_.front().time));
    unanswered_.pop_front();
  }
  log_debug("frame-shown", frame.is_full ? "all that was asked for" : "reduced",
            {{"at", at_seconds(now)},
             {"frame", std::to_string(frame.stats.frame)},
             {"revision", std::to_string(frame.revision)},
             {"width", std::to_string(frame.image->width_px)},
             {"height", std::to_string(frame.image->height_px)},
             {"passes", std::to_string(frame.is_full ? frame.passes : 0)},
             {"waited", std::to_string(waited_seconds)}});
}

void GlViewer::update_rate(double now_seconds) {
  const double elapsed = now_seconds - rate_from_seconds_;
  if (elapsed < kRateWindowSeconds) return;
  const std::uint64_t count = newest_.put_count();
  state_.frames_per_second = static_cast<double>(count - rate_from_count_) / elapsed;
  rate_from_seconds_ = now_seconds;
  rate_from_count_ = count;
  draws_left_ = std::max(draws_left_, 1);
}

void GlViewer::update_view(double now_seconds) {
  if (const PixelSize size = window_->framebuffer_size(); size != framebuffer_) {
    framebuffer_ = size;
    controls_.set_viewport(size.width_px, size.height_px);
    resize_.on_resize(size, now_seconds);
    draws_left_ = std::max(draws_left_, 1);
  }
  const std::optional<PixelSize> settled = resize_.poll(now_seconds);
  View view;
  bool is_play = false;
  {
    MutexLock lock(mutex_);
    is_play = play_ != view_.play;
    if (!settled && !is_play && controls_.camera() == view_.camera) return;
    view_.play = play_;
    view_.camera = controls_.camera();
    view_.width_px = resize_.size().width_px;
    view_.height_px = resize_.size().height_px;
    ++view_.revision;
    view = view_;
  }
  view_changed_.notify_all();
  const TimePoint now = Clock::now();
  unanswered_.push_back({view.revision, now});
  if (unanswered_.size() > kUnansweredMax) unanswered_.pop_front();
  log_debug("view-changed",
            settled   ? "size"
            : is_play ? "play"
                      : "camera",
            {{"at", at_seconds(now)},
             {"revision", std::to_string(view.revision)},
             {"width", std::to_string(view.width_px)},
             {"height", std::to_string(view.height_px)}});
}

bool GlViewer::is_screenshot_due() const {
  return !options_.screenshot_path.empty() &&
         frames_drawn_ >= std::max(1, options_.screenshot_after);
}

void GlViewer::draw() {
  if (framebuffer_.width_px < 1 || framebuffer_.height_px < 1) return;  // minimised
  const int pass_count = is_screenshot_due() ? kSettleDraws : 1;
  for (int pass = 0; pass < pass_count; ++pass) {
    picture_->set_display(exposure_.display());
    picture_->draw(framebuffer_, state_.tints_tiles);
    overlay_.draw(state_);
  }
  if (is_screenshot_due()) {
    screenshot_status_ = options_.save(picture_->read_back(framebuffer_), options_.screenshot_path);
    is_quit_wanted_ = true;
  }
  window_->swap();
  if (std::exchange(is_frame_new_, false)) tell_shown();
}

void GlViewer::run(const std::function<bool()>& should_stop) {
  const double period = window_->refresh_seconds();
  double last_seconds = Window::now_seconds();
  double next_draw_seconds = last_seconds;
  rate_from_seconds_ = last_seconds;
  while (!is_quit_wanted_ && !window_->is_close_wanted() && !(should_stop && should_stop())) {
    // Not every display's swap waits for the refresh (a virtual one does not), so the clock paces
    // draws. Only changes are drawn, so that an idle window leaves the processors to rendering.
    const bool is_waiting_to_draw =
        draws_left_ > 0 || controls_.is_flying() || !exposure_.is_settled() || !newest_.is_empty();
    const double wait_seconds = is_waiting_to_draw
                                    ? std::max(0.0, next_draw_seconds - Window::now_seconds())
                                    : kIdleSeconds;
    handle(window_->wait_events(std::min(wait_seconds, kIdleSeconds)));
    const double now_seconds = Window::now_seconds();
    controls_.advance(now_seconds - last_seconds);
    if (exposure_.advance(now_seconds - last_seconds)) draws_left_ = std::max(draws_left_, 1);
    last_seconds = now_seconds;
    update_view(now_seconds);
    update_rate(now_seconds);
    take_news(now_seconds);
    if (now_seconds < next_draw_seconds) continue;
    take_newest_frame();
    if (draws_left_ == 0) continue;
    --draws_left_;
    next_draw_seconds = now_seconds + period;
    draw();
  }
}

}  // namespace

Status Viewer::check_display() { return Window::check_display(); }

Result<std::unique_ptr<Viewer>> Viewer::open(const ViewerOptions& options) {
  if (!options.screenshot_path.empty() && !options.save) {
    return Status::invalid_argument("a screenshot needs a writer: set save");
  }
  Result<std::unique_ptr<Window>> window =
      Window::open(options.title, {std::max(1, options.width_px), std::max(1, options.height_px)});
  if (!window.is_ok()) return window.status();
  Result<std::unique_ptr<PictureGl>> picture = PictureGl::create();
  if (!picture.is_ok()) return picture.status();
  return std::unique_ptr<Viewer>(
      std::make_unique<GlViewer>(options, *std::move(window), *std::move(picture)));
}

}  // namespace tessera::master
