// SPDX-License-Identifier: Apache-2.0
// The page of metrics: its format to the letter, cumulative buckets, and sums that lose nothing.
#include "common/metrics/exposition.h"

#include <gtest/gtest.h>

#include <cmath>
#include <thread>
#include <vector>

namespace tessera::metrics {
namespace {

TEST(Exposition, WritesFamiliesAsTheFormatSays) {
  Exposition page;
  page.family("a_total", Kind::kCounter, "Counts\\ things,\nand more.")
      .sample({{"kind", "x"}, {"name", "quote\" back\\slash\nline"}}, std::uint64_t{3})
      .sample({{"kind", "y"}}, 0.25);
  page.gauge("b_seconds", "Now.", 1e-9);
  EXPECT_EQ(page.text(),
            "# HELP a_total Counts\\\\ things,\\nand more.\n"
            "# TYPE a_total counter\n"
            "a_total{kind=\"x\",name=\"quote\\\" back\\\\slash\\nline\"} 3\n"
            "a_total{kind=\"y\"} 0.25\n"
            "# HELP b_seconds Now.\n"
            "# TYPE b_seconds gauge\n"
            "b_seconds 1e-09\n");
}

TEST(Exposition, KeepsWholeNumbersExactAndNamesTheInfinite) {
  Exposition page;
  page.counter("big_total", "Big.", ~std::uint64_t{0});
  page.family("odd", Kind::kGauge, "Odd.").sample(NAN).sample(INFINITY).sample(-INFINITY);
  EXPECT_NE(page.text().find("big_total 18446744073709551615\n"), std::string::npos);
  EXPECT_NE(page.text().find("odd NaN\nodd +Inf\nodd -Inf\n"), std::string::npos);
}

TEST(Histogram, BucketsAreCumulativeAndBoundsBelongBelow) {
  static constexpr std::array<double, 2> kBounds{0.1, 1};
  Histogram histogram(kBounds);
  for (const double value : {0.1, 0.05, 0.2, 1.0, 7.0, double{NAN}}) histogram.observe(value);
  Exposition page;
  page.family("h_seconds", Kind::kHistogram, "H.").histogram(histogram);
  EXPECT_NE(page.text().find("h_seconds_bucket{le=\"0.1\"} 2\n"
                             "h_seconds_bucket{le=\"1\"} 4\n"
                             "h_seconds_bucket{le=\"+Inf\"} 5\n"
                             "h_seconds_sum 8.35\n"
                             "h_seconds_count 5\n"),
            std::string::npos)
      << page.text();
}

TEST(Cells, LoseNothingBetweenThreads) {
  Counter counter;
  Sum sum;
  Histogram histogram(kSecondsBounds);
  std::vector<std::thread> threads;
  for (int i = 0; i < 4; ++i) {
    threads.emplace_back([&] {
      for (int n = 0; n < 10'000; ++n) {
        counter.add();
        sum.add(0.5);
        histogram.observe(0.5);
      }
    });
  }
  for (std::thread& thread : threads) thread.join();
  EXPECT_EQ(counter.value(), 40'000u);
  EXPECT_EQ(sum.value(), 20'000.0);
  EXPECT_EQ(histogram.sum(), 20'000.0);
}

TEST(Cells, ASumNeverFalls) {
  Sum sum;
  sum.add(2);
  sum.add(-1);
  sum.add(NAN);
  EXPECT_EQ(sum.value(), 2.0);
}

TEST(ExpositionDeathTest, RefusesNamesThatNoScrapeWouldTake) {
  Exposition page;
  EXPECT_DEATH(page.gauge("9lives", "", 1), "is_name");
  EXPECT_DEATH(page.gauge("ends_total", "", 1), "_total");
  page.gauge("twice", "", 1);
  EXPECT_DEATH(page.gauge("twice", "", 1), "names_");
}

TEST(Exposition, TellsOfItsProcess) {
  Exposition page;
  add_process(page);
  for (const char* name :
       {"process_cpu_seconds_total", "process_resident_memory_bytes", "process_open_fds"}) {
    EXPECT_NE(page.text().find(std::string("\n") + name + " "), std::string::npos) << name;
  }
}

}  // namespace
}  // namespace tessera::metrics
