// SPDX-License-Identifier: Apache-2.0
#include "master/session/outcome_queue.h"

#include <gtest/gtest.h>

#include <atomic>
#include <thread>

#include "tests/support/asleep.h"

namespace tessera::master {
namespace {

using namespace std::chrono_literals;

FrameResult finished(FrameId frame) {
  FrameResult result;
  result.frame = frame;
  return result;
}

TEST(OutcomeQueue, ThirdFrameWaitsUntilOneOfTwoIsFinished) {
  OutcomeQueue queue(2);
  EXPECT_EQ(*queue.begin_frame(), 0u);
  EXPECT_EQ(*queue.begin_frame(), 1u);
  std::atomic<bool> has_third{false};
  test::WatchedThread third([&] {
    EXPECT_EQ(*queue.begin_frame(), 2u);
    has_third = true;
  });
  third.wait_until_asleep();
  EXPECT_FALSE(has_third);
  queue.push(finished(0));
  third.join();
  EXPECT_TRUE(has_third);
  EXPECT_EQ(queue.pop(0ms)->frame, 0u);
}

TEST(OutcomeQueue, FinishedFramesThatNobodyTakesStopSubmission) {
  OutcomeQueue queue(1);
  for (FrameId frame = 0; frame < OutcomeQueue::kUndeliveredMax; ++frame) {
    ASSERT_EQ(*queue.begin_frame(), frame);
    queue.push(finished(frame));
  }
  test::WatchedThread blocked(
      [&] { EXPECT_EQ(queue.begin_frame().status().code(), StatusCode::kClosed); });
  blocked.wait_until_asleep();
  queue.end(Status::closed("done"));
  blocked.join();
  EXPECT_TRUE(queue.pop(0ms).is_ok());  // what was finished still comes out
  EXPECT_TRUE(queue.pop(0ms).is_ok());
  EXPECT_EQ(queue.pop(0ms).status().code(), StatusCode::kClosed);
}

TEST(OutcomeQueue, PopTellsThatTimePassed) {
  OutcomeQueue queue(1);
  EXPECT_EQ(queue.pop(10ms).status().code(), StatusCode::kDeadlineExceeded);
}

}  // namespace
}  // namespace tessera::master
