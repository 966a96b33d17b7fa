// SPDX-License-Identifier: Apache-2.0
#include "master/cluster/issue_rule.h"

#include <gtest/gtest.h>

namespace tessera::master {
namespace {

using namespace std::chrono_literals;

net::PeerIdentity slave(std::string name) {
  net::PeerIdentity peer;
  peer.is_authenticated = true;
  peer.role = "slave";
  peer.name = std::move(name);
  peer.life = {0, 3000};
  return peer;
}

TEST(IssueRule, ASlaveGetsACertificateInTheLastThirdOfItsOld) {
  IssueRule rule;
  EXPECT_NE(rule.refusal_of(slave("a"), 1999, {}), "");
  EXPECT_EQ(rule.refusal_of(slave("a"), 2000, {}), "");
}

TEST(IssueRule, AnApplicationGetsOneLikeASlave) {
  IssueRule rule;
  net::PeerIdentity app = slave("a");
  app.role = "app";
  EXPECT_NE(rule.refusal_of(app, 1999, {}), "");
  EXPECT_EQ(rule.refusal_of(app, 2000, {}), "");
  EXPECT_NE(rule.refusal_of(app, 2001, {}), "") << "once an hour";
}

TEST(IssueRule, ACertificateThatHasEndedGetsNoOther) {
  IssueRule rule;
  EXPECT_NE(rule.refusal_of(slave("a"), 3000, {}), "");
  EXPECT_EQ(rule.refusal_of(slave("a"), 2999, {}), "");
}

TEST(IssueRule, OneNameGetsOneAnHour) {
  IssueRule rule;
  TimePoint now{};
  EXPECT_EQ(rule.refusal_of(slave("a"), 2500, now), "");
  EXPECT_NE(rule.refusal_of(slave("a"), 2500, now + 59min), "");
  EXPECT_EQ(rule.refusal_of(slave("b"), 2500, now + 59min), "") << "others are not held up";
  EXPECT_EQ(rule.refusal_of(slave("a"), 2500, now + 60min), "");
}

TEST(IssueRule, NobodyElseGetsAny) {
  IssueRule rule;
  EXPECT_NE(rule.refusal_of({}, 2500, {}), "") << "without keys";
  for (const char* role : {"master", ""}) {
    net::PeerIdentity peer = slave("a");
    peer.role = role;
    EXPECT_NE(rule.refusal_of(peer, 2500, {}), "") << role;
  }
}

TEST(IssueRule, WhatIsRememberedIsBounded) {
  IssueRule rule;
  for (std::size_t i = 0; i < IssueRule::kNamesMax; ++i)
    EXPECT_EQ(rule.refusal_of(slave(std::to_string(i)), 2500, {}), "");
  EXPECT_NE(rule.refusal_of(slave("one more"), 2500, {}), "");
  EXPECT_EQ(rule.refusal_of(slave("one more"), 2500, TimePoint{} + 1h), "");
}

}  // namespace
}  // namespace tessera::master
