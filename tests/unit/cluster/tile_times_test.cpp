// SPDX-License-Identifier: Apache-2.0
// Quantiles by nearest rank, and a window that forgets.
#include "master/cluster/tile_times.h"

#include <gtest/gtest.h>

namespace tessera::master {
namespace {

TEST(TileTimes, AQuantileIsOneOfTheValues) {
  EXPECT_EQ(quantile({}, 0.5), 0);
  EXPECT_EQ(quantile({7}, 0.95), 7);
  EXPECT_EQ(quantile({3, 1, 2}, 0.5), 2);
  EXPECT_EQ(quantile({4, 1, 3, 2}, 0.5), 2);
  std::vector<double> hundred;
  for (int i = 100; i > 0; --i) hundred.push_back(i);
  EXPECT_EQ(quantile(hundred, 0.95), 95);
  EXPECT_EQ(quantile(hundred, 1), 100);
}

TEST(TileTimes, OldTimesAreForgotten) {
  TileTimes times;
  times.add(1000);
  for (std::size_t i = 0; i < TileTimes::kTilesKept; ++i) times.add(1);
  EXPECT_EQ(times.seconds().size(), TileTimes::kTilesKept);
  EXPECT_EQ(quantile(times.seconds(), 1), 1);
}

}  // namespace
}  // namespace tessera::master
