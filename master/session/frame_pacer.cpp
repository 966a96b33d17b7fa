// SPDX-License-Identifier: Apache-2.0
#include "master/session/frame_pacer.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace tessera {
namespace {

// The scale of a moving picture stays while it is too large by at most kTooLarge, which lets a
// frame take 1.1 times the budget, or too small by at most kTooSmall, which uses 0.7 of it.
constexpr double kTooLarge = 1.05, kTooSmall = 1.2;
// Share of the budget that a frame is expected to take: frames differ, and a person waits for the
// slower ones.
constexpr double kBudgetShare = 0.85;
// Share of the pixels, with one sample each, that a cluster of unknown speed is asked for.
constexpr double kFirstShare = 1.0 / 16;
constexpr int kSizeSteps = 2;

// Fewer VPLs than this make surfaces flicker from frame to frame.
constexpr int kVplsMin = 16;

double pixels(const FrameSettings& s) { return static_cast<double>(s.width_px) * s.height_px; }

// What a pixel of igi costs whatever the number of its VPLs (surface, filter, its share of making
// them), in rays towards VPLs. The room of 640x480 pixels with 64 VPLs takes 2.1 to 2.3 times as
// long as with 16, and (20 + 65) / (20 + 17) is 2.3. Without this constant a moving frame, which is
// given few VPLs, would take almost twice its time after one at rest.
constexpr double kIgiPixelRays = 20;

// All rays are taken to cost the same.
double rays_per_pixel(const FrameSettings& s) {
  if (s.renderer == Renderer::kIgi) return kIgiPixelRays + s.samples_per_pixel + s.vpls;
  if (s.renderer == Renderer::kPath) return s.samples_per_pixel * 2.0 * (1 + s.bounces);
  return s.samples_per_pixel * (1.0 + s.light_samples);
}
double rays(const FrameSettings& s) { return pixels(s) * rays_per_pixel(s); }

// Reduces samples, light samples or VPLs by one step. Returns: whether there was a step left.
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

double FramePacer::budget_rays(const FrameSettings& sized, const FrameSettings& wanted) const {
  const double rate = speed_.rays_per_second(rays(sized));
  return rate > 0 ? kBudgetShare * rate * budget_seconds_ : pixels(wanted) * kFirstShare;
}

FrameSettings FramePacer::moving(const FrameSettings& wanted) {
  if (budget_seconds_ <= 0) return wanted;
  FrameSettings s = wanted;
  while (rays(s) > budget_rays(s, wanted) && reduce(s)) continue;
  // What fits depends on what the size costs, and the size on what fits; the last frame's scale is
  // close enough to begin with.
  double ideal = scale_;
  for (int step = 0; step < kSizeSteps; ++step) {
    const double budget = budget_rays(at_scale(s, wanted, ideal), wanted);
    ideal = std::clamp(std::sqrt(budget / rays(s)), kScaleMin, 1.0);
  }
  if (scale_ > ideal * kTooLarge || scale_ * kTooSmall < ideal) scale_ = ideal;
  return at_scale(s, wanted, scale_);
}

FrameSettings FramePacer::scaled(const FrameSettings& wanted, double scale) const {
  if (budget_seconds_ <= 0) return wanted;
  FrameSettings s = at_scale(wanted, wanted, scale);
  while (rays(s) > budget_rays(s, wanted) && reduce(s)) continue;
  return s;
}

double FramePacer::expected_seconds(const FrameSettings& settings) const {
  const double rate = speed_.rays_per_second(rays(settings));
  return rate > 0 ? rays(settings) / rate : std::numeric_limits<double>::infinity();
}

bool FramePacer::is_better(const FrameSettings& a, const FrameSettings& b) {
  if (pixels(a) != pixels(b)) return pixels(a) > pixels(b);
  return rays_per_pixel(a) > rays_per_pixel(b);
}

void FramePacer::frame_done(const FrameSettings& settings, double frame_seconds) {
  if (frame_seconds > 0) speed_.measured(rays(settings), frame_seconds);
}

void FramePacer::frame_overdue(const FrameSettings& settings, double seconds_so_far) {
  if (seconds_so_far > 0) speed_.at_most(rays(settings), seconds_so_far);
}

}  // namespace tessera
