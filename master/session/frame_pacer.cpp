#include "master/session/frame_pacer.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace tessera {
namespace {

constexpr double kWeight = 0.3;  // of the newest frame
// The scale of a moving picture stays while it is too large by so much, which lets a frame take 1.1
// times the budget, or too small by so much, which uses 0.7 of it.
constexpr double kTooLarge = 1.05, kTooSmall = 1.2;
// Share of the pixels, with one sample each, that a cluster of unknown speed is asked for.
constexpr double kFirstShare = 1.0 / 16;

// Fewer VPLs than this make surfaces flicker from frame to frame.
constexpr int kVplsMin = 16;

double pixels(const FrameSettings& s) { return static_cast<double>(s.width_px) * s.height_px; }

// What a pixel of igi costs whatever the number of its VPLs (surface, filter, its share of making them),
// in rays towards VPLs: the room of 640x480 pixels with 64 VPLs takes 2.1 to 2.3 times as long as with 16,
// and (20 + 65) / (20 + 17) is 2.3. Without it a moving frame, which is given few VPLs, would take almost
// twice its time after one at rest.
constexpr double kIgiPixelRays = 20;

// All rays are taken to cost as much.
double rays_per_pixel(const FrameSettings& s) {
  if (s.renderer == Renderer::kIgi) return kIgiPixelRays + s.samples_per_pixel + s.vpls;
  if (s.renderer == Renderer::kPath) return s.samples_per_pixel * 2.0 * (1 + s.bounces);
  return s.samples_per_pixel * (1.0 + s.light_samples);
}
double rays(const FrameSettings& s) { return pixels(s) * rays_per_pixel(s); }

// One step down. Returns: whether there was one.
bool reduce(FrameSettings& s) {
  if (s.samples_per_pixel > 1) {
    s.samples_per_pixel /= 2;
  } else if (s.renderer == Renderer::kDirect && s.light_samples > 1) {
    s.light_samples /= 2;
  } else if (s.renderer == Renderer::kIgi && s.vpls >= 2 * kVplsMin) {
    s.vpls /= 2;
  } else {
    return false;
  }
  return true;
}

int scaled_side(int side_px, double scale) {
  return std::max(static_cast<int>(std::lround(side_px * scale)), 1);
}

FrameSettings at_scale(FrameSettings s, const FrameSettings& wanted, double scale) {
  s.width_px = scaled_side(wanted.width_px, scale);
  s.height_px = scaled_side(wanted.height_px, scale);
  return s;
}

}  // namespace

double FramePacer::budget_rays(const FrameSettings& wanted) const {
  return rays_per_second_ > 0 ? rays_per_second_ * budget_seconds_ : pixels(wanted) * kFirstShare;
}

FrameSettings FramePacer::moving(const FrameSettings& wanted) {
  if (budget_seconds_ <= 0) return wanted;
  const double budget = budget_rays(wanted);
  FrameSettings s = wanted;
  while (rays(s) > budget && reduce(s)) continue;
  const double ideal = std::clamp(std::sqrt(budget / rays(s)), kScaleMin, 1.0);
  if (scale_ > ideal * kTooLarge || scale_ * kTooSmall < ideal) scale_ = ideal;
  return at_scale(s, wanted, scale_);
}

FrameSettings FramePacer::scaled(const FrameSettings& wanted, double scale) const {
  if (budget_seconds_ <= 0) return wanted;
  const double budget = budget_rays(wanted);
  FrameSettings s = at_scale(wanted, wanted, scale);
  while (rays(s) > budget && reduce(s)) continue;
  return s;
}

double FramePacer::expected_seconds(const FrameSettings& settings) const {
  return rays_per_second_ > 0 ? rays(settings) / rays_per_second_
                              : std::numeric_limits<double>::infinity();
}

bool FramePacer::is_better(const FrameSettings& a, const FrameSettings& b) {
  if (pixels(a) != pixels(b)) return pixels(a) > pixels(b);
  return rays_per_pixel(a) > rays_per_pixel(b);
}

void FramePacer::frame_done(const FrameSettings& settings, double frame_seconds) {
  if (!(frame_seconds > 0)) return;
  const double measured = rays(settings) / frame_seconds;
  rays_per_second_ += (rays_per_second_ == 0 ? 1 : kWeight) * (measured - rays_per_second_);
}

void FramePacer::frame_overdue(const FrameSettings& settings, double seconds_so_far) {
  if (!(seconds_so_far > 0)) return;
  const double most = rays(settings) / seconds_so_far;
  rays_per_second_ = rays_per_second_ == 0 ? most : std::min(rays_per_second_, most);
}

}  // namespace tessera
