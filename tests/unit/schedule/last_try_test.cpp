// SPDX-License-Identifier: Apache-2.0
// Who gets a tile that as many slaves but one have ended with as it may end, and who counts.
#include "tests/unit/schedule/bad_slaves.h"

namespace tessera::master {
namespace {

using LastTry = BadSlaves;

// Two slaves have ended with the tile. A third that nobody knows would be the last that may.
TEST_F(LastTry, TheLastTryOfATileWaitsForASlaveThatHasBroughtTiles) {
  const SessionId good = join("good", 1);
  submit(0, 1);
  answer(good);
  submit(1, 2);
  lose(good, SlaveEnd::kLeft);
  for (std::uint64_t bad = 2; bad <= 3; ++bad) {
    const SessionId session = join("bad" + std::to_string(bad), bad);
    ASSERT_TRUE(holds(session, 0));
    lose(session);
  }
  const SessionId newcomer = join("new", 4);
  EXPECT_FALSE(holds(newcomer, 0));
  const SessionId other = join("other", 5);
  EXPECT_FALSE(holds(other, 0) || holds(other, 1)) << "the other tile was lost with them, too";
  submit(2, 2);
  tick(10ms);
  ASSERT_TRUE(holds(newcomer, 0) || holds(newcomer, 1)) << "of the next frame";
  answer(newcomer);
  EXPECT_TRUE(holds(newcomer, 0));
  EXPECT_TRUE(failed_.empty());
}

TEST_F(LastTry, TheLastTryOfATileGoesToAnybodyWhenNoProvenSlaveComes) {
  for (std::uint64_t bad = 1; bad <= 2; ++bad) {
    const SessionId session = join("bad" + std::to_string(bad), bad);
    if (bad == 1) submit(0, 1);
    lose(session);
  }
  const SessionId newcomer = join("new", 3);
  tick(DepartedSlaves::kReturn - 1ms);
  EXPECT_FALSE(holds(newcomer, 0));
  tick(1ms);
  EXPECT_TRUE(holds(newcomer, 0));
  answer(newcomer);
  EXPECT_EQ(complete_, 1);
}

// Slaves that end with anything are held against no tile: a good one that is killed beside them is
// one death, and not the third.
TEST_F(LastTry, ASlaveThatEndsWithOtherTilesTooIsNoWitnessAgainstOne) {
  const SessionId good = join("good", 1), victim = join("victim", 2);
  submit(0, 2);
  while (answer(good) || answer(victim)) {
  }
  lose(good, SlaveEnd::kLeft);
  lose(victim, SlaveEnd::kLeft);
  submit(1, 1);
  std::uint64_t life = 10;
  for (const char* name : {"a", "b"}) {
    SessionId bad = join(name, ++life);
    ASSERT_TRUE(holds(bad, 0)) << name;
    lose(bad);
  }
  submit(2, 40);
  for (const char* name : {"a", "b"}) {
    SessionId bad = join(name, ++life);
    ASSERT_FALSE(out_[bad].empty()) << name << " has another frame's tile";
    lose(bad);
  }
  const SessionId again = join("victim", 3);
  while (!out_[again].empty() && out_[again].front().frame != 1) answer(again);
  ASSERT_FALSE(out_[again].empty());
  lose(again);
  const SessionId saviour = join("saviour", 4);
  answer(saviour);
  tick(DepartedSlaves::kReturn);
  EXPECT_TRUE(failed_.empty()) << failed_[0];
  for (int step = 0; step < 2000 && complete_ < 3; ++step) {
    tick(10ms);
    answer(saviour);
  }
  EXPECT_EQ(complete_, 3);
}

TEST_F(LastTry, AProcessThatComesBackIsAsProvenAsItWas) {
  const SessionId good = join("good", 1);
  submit(0, 3);
  answer(good);
  submit(1, 1);
  lose(good);
  for (std::uint64_t bad = 2; bad <= 3; ++bad) lose(join("bad" + std::to_string(bad), bad));
  const SessionId again = join("good", 1);
  for (int step = 0; step < 100 && complete_ < 2; ++step) {
    answer(again);
    tick(10ms);
  }
  EXPECT_EQ(complete_, 2) << "it is the only one, and has brought a tile";
}

}  // namespace
}  // namespace tessera::master
