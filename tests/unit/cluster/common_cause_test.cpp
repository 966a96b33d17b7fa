// SPDX-License-Identifier: Apache-2.0
// Slaves that are all lost in one way at one time speak of the master's own link, others do not.
#include "master/cluster/common_cause.h"

#include <gtest/gtest.h>

namespace tessera::master {
namespace {

using namespace std::chrono_literals;
const TimePoint kStart{100s};

TEST(CommonCause, SilenceOfAllAtOnceIsTheMastersOwnLink) {
  CommonCause cause(3s);
  EXPECT_FALSE(cause.lost(LossKind::kSilent, 2, kStart));
  EXPECT_TRUE(cause.text().empty()) << "two are here";
  EXPECT_FALSE(cause.lost(LossKind::kSilent, 1, kStart + 100ms));
  EXPECT_TRUE(cause.lost(LossKind::kSilent, 0, kStart + 200ms));
  EXPECT_NE(cause.text().find("all 3 slaves"), std::string::npos) << cause.text();
  EXPECT_NE(cause.text().find("nothing reaches this master"), std::string::npos);
  cause.joined();
  EXPECT_TRUE(cause.text().empty()) << "one is here again";
}

TEST(CommonCause, SlavesThatHearNothingTellOfTheOtherDirection) {
  CommonCause cause(3s);
  EXPECT_FALSE(cause.lost(LossKind::kUnheard, 1, kStart));
  EXPECT_TRUE(cause.lost(LossKind::kUnheard, 0, kStart + 1s));
  EXPECT_NE(cause.text().find("nothing that this master sends arrives"), std::string::npos)
      << cause.text();
}

TEST(CommonCause, ACrashAmongThemExplainsNothing) {
  CommonCause cause(3s);
  EXPECT_FALSE(cause.lost(LossKind::kSilent, 2, kStart));
  EXPECT_FALSE(cause.lost(LossKind::kOther, 1, kStart + 1s));
  EXPECT_FALSE(cause.lost(LossKind::kSilent, 0, kStart + 2s));
  EXPECT_TRUE(cause.text().empty());
}

TEST(CommonCause, WhatWasLostLongBeforeIsForgotten) {
  CommonCause cause(3s);
  EXPECT_FALSE(cause.lost(LossKind::kOther, 1, kStart));
  EXPECT_TRUE(cause.lost(LossKind::kSilent, 0, kStart + 4s));
  EXPECT_NE(cause.text().find("the only slave"), std::string::npos) << cause.text();
}

TEST(CommonCause, SlavesThatLeaveInOrderSayNothing) {
  CommonCause cause(3s);
  EXPECT_FALSE(cause.lost(LossKind::kOther, 1, kStart));
  EXPECT_FALSE(cause.lost(LossKind::kOther, 0, kStart));
  EXPECT_TRUE(cause.text().empty());
}

}  // namespace
}  // namespace tessera::master
