// SPDX-License-Identifier: Apache-2.0
#include "common/net/backoff.h"

#include <algorithm>

#include "common/base/limits.h"

namespace tessera::net {

namespace {

constexpr std::chrono::minutes kStable{1};

}  // namespace

Backoff::Backoff(std::uint64_t seed) : random_(seed) {}

std::chrono::milliseconds Backoff::next() {
  const double nominal_ms =
      std::min<double>(kReconnectMaxMs, kReconnectFirstMs * (1 << doublings_));
  if (nominal_ms < kReconnectMaxMs) ++doublings_;
  // 53 random bits: the same numbers with every standard library.
  const double unit = static_cast<double>(random_() >> 11) * 0x1p-53;
  const double ms = std::min<double>(kReconnectMaxMs, nominal_ms * (0.5 + unit));
  return std::chrono::milliseconds(static_cast<std::int64_t>(ms));
}

void Backoff::session_began(TimePoint now) {
  in_session_ = true;
  began_ = now;
}

void Backoff::session_ended(TimePoint now) {
  if (in_session_ && now - began_ >= kStable) doublings_ = 0;
  in_session_ = false;
}

}  // namespace tessera::net
