#include "master/display/viewer.h"

#include <algorithm>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "common/base/limits.h"
#include "common/base/log.h"
#include "common/base/mutex.h"
#include "master/display/camera_controls.h"
#include "master/display/newest_slot.h"
#include "master/display/overlay.h"
#include "master/display/picture_gl.h"
#include "master/display/picture_layout.h"
#include "master/display/window.h"

namespace tessera::master {

namespace {

constexpr double kIdleSeconds = 0.05;  // longest wait, so that should_stop is asked often
constexpr int kSettleDraws = 3;        // the overlay's panels find their size in the draws before
constexpr double kRateWindowSeconds = 1;  // frames per second are counted over

class GlViewer final : public Viewer {
 public:
  GlViewer(const ViewerOptions& options, std::unique_ptr<Window> window,
           std::unique_ptr<PictureGl> picture);
  ~GlViewer() override;

  void publish(ViewerFrame frame) override;
  View view() const override;
  void run(const std::function<bool()>& should_stop) override;
  Status screenshot_status() const override { return screenshot_status_; }

 private:
  void handle(const std::vector<InputEvent>& events);
  void take_newest_frame();
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
  ResizeDebounce resize_;
  PixelSize framebuffer_;
  int frames_drawn_ = 0;  // distinct published frames
  int draws_left_ = kSettleDraws;
  bool is_quit_wanted_ = false;
  double rate_from_seconds_ = 0;
  std::uint64_t rate_from_count_ = 0;
  Status screenshot_status_;

  NewestSlot<ViewerFrame> newest_;
  mutable Mutex mutex_;
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
  if (!options_.screenshot_path.empty()) {
    screenshot_status_ = Status::cancelled("the window was closed before " +
                                           options_.screenshot_path + " was taken");
  }
  view_ = {controls_.camera(), resize_.size().width_px, resize_.size().height_px, 1};
}

GlViewer::~GlViewer() = default;

void GlViewer::publish(ViewerFrame frame) {
  if (!frame.image) return;
  newest_.put(std::move(frame));
  window_->wake();
}

Viewer::View GlViewer::view() const {
  MutexLock lock(mutex_);
  return view_;
}

void GlViewer::handle(const std::vector<InputEvent>& events) {
  for (const InputEvent& event : events) {
    draws_left_ = kSettleDraws;
    const bool is_overlay_kind =
        event.kind == InputEvent::Kind::kButtonDown || event.kind == InputEvent::Kind::kScroll;
    if (is_overlay_kind && overlay_.is_mouse_over()) continue;
    switch (controls_.handle(event)) {
      case ViewerCommand::kNone:
        break;
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
    }
  }
}

void GlViewer::take_newest_frame() {
  std::optional<ViewerFrame> frame = newest_.take();
  if (!frame) return;
  if (const Status shown = picture_->show(*frame->image); !shown.is_ok()) {
    log_warn("frame-not-shown", shown.message());
    return;
  }
  state_.frame = *std::move(frame);
  ++frames_drawn_;
  draws_left_ = std::max(draws_left_, 1);
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
  MutexLock lock(mutex_);
  if (!settled && controls_.camera() == view_.camera) return;
  view_.camera = controls_.camera();
  view_.width_px = resize_.size().width_px;
  view_.height_px = resize_.size().height_px;
  ++view_.revision;
}

bool GlViewer::is_screenshot_due() const {
  return !options_.screenshot_path.empty() &&
         frames_drawn_ >= std::max(1, options_.screenshot_after);
}

void GlViewer::draw() {
  if (framebuffer_.width_px < 1 || framebuffer_.height_px < 1) return;  // minimised
  const int pass_count = is_screenshot_due() ? kSettleDraws : 1;
  for (int pass = 0; pass < pass_count; ++pass) {
    picture_->draw(framebuffer_, state_.tints_tiles);
    overlay_.draw(state_);
  }
  if (is_screenshot_due()) {
    screenshot_status_ = options_.save(picture_->read_back(framebuffer_), options_.screenshot_path);
    is_quit_wanted_ = true;
  }
  window_->swap();
}

void GlViewer::run(const std::function<bool()>& should_stop) {
  const double period = window_->refresh_seconds();
  double last_seconds = Window::now_seconds();
  double next_draw_seconds = last_seconds;
  rate_from_seconds_ = last_seconds;
  while (!is_quit_wanted_ && !window_->is_close_wanted() && !(should_stop && should_stop())) {
    // Not every display's swap waits for the refresh (a virtual one does not): pace by the clock,
    // and draw only what changed, so that an idle window leaves the processors to the rendering.
    const bool is_waiting_to_draw = draws_left_ > 0 || controls_.is_flying() || !newest_.is_empty();
    const double wait_seconds = is_waiting_to_draw
                                    ? std::max(0.0, next_draw_seconds - Window::now_seconds())
                                    : kIdleSeconds;
    handle(window_->wait_events(std::min(wait_seconds, kIdleSeconds)));
    const double now_seconds = Window::now_seconds();
    controls_.advance(now_seconds - last_seconds);
    last_seconds = now_seconds;
    update_view(now_seconds);
    update_rate(now_seconds);
    if (now_seconds < next_draw_seconds) continue;
    take_newest_frame();
    if (draws_left_ == 0) continue;
    --draws_left_;
    next_draw_seconds = now_seconds + period;
    draw();
  }
}

}  // namespace

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
