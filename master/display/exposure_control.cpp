// SPDX-License-Identifier: Apache-2.0
#include "master/display/exposure_control.h"

#include <algorithm>
#include <cmath>

namespace tessera::master {
namespace {

constexpr double kSettledEv = 1.0 / 64;  // less than anybody sees

}  // namespace

void ExposureControl::measured(double average_ev) {
  if (!first_ev_) first_ev_ = average_ev;
  newest_ev_ = average_ev;
}

double ExposureControl::target_ev() const {
  return is_automatic_ && newest_ev_ ? *first_ev_ - *newest_ev_ : 0;
}

bool ExposureControl::is_settled() const {
  return std::fabs(target_ev() - adapted_ev_) < kSettledEv;
}

bool ExposureControl::advance(double seconds) {
  const float before = display_.exposure_ev;
  if (is_settled()) {
    adapted_ev_ = target_ev();
  } else {
    adapted_ev_ +=
        (target_ev() - adapted_ev_) * (1 - std::exp(-std::max(seconds, 0.0) / kAdaptSeconds));
  }
  display_.exposure_ev = std::clamp(start_ev_ + by_hand_ev_ + static_cast<float>(adapted_ev_),
                                    -kExposureEvMax, kExposureEvMax);
  return display_.exposure_ev != before;
}

void ExposureControl::nudge(float ev) {
  by_hand_ev_ = std::clamp(by_hand_ev_ + ev, -kExposureEvMax, kExposureEvMax);
}

void ExposureControl::next_curve() {
  display_.tone = static_cast<ToneCurve>((static_cast<int>(display_.tone) + 1) % kToneCurves);
}

void ExposureControl::reset() { by_hand_ev_ = 0; }

}  // namespace tessera::master
