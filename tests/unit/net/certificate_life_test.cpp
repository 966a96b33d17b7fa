// SPDX-License-Identifier: Apache-2.0
#include "common/net/certificate_life.h"

#include <gtest/gtest.h>

namespace tessera::net {
namespace {

using namespace std::chrono_literals;
constexpr std::int64_t kDay = 86400;
constexpr CertificateLife kYear{1'000'000, 1'000'000 + 366 * kDay};

TEST(CertificateLife, RenewalIsDueAtTwoThirds) {
  EXPECT_FALSE(is_renewal_due(kYear, kYear.begin_s - kDay));
  EXPECT_FALSE(is_renewal_due(kYear, kYear.begin_s + 244 * kDay - 1));
  EXPECT_TRUE(is_renewal_due(kYear, kYear.begin_s + 244 * kDay));
  EXPECT_TRUE(is_renewal_due(kYear, kYear.end_s + kDay));
}

TEST(CertificateLife, NothingIsSaidBeforeTheLastDay) {
  ExpiryNotice notice;
  const TimePoint now{};
  EXPECT_FALSE(notice.look(kYear, kYear.begin_s, now));
  EXPECT_FALSE(notice.look(kYear, kYear.end_s - kDay - 1, now));
  EXPECT_EQ(notice.look(kYear, kYear.end_s - kDay + 60, now), "ends in 23 h 59 min");
}

TEST(CertificateLife, TheLastDayIsToldOnceAnHourAndTheEndAtOnce) {
  ExpiryNotice notice;
  TimePoint now{};
  EXPECT_TRUE(notice.look(kYear, kYear.end_s - 7200, now));
  EXPECT_FALSE(notice.look(kYear, kYear.end_s - 7199, now + 1s));
  EXPECT_FALSE(notice.look(kYear, kYear.end_s - 3601, now + 3599s));
  EXPECT_EQ(notice.look(kYear, kYear.end_s - 3600, now + 1h), "ends in 1 h 0 min");
  EXPECT_FALSE(notice.look(kYear, kYear.end_s - 1, now + 1h + 1s));
  EXPECT_EQ(notice.look(kYear, kYear.end_s, now + 1h + 2s), "has ended");
  EXPECT_FALSE(notice.look(kYear, kYear.end_s + 1, now + 1h + 3s));
  EXPECT_TRUE(notice.look(kYear, kYear.end_s + 3600, now + 3h));
}

TEST(CertificateLife, ANewCertificateIsToldOfByItself) {
  ExpiryNotice notice;
  const TimePoint now{};
  EXPECT_TRUE(notice.look(kYear, kYear.end_s - 60, now));
  EXPECT_FALSE(notice.look({kYear.begin_s, kYear.end_s + 2 * kDay}, kYear.end_s, now));
  EXPECT_TRUE(notice.look({kYear.begin_s, kYear.end_s + 1}, kYear.end_s - 60, now));
}

}  // namespace
}  // namespace tessera::net
