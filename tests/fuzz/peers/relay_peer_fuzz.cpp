// SPDX-License-Identifier: Apache-2.0
// Whatever a stranger says to a slave that feeds others, and to one that it feeds: an honest slave
// is fed by the first, and the second gets its scene from an honest feeder.
#include <gtest/gtest.h>

#include <cstdlib>

#include "tests/fuzz/peers/stranger.h"
#include "tests/unit/slave/relay_slave.h"

namespace {

using namespace tessera;
using slave::RelaySlave;

constexpr SceneVersion kVersion = 3;

const slave::Bytes& block() {
  static const slave::Bytes bytes = [] {
    const SceneBlock& spoken = test::spoken_blocks()[test::spoken_blocks().size() - 4];
    return slave::Bytes(spoken.bytes->begin(), spoken.bytes->end());  // of two chunks
  }();
  return bytes;
}

class World {
 public:
  World() {
    victim_.announce(kVersion, block());
    stranger_.listen();
    stranger_.heard.token = RelaySlave::kToken;
  }

  void step(test::FuzzInput& input) {
    stranger_.step(input, victim_.node(), [&](std::uint8_t kind) {
      if (kind == 0) return victim_.give(kVersion, block(), input.below(2));
      if (kind == 1) {
        auto word = RelaySlave::word(kVersion, stranger_node_);
        return victim_.child().follow(word, needs());
      }
      if (victim_.child().is_following(kVersion))
        victim_.child().want({kVersion, 0, std::vector<bool>(2, true)});
    });
  }

  void end() {
    stranger_.leave();
    test::run_for(queue_, std::chrono::seconds(20));  // until the victim has heard of it
    victim_.failures.clear();
    // What the stranger's chunks have not completed comes from an honest slave.
    RelaySlave upper(queue_, network_, "upper"), lower(queue_, network_, "lower");
    for (RelaySlave* slave : {&upper, &lower}) slave->announce(kVersion, block());
    for (const std::uint32_t chunk : {0u, 1u}) upper.give(kVersion, block(), chunk);
    if (!victim_.complete_at) victim_.follow(kVersion, upper);
    lower.follow(kVersion, victim_);
    const auto is_done = [&] { return lower.complete_at && victim_.complete_at; };
    if (!test::run_until(queue_, 60, is_done)) std::abort();
    if (!victim_.failures.empty() || !lower.failures.empty()) std::abort();
  }

 private:
  // As the slave itself says them; where nothing is lacking, it asks once more.
  static std::vector<wire::SceneChunkNeed> needs() {
    return {{kVersion, 0, std::vector<bool>(2, true)}};
  }

  sim::EventQueue queue_{1};
  sim::Network network_{queue_, 1};
  RelaySlave victim_{queue_, network_, "victim"};
  const int stranger_node_ = network_.add_node({});
  test::Stranger stranger_{queue_, network_, stranger_node_};
};

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  test::silence_log();
  testing::GTEST_FLAG(throw_on_failure) = true;  // of what RelaySlave expects of its receiver
  test::FuzzInput input(data, size);
  World world;
  for (int i = 0; i < test::Stranger::kStepsMax && !input.is_at_end(); ++i) world.step(input);
  world.end();
  return 0;
}
