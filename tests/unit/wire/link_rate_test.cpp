// SPDX-License-Identifier: Apache-2.0
// The rate of a link from its counters, on links that are simulated in whole microseconds.
#include "common/wire/link_rate.h"

#include <gtest/gtest.h>

namespace tessera::wire {
namespace {

using std::chrono::microseconds;

// A link that carries `bytes_per_second` and whose counters are observed every `step`.
struct Link {
  LinkRate rate;
  net::LinkCounters counters;

  Link() { counters.rtt_min = counters.rtt = microseconds(200); }

  void run(double bytes_per_second, microseconds step, int steps, bool is_queueing) {
    for (int i = 0; i < steps; ++i) {
      counters.bytes_moved +=
          static_cast<std::uint64_t>(bytes_per_second * 1e-6 * static_cast<double>(step.count()));
      counters.busy += step;
      counters.on_the_way_bytes = is_queueing ? 20'000 : 0;
      counters.rtt = is_queueing ? microseconds(20'000) : microseconds(250);
      rate.observe(counters);
    }
  }
};

TEST(LinkRate, AQueueShowsTheRate) {
  Link link;
  link.rate.observe(link.counters);
  link.run(1e6, microseconds(5000), 100, true);
  ASSERT_TRUE(link.rate.bytes_per_second().has_value());
  EXPECT_NEAR(*link.rate.bytes_per_second(), 1e6, 1e4);
}

TEST(LinkRate, WithoutAQueueNothingIsKnown) {
  Link link;
  link.run(1e6, microseconds(5000), 1000, false);
  EXPECT_FALSE(link.rate.bytes_per_second().has_value());
}

TEST(LinkRate, BytesThatWaitInUsAreAQueueAsWell) {
  Link link;
  link.counters.queue_bytes = 1;
  link.run(3e6, microseconds(5000), 100, false);
  EXPECT_NEAR(link.rate.bytes_per_second().value_or(0), 3e6, 1e4);
}

TEST(LinkRate, APutOffAcknowledgementIsNoQueue) {
  Link link;
  for (int i = 0; i < 100; ++i) {
    link.counters.bytes_moved += 12'000;
    link.counters.busy += microseconds(40'000);
    link.counters.rtt = microseconds(40'000);
    link.counters.on_the_way_bytes = 1460;  // the last segment
    link.rate.observe(link.counters);
  }
  EXPECT_FALSE(link.rate.bytes_per_second().has_value());
}

// A scene's version fits into the buffers of a link, which is looked at with the next one.
TEST(LinkRate, WhatWaitedAndHasGoneShowsTheRate) {
  const auto rate_of = [](double bytes_per_second, std::uint64_t waiting) {
    Link link;
    for (int version = 0; version < 10; ++version) {
      link.counters.queue_bytes = waiting;
      link.rate.observe(link.counters);
      link.counters.queue_bytes = 0;
      link.run(bytes_per_second, microseconds(static_cast<int>(8e11 / bytes_per_second)), 1, false);
    }
    return link.rate.bytes_per_second();
  };
  EXPECT_NEAR(rate_of(2.5e6, 700'000).value_or(0), 2.5e6, 4e5);
  EXPECT_NEAR(rate_of(0.5e6, 700'000).value_or(0), 0.5e6, 2e4);
  EXPECT_FALSE(rate_of(100e6, 700'000).has_value())
      << "a put-off acknowledgement would take longer";
  EXPECT_FALSE(rate_of(2.5e6, 0).has_value()) << "it may have come bit by bit";
}

TEST(LinkRate, IdleTimeDoesNotCount) {
  Link link;
  link.counters.queue_bytes = 1;
  for (int i = 0; i < 50; ++i) {
    link.run(2e6, microseconds(5000), 1, true);
    link.rate.observe(link.counters);  // a second later, perhaps; `busy` stood still
  }
  EXPECT_NEAR(link.rate.bytes_per_second().value_or(0), 2e6, 2e4);
}

TEST(LinkRate, FollowsALinkThatSlowsDown) {
  Link link;
  link.run(8e6, microseconds(5000), 400, true);
  link.run(1e6, microseconds(5000), 800, true);
  EXPECT_NEAR(link.rate.bytes_per_second().value_or(0), 1e6, 3e5);
}

TEST(LinkRate, AQueueThatVanishedDoesNotMakeItForget) {
  Link link;
  link.run(1e6, microseconds(5000), 400, true);
  link.run(5e5, microseconds(5000), 4000, false);  // coded: half the bytes, no queue
  EXPECT_NEAR(link.rate.bytes_per_second().value_or(0), 1e6, 1e4);
}

TEST(LinkRate, ALinkThatProvesFasterWithoutAQueueIsForgotten) {
  Link link;
  link.run(1e6, microseconds(5000), 400, true);
  link.run(3e6, microseconds(5000), 10, false);
  EXPECT_FALSE(link.rate.bytes_per_second().has_value());
}

}  // namespace
}  // namespace tessera::wire
