// SPDX-License-Identifier: Apache-2.0
#include "master/session/cluster_speed.h"

#include <algorithm>
#include <cmath>

namespace tessera {
namespace {

constexpr double kWeight = 0.3;      // of the newest frame
constexpr double kOtherSpeed = 1.5;  // a measure off by more is no noise

}  // namespace

ClusterSpeed::Place ClusterSpeed::place(double rays) {
  const double at = std::clamp(std::log2(std::max(rays, 1.0)) / 2, 0.0, kKnots - 1.0);
  const std::size_t knot = std::min(static_cast<std::size_t>(at), kKnots - 2);
  return {knot, at - static_cast<double>(knot)};
}

double ClusterSpeed::logarithm(const Place& at) const {
  return std::lerp(logarithm_.at(at.knot), logarithm_.at(at.knot + 1), at.share);
}

double ClusterSpeed::rays_per_second(double rays) const {
  return has_measured_ ? std::exp(logarithm(place(rays))) : 0;
}

void ClusterSpeed::measured(double rays, double frame_seconds) {
  const double rate = std::log(rays / frame_seconds);
  if (!has_measured_) {
    logarithm_.fill(rate);
    has_measured_ = true;
  }
  const Place at = place(rays);
  const double error = rate - logarithm(at);
  if (std::abs(error) > std::log(kOtherSpeed) && is_known_.at(at.knot) &&
      is_known_.at(at.knot + 1)) {
    move(kWeight * error);
  } else {
    learn(at, error);
  }
}

void ClusterSpeed::at_most(double rays, double seconds_so_far) {
  const double most = std::log(rays / seconds_so_far);
  if (!has_measured_) logarithm_.fill(most);
  has_measured_ = true;
  move(std::min(0.0, most - logarithm(place(rays))));
}

// Takes the step that brings the curve to the measure and moves the knots least; where there was a
// measure before, only a part of that step.
void ClusterSpeed::learn(const Place& at, double error) {
  const double lower = 1 - at.share, upper = at.share;
  const bool is_known = is_known_.at(at.knot) && is_known_.at(at.knot + 1);
  const double step = (is_known ? kWeight : 1) * error / (lower * lower + upper * upper);
  logarithm_.at(at.knot) += step * lower;
  logarithm_.at(at.knot + 1) += step * upper;
  is_known_.at(at.knot) = is_known_.at(at.knot + 1) = true;
  for (std::size_t knot = 0; knot < kKnots; ++knot)
    logarithm_.at(knot) = logarithm_.at(nearest_known(knot));
}

void ClusterSpeed::move(double by) {
  for (double& logarithm : logarithm_) logarithm += by;
}

std::size_t ClusterSpeed::nearest_known(std::size_t knot) const {
  for (std::size_t away = 0; away < kKnots; ++away) {
    if (away <= knot && is_known_.at(knot - away)) return knot - away;
    if (knot + away < kKnots && is_known_.at(knot + away)) return knot + away;
  }
  return knot;
}

}  // namespace tessera
