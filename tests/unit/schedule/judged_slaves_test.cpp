// SPDX-License-Identifier: Apache-2.0
// What is held against a slave is held against it in whichever session it has, or has had; and
// audits of tiles that end slaves come to an end.
#include "tests/unit/schedule/bad_slaves.h"

#include <string>
#include <utility>
#include <vector>

namespace tessera::master {
namespace {

using Names = std::vector<std::string>;

class JudgedSlaves : public BadSlaves {};

TEST_F(JudgedSlaves, FaultyPixelsOfASlaveThatIsGoneAreToldOf) {
  for (const bool is_third_there : {false, true}) {
    suspects_.clear();
    const FrameId frame = is_third_there ? 1 : 0;
    const SessionId bad = join("bad", 1), good = join("good", 2);
    if (is_third_there) join("third", 3);
    submit(frame, 1);
    const SessionId first = holds(bad, 0) ? bad : good;
    const std::string name = first == bad ? "bad" : "good";
    ASSERT_TRUE(answer(first, true));
    lose(first, SlaveEnd::kLeft);
    for (auto& [session, leases] : out_) answer(session);
    EXPECT_EQ(complete_, static_cast<int>(frame) + 1);
    EXPECT_EQ(suspects_, Names{name});
    for (SessionId session = 1; session <= last_session_; ++session) lose(session);
  }
}

TEST_F(JudgedSlaves, ASlaveThatComesBackIsNotTheOtherOneThatRendersWhatWasRefusedOfIt) {
  SessionId bad = join("bad", 1);
  submit(0, 1);
  const SessionId good = join("good", 2);
  ASSERT_TRUE(answer(bad, true)) << "refused, since another slave is here";
  ASSERT_TRUE(holds(good, 0));
  lose(bad, SlaveEnd::kLeft);
  bad = join("bad", 3);
  const SessionId other = join("other", 4);
  lose(good, SlaveEnd::kLeft);
  EXPECT_FALSE(holds(bad, 0)) << "it has rendered the tile, in another session";
  ASSERT_TRUE(answer(other));
  EXPECT_EQ(complete_, 1);
  EXPECT_EQ(suspects_, Names{"bad"});
}

TEST_F(JudgedSlaves, ASlaveAloneThatComesBackDoesNotAcquitItselfNorAccuse) {
  SessionId bad = join("bad", 1);
  submit(0, 1);
  const SessionId good = join("good", 2);
  ASSERT_TRUE(answer(bad, true));
  lose(good, SlaveEnd::kLeft);
  ASSERT_TRUE(holds(bad, 0)) << "nobody else is there";
  lose(bad, SlaveEnd::kLeft);
  bad = join("bad", 3);
  ASSERT_TRUE(holds(bad, 0));
  join("late", 4);
  ASSERT_TRUE(answer(bad, true));
  EXPECT_EQ(complete_, 0) << "twice the same slave's is not every slave's";
  tick(10ms);
  ASSERT_TRUE(answer(last_session_));
  EXPECT_EQ(complete_, 1);
  EXPECT_EQ(suspects_, Names{"bad"});
}

TEST_F(JudgedSlaves, WhatWasRefusedOfASlaveWhoseRivalCannotHoldTheSceneComesBackToIt) {
  const SessionId bad = join("bad", 1);
  submit(0, 1);
  const SessionId good = join("good", 2);
  ASSERT_TRUE(answer(bad, true));
  ASSERT_TRUE(holds(good, 0));
  perform(scheduler_.tile_returned(good, 0, 0, out_[good].front().tile.attempt, now_));
  out_[good].clear();
  EXPECT_FALSE(holds(bad, 0));
  perform(scheduler_.scene_failed(good, 1, "a mesh cannot be built", now_));
  ASSERT_TRUE(answer(bad, true));
  EXPECT_EQ(complete_, 1);
}

TEST_F(JudgedSlaves, OneThatGivesItsTilesBackOrLeavesWithThemFailsNoFrameOfAnother) {
  SessionId bad = join("bad", 1);
  const SessionId good = join("good", 2);
  submit(0, 400);  // so that the good one has its hands full
  for (std::uint64_t life = 3; life < 400; ++life) {
    if (life < 200) {
      for (const Action& lease : std::exchange(out_[bad], {}))
        perform(scheduler_.tile_returned(bad, 0, lease.tile.tile, lease.tile.attempt, now_));
    }
    lose(bad, SlaveEnd::kLeft);
    bad = join("bad", life);
    tick(1ms);
  }
  EXPECT_TRUE(failed_.empty()) << failed_[0];
  while (answer(good)) tick(10ms);
  EXPECT_EQ(complete_, 1);
}

TEST_F(JudgedSlaves, ATileThatEverybodyGivesBackFailsItsFrame) {
  std::vector<SessionId> slaves{join("a", 1), join("b", 2)};
  submit(0, 1);
  for (int turn = 0; turn < 400 && failed_.empty(); ++turn) {
    for (const SessionId slave : slaves) {
      for (const Action& lease : std::exchange(out_[slave], {}))
        perform(scheduler_.tile_returned(slave, 0, lease.tile.tile, lease.tile.attempt, now_));
    }
    tick(1s);
  }
  ASSERT_EQ(failed_.size(), 1u);
  EXPECT_NE(failed_[0].find("came back unrendered"), std::string::npos) << failed_[0];
}

// Every tile is rendered by two slaves.
class JudgedVotes : public BadSlaves {
 protected:
  JudgedVotes() : BadSlaves({1.0}) {}
  // The one of the slaves that holds tile 0.
  SessionId holder() {
    for (auto& [session, leases] : out_) {
      if (!leases.empty()) return session;
    }
    return 0;
  }
};

TEST_F(JudgedVotes, ASlaveThatComesBackDoesNotConfirmItself) {
  SessionId liar = join("liar", 1);
  const SessionId honest = join("honest", 2);
  submit(0, 1);
  while (const SessionId one = holder()) {
    if (one != liar) break;
    ASSERT_TRUE(answer(liar, false, 66));
    lose(liar, SlaveEnd::kLeft);
    liar = join("a new name", 1, 1, "liar");
    lose(liar);
    liar = join("liar", 3);
  }
  ASSERT_FALSE(holds(liar, 0));
  const SessionId third = join("third", 4);
  for (const SessionId one : {honest, third}) answer(one, false, 77);
  tick(10ms);
  for (const SessionId one : {honest, third}) answer(one, false, 77);
  EXPECT_EQ(complete_, 1);
  EXPECT_EQ(expelled_, Names{"liar"});
}

TEST_F(JudgedVotes, ALiarThatIsGoneWhenItIsOutvotedIsNamed) {
  const SessionId liar = join("liar", 1, 1, "certificate of a liar");
  join("honest", 2);
  join("third", 3);
  submit(0, 1);
  ASSERT_TRUE(answer(liar, false, 66));
  lose(liar);
  for (int round = 0; round < 4; ++round) {
    for (SessionId session = liar + 1; session <= last_session_; ++session)
      answer(session, false, 77);
    tick(10ms);
  }
  join("fourth", 4);
  tick(10ms);
  answer(last_session_, false, 77);
  EXPECT_EQ(complete_, 1) << failed_.size();
  EXPECT_EQ(expelled_, Names{"certificate of a liar"});
}

TEST_F(JudgedVotes, FaultyPixelsAreRefusedBeforeTheyAreComparedWithAnyOthers) {
  const SessionId bad = join("bad", 1), good = join("good", 2);
  submit(0, 1);
  ASSERT_TRUE(holds(bad, 0));
  ASSERT_TRUE(answer(bad, true, 66));
  for (int round = 0; round < 3; ++round) {
    answer(good, false, 77);
    tick(10ms);
  }
  EXPECT_EQ(complete_, 1) << "nobody is left to compare it";
  EXPECT_TRUE(failed_.empty()) << failed_[0];
  EXPECT_EQ(suspects_, Names{"bad"});
}

// A tile ends whoever is given it for comparison.
TEST_F(JudgedVotes, AuditsDoNotWaitForSlavesThatWereLostWithTheTile) {
  const SessionId first = join("first", 1);
  SessionId second = join("second", 2);
  const SessionId third = join("third", 3);
  submit(0, 1);
  ASSERT_TRUE(answer(first, false, 77));
  ASSERT_TRUE(holds(second, 0));
  lose(second);
  second = join("second", 22);
  EXPECT_FALSE(holds(second, 0));
  ASSERT_TRUE(holds(third, 0)) << "it was not lost with it";
  EXPECT_EQ(complete_, 0);
  lose(third);
  EXPECT_EQ(complete_, 1) << "who is left has rendered the tile or was lost with it";
  EXPECT_TRUE(failed_.empty()) << failed_[0];
  EXPECT_FALSE(holds(second, 0));
}

TEST_F(JudgedVotes, ATileThatOnlyWaitsForComparisonIsTakenAsItIsWhenItEndsThoseThatCompareIt) {
  std::vector<SessionId> slaves;
  for (const char* name : {"a", "b", "c", "d", "e"})
    slaves.push_back(join(name, slaves.size() + 1));
  submit(0, 20);  // so that all are trusted
  for (int step = 0; step < 100 && complete_ == 0; ++step) {
    for (const SessionId slave : slaves) answer(slave, false, 77);
    tick(10ms);
  }
  ASSERT_EQ(complete_, 1);
  submit(1, 1);
  const SessionId first = holder();
  ASSERT_TRUE(answer(first, false, 77));
  std::size_t lost = 0;
  for (int step = 0; step < 100; ++step) {
    tick(10ms);
    const SessionId next = holder();
    if (next == 0) continue;
    ASSERT_NE(next, first);
    lose(next);
    ++lost;
  }
  EXPECT_EQ(lost, 3u);
  EXPECT_EQ(complete_, 1) << "one of those slaves may only have lost its link";
  tick(DepartedSlaves::kReturn);
  EXPECT_EQ(complete_, 2);
  EXPECT_TRUE(failed_.empty()) << failed_[0];
}

// Three slaves end with the comparison of a tile, one of which ends with anything. Who answered the
// tile is no proven slave that the last try could wait for.
TEST_F(JudgedVotes, ATileIsTakenAsItIsWhenNobodyMayHaveItsLastTry) {
  const SessionId good = join("good", 1);
  SessionId bad = join("a", 2);
  submit(0, 1);
  ASSERT_TRUE(holds(bad, 0));
  answer(good, false, 77);
  const SessionId other = join("b", 3);
  lose(bad);
  ASSERT_TRUE(holds(other, 0));
  bad = join("a", 4);
  const SessionId victim = join("c", 5);
  lose(other);
  submit(1, 1);
  ASSERT_TRUE(holds(bad, 0)) << "of the next frame";
  lose(bad);
  answer(good, false, 77);
  tick(10ms);
  ASSERT_TRUE(holds(victim, 0)) << "of the next frame";
  answer(victim, false, 77);
  ASSERT_EQ(out_[victim].size(), 1u) << "of the first frame, since it has brought a tile";
  join("new", 6);
  lose(victim);
  EXPECT_EQ(complete_, 0);
  tick(DepartedSlaves::kReturn);
  tick(10ms);
  EXPECT_EQ(complete_, 2);
  EXPECT_TRUE(failed_.empty()) << failed_[0];
}

TEST_F(JudgedVotes, NobodyIsWaitedForWhenWhoAnsweredIsTheOnlyOneThatCameBack) {
  const SessionId slave = join("slave", 1), other = join("other", 2);
  submit(0, 1);
  ASSERT_TRUE(holds(slave, 0) && holds(other, 0));
  answer(slave, false, 77);
  lose(slave);
  lose(other, SlaveEnd::kLeft);
  EXPECT_EQ(complete_, 0);
  const SessionId again = join("slave", 1);
  EXPECT_FALSE(holds(again, 0));
  EXPECT_EQ(complete_, 1);
}

TEST_F(JudgedVotes, ASlaveThatIsOutvotedIsGivenNothingBeforeItIsExpelled) {
  const SessionId liar = join("liar", 1), one = join("one", 2), two = join("two", 3);
  submit(0, 1);
  submit(1, 1);
  submit(2, 12);
  ASSERT_TRUE(answer(liar, false, 66));
  ASSERT_TRUE(answer(one, false, 77));
  tick(10ms);
  while (expelled_.empty()) {
    const std::size_t held = out_[liar].size();
    ASSERT_TRUE(answer(two, false, 77));
    if (!expelled_.empty()) {
      EXPECT_LE(out_[liar].size(), held) << "others may have the next frame";
    }
  }
  EXPECT_EQ(complete_, 1);
}

}  // namespace
}  // namespace tessera::master
