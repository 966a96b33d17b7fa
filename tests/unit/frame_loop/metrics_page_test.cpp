// SPDX-License-Identifier: Apache-2.0
// The master's page of metrics: every slave once in every family of slaves, sums that fit, names
// that a scraper takes.
#include "master/frame_loop/metrics_page.h"

#include <gtest/gtest.h>

#include <map>
#include <set>
#include <sstream>

namespace tessera::master {
namespace {

std::map<std::string, double> samples_of(const std::string& page) {
  std::map<std::string, double> samples;
  std::istringstream lines(page);
  for (std::string line; std::getline(lines, line);) {
    if (line.starts_with('#')) continue;
    const auto space = line.rfind(' ');
    EXPECT_TRUE(samples.emplace(line.substr(0, space), std::stod(line.substr(space + 1))).second)
        << "twice: " << line;
  }
  return samples;
}

ClusterStatus two_slaves() {
  ClusterStatus status;
  for (const char* name : {"a", "b \"the second\""}) {
    SlaveStatus slave;
    slave.name = name;
    slave.threads = 4;
    slave.rtt_seconds = 0.01;
    slave.tiles = {10, 6, 1, 1, 2};
    slave.tiles_in_flight = 2;
    status.slaves.push_back(slave);
  }
  status.tiles = {25, 15, 3, 3, 4};
  status.frames_done = 3;
  status.frames_cancelled = 1;
  return status;
}

TEST(MetricsPage, HoldsEverySlaveInEveryFamilyOfSlaves) {
  const auto samples = samples_of(metrics_page(two_slaves()));
  std::map<std::string, int> count;
  for (const auto& [name, value] : samples) {
    if (name.find("{slave=") != std::string::npos) ++count[name.substr(0, name.find('{'))];
  }
  EXPECT_GE(count.size(), 15u);
  for (const auto& [name, times] : count) EXPECT_EQ(times, 2) << name;
  EXPECT_EQ(samples.at("tessera_slave_rtt_seconds{slave=\"b \\\"the second\\\"\"}"), 0.01);
}

TEST(MetricsPage, TellsWhereEveryLeaseWent) {
  const auto samples = samples_of(metrics_page(two_slaves()));
  EXPECT_EQ(
      samples.at("tessera_tiles_issued_total"),
      samples.at("tessera_tiles_accepted_total") + samples.at("tessera_tiles_rejected_total") +
          samples.at("tessera_tiles_abandoned_total") + samples.at("tessera_tiles_in_flight"));
  EXPECT_EQ(samples.at("tessera_frames_total{outcome=\"done\"}"), 3);
  EXPECT_EQ(samples.at("tessera_frames_total{outcome=\"cancelled\"}"), 1);
}

TEST(MetricsPage, StaysSmallWithoutSlaves) {
  EXPECT_LT(metrics_page(ClusterStatus()).size(), 16'000u);
  EXPECT_EQ(samples_of(metrics_page(ClusterStatus())).count("tessera_slaves"), 1u);
}

}  // namespace
}  // namespace tessera::master
