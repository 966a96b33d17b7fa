#include "master/display/frame_pacer.h"

#include <algorithm>
#include <cmath>

namespace tessera::master {
namespace {

constexpr double kWeight = 0.3;  // of the newest frame
// A picture whose size changes with every frame is worse than a slow one: the scale follows only
// when it is off by so much.
constexpr double kScaleHysteresis = 1.15;
// A full frame that takes a little longer than asked for is let through.
constexpr double kPatience = 2;

double pixels(const FrameSettings& s) { return static_cast<double>(s.width_px) * s.height_px; }

// Fewer VPLs than this make surfaces flicker from frame to frame.
constexpr int kMovingVplsMin = 16;

// In rays, all of which are taken to cost as much.
double work_per_pixel(const FrameSettings& s) {
  if (s.renderer == Renderer::kIgi) return 1.0 * s.samples_per_pixel + s.vpls;
  if (s.renderer == Renderer::kPath) return s.samples_per_pixel * 2.0 * (1 + s.bounces);
  return s.samples_per_pixel * (1.0 + s.light_samples);
}
double work(const FrameSettings& s) { return pixels(s) * work_per_pixel(s); }

// One step down. Returns: whether there was one.
bool reduce(FrameSettings& s) {
  if (s.samples_per_pixel > 1) {
    s.samples_per_pixel /= 2;
  } else if (s.renderer == Renderer::kDirect && s.light_samples > 1) {
    s.light_samples /= 2;
  } else if (s.renderer == Renderer::kIgi && s.vpls >= 2 * kMovingVplsMin) {
    s.vpls /= 2;
  } else {
    return false;
  }
  return true;
}

int scaled(int side, double scale) {
  return std::max(static_cast<int>(std::lround(side * scale)), 1);
}

}  // namespace

void FramePacer::moved(TimePoint now) {
  moved_at_ = now;
  has_moved_ = true;
}

bool FramePacer::is_moving(TimePoint now) const {
  return target_seconds_ > 0 && has_moved_ && seconds(now - moved_at_) < kRestSeconds;
}

double FramePacer::seconds_for(const FrameSettings& s) const {
  return work_per_second_ > 0 ? work(s) / work_per_second_ : 0;
}

FrameSettings FramePacer::settings(const FrameSettings& wanted, TimePoint now) {
  FrameSettings s = wanted;
  if (!is_moving(now)) {
    scale_ = 1;
    return s;
  }
  // Before anything is measured: a quarter of the pixels, one sample each.
  const double budget =
      work_per_second_ > 0 ? work_per_second_ * target_seconds_ : pixels(wanted) / 4;
  while (work(s) > budget && reduce(s)) continue;
  const double ideal =
      std::clamp(std::sqrt(budget / (pixels(wanted) * work_per_pixel(s))), kScaleMin, 1.0);
  if (ideal > scale_ * kScaleHysteresis || ideal * kScaleHysteresis < scale_) scale_ = ideal;
  s.width_px = scaled(wanted.width_px, scale_);
  s.height_px = scaled(wanted.height_px, scale_);
  return s;
}

void FramePacer::frame_done(const FrameSettings& settings, double frame_seconds) {
  if (!(frame_seconds > 0)) return;
  const double rate = work(settings) / frame_seconds;
  work_per_second_ += (work_per_second_ == 0 ? 1 : kWeight) * (rate - work_per_second_);
}

bool FramePacer::is_left_behind(const FrameSettings& settings, const FrameSettings& wanted,
                                TimePoint now) const {
  const bool is_full = settings.width_px == wanted.width_px &&
                       settings.samples_per_pixel == wanted.samples_per_pixel &&
                       settings.light_samples == wanted.light_samples &&
                       settings.vpls == wanted.vpls;
  return is_moving(now) && is_full && seconds_for(settings) > kPatience * target_seconds_;
}

}  // namespace tessera::master
