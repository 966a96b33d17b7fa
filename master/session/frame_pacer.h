// SPDX-License-Identifier: Apache-2.0
// How much of a picture's quality can be had in a given time: fewer samples first, then fewer
// pixels. Pure.
//
// What the cluster can do is measured by the frames that came; so a slave more or less changes the
// next frame's size.
//
// Threads. One owner. Invariants. (1) Settings given out are `wanted` with sides of at least one
// pixel and at most those wanted, and with as many samples or fewer. (2) Without a budget (0)
// nothing is ever reduced.
#pragma once

#include "common/frame/frame_settings.h"
#include "master/session/cluster_speed.h"

namespace tessera {

class FramePacer {
 public:
  // The least share of each side that a moving picture may have.
  static constexpr double kScaleMin = 0.125;

  explicit FramePacer(double budget_seconds) : budget_seconds_(budget_seconds) {}

  // `wanted` as it can be had within the budget while something moves. The size keeps still until
  // it is clearly off, for a picture whose size changes with every frame is worse than a slow one.
  FrameSettings moving(const FrameSettings& wanted);

  // `wanted` with both sides times `scale`, and as few samples as the budget asks for.
  FrameSettings scaled(const FrameSettings& wanted, double scale) const;

  // How long a frame with these settings is expected to take; infinite before a measurement.
  double expected_seconds(const FrameSettings& settings) const;

  // Whether `a` shows more than `b` of one view: more pixels, or as many with more samples each.
  static bool is_better(const FrameSettings& a, const FrameSettings& b);

  // A frame with these settings took so long.
  void frame_done(const FrameSettings& settings, double frame_seconds);

  // A frame has been in work for so long and is not done: the cluster is no faster than that.
  void frame_overdue(const FrameSettings& settings, double seconds_so_far);

 private:
  // Rays of a frame like `sized` that fit the budget; before anything is measured, a
  // sixteenth of the wanted pixels' worth.
  double budget_rays(const FrameSettings& sized, const FrameSettings& wanted) const;

  double budget_seconds_;
  ClusterSpeed speed_;
  double scale_ = 1;  // last one given while moving
};

}  // namespace tessera
