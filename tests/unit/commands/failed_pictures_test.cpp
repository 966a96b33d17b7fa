// SPDX-License-Identifier: Apache-2.0
#include "master/commands/failed_pictures.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <string>

namespace tessera::master {
namespace {

TEST(FailedPictures, OnlyWhatMayHelpIsTriedAgain) {
  FailedPictures failed;
  failed.add(3, Status::unavailable("peer gone"), {});
  failed.add(4, Status::resource_exhausted("three slaves ended"), {});
  EXPECT_TRUE(FailedPictures::is_worth_a_try(failed.pictures().at(3)));
  EXPECT_FALSE(FailedPictures::is_worth_a_try(failed.pictures().at(4)));
  failed.add(3, Status::resource_exhausted("of a later pass"), {});
  EXPECT_EQ(failed.pictures().at(3).why.message(), "peer gone");
}

TEST(FailedPictures, NeighboursWithOneReasonShareALine) {
  FailedPictures failed;
  for (const long number : {2, 3, 4, 7}) failed.add(number, Status::unavailable("a"), {});
  EXPECT_EQ(failed.text(9), "4 of 9 frames failed\n  frames 2 to 4: a\n  frame 7: a");
  failed.mended(7);
  EXPECT_EQ(failed.text(9), "3 of 9 frames failed; frames 2 to 4: a");
  failed.mended(3);
  failed.mended(4);
  EXPECT_EQ(failed.text(1), "1 of 1 frame failed; frame 2: a");
}

TEST(FailedPictures, AThousandReasonsAreNotAThousandLines) {
  FailedPictures failed;
  for (long number = 0; number < 1000; ++number)
    failed.add(number, Status::unavailable(std::to_string(number)), {});
  const std::string text = failed.text(1000);
  EXPECT_EQ(std::count(text.begin(), text.end(), '\n'), 101);
  EXPECT_NE(text.find("900 more"), std::string::npos);
}

}  // namespace
}  // namespace tessera::master
