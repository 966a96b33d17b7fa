// SPDX-License-Identifier: Apache-2.0
#include "common/net/backoff.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "common/base/limits.h"

namespace tessera::net {
namespace {

using namespace std::chrono_literals;
using std::chrono::milliseconds;

TEST(Backoff, PausesGrowWithinTheirBounds) {
  for (std::uint64_t seed = 0; seed < 100; ++seed) {
    Backoff backoff(seed);
    double nominal_ms = kReconnectFirstMs;
    for (int k = 0; k < 20; ++k) {
      const double ms = static_cast<double>(backoff.next().count());
      EXPECT_GE(ms, nominal_ms * 0.5 - 1) << "seed " << seed << " attempt " << k;
      EXPECT_LE(ms, std::min<double>(kReconnectMaxMs, nominal_ms * 1.5));
      nominal_ms = std::min<double>(kReconnectMaxMs, nominal_ms * 2);
    }
  }
}

TEST(Backoff, SlavesDoNotKnockTogether) {
  Backoff a(1);
  Backoff b(2);
  int different = 0;
  for (int k = 0; k < 10; ++k) different += a.next() != b.next() ? 1 : 0;
  EXPECT_GE(different, 5);
}

TEST(Backoff, OnlyAStableSessionStartsItAnew) {
  const TimePoint t0{};
  Backoff backoff(5);
  for (int k = 0; k < 10; ++k) (void)backoff.next();
  backoff.session_began(t0);
  backoff.session_ended(t0 + 59s);
  EXPECT_GE(backoff.next(), milliseconds(kReconnectMaxMs / 2));
  backoff.session_began(t0 + 100s);
  backoff.session_ended(t0 + 160s);
  EXPECT_LE(backoff.next(), milliseconds(kReconnectFirstMs * 3 / 2));
}

}  // namespace
}  // namespace tessera::net
