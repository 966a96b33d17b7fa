// SPDX-License-Identifier: Apache-2.0
// An application's session in virtual time against a scripted master that goes and comes again.
#include "master/session/lasting_client.h"

#include <gtest/gtest.h>

#include <memory>
#include <string>
#include <vector>

#include "common/base/log.h"
#include "tests/sim/picture.h"
#include "tests/unit/slave/virtual_master.h"

namespace tessera::master {
namespace {

using namespace std::chrono_literals;

class LastingClientTest : public testing::Test {
 protected:
  static void SetUpTestSuite() { init_log(LogLevel::kOff, LogFormat::kText); }
  ~LastingClientTest() override {
    master_.network().on_process_ended(*process_, true);
    process_->end();
  }

  void start() {
    LastingClient::Callbacks callbacks;
    callbacks.on_welcome = [this] { said_.push_back("welcome"); };
    callbacks.on_frame = [this](const FrameResult& result) {
      said_.push_back((result.status.is_ok() ? "frame " : "no frame ") +
                      std::to_string(result.frame));
    };
    callbacks.on_away = [this](const Status&) { said_.push_back("away"); };
    callbacks.on_ended = [this](const Status& why) { said_.push_back("ended: " + why.message()); };
    client_ =
        std::make_unique<LastingClient>(*process_, AppIdentity{wire::Role::kApp, "anna", 42},
                                        master_.factory(*process_), std::move(callbacks), renewal_);
    process_->post([this] { client_->start(); });
  }

  // Answers the next Hello.
  void welcome() {
    const wire::Hello hello = master_.expect<wire::Hello>(&link_);
    EXPECT_EQ(hello.name, "anna");
    EXPECT_EQ(hello.instance, 42u) << "each link is that of the same process";
    master_.send(link_, wire::Welcome{1, 7, 7, 250, 59, issues_certificates_});
  }
  void commit(SceneVersion version) {
    client_->commit_scene(version,
                          sim::scene_of_tag(static_cast<int>(version), sim::SceneWeight::kLight));
  }
  void submit(FrameId frame, SceneVersion version) {
    client_->submit(frame, version, slave::MasterScript::small_frame());
  }
  void expect_scene(SceneVersion version) {
    EXPECT_EQ(master_.expect<wire::SceneAnnounce>().version, version);
  }
  void expect_submit(FrameId frame, SceneVersion version) {
    const auto submit = master_.expect<wire::FrameSubmit>();
    EXPECT_EQ(submit.frame, frame);
    EXPECT_EQ(submit.version, version);
  }
  void deliver(FrameId frame) {
    const std::vector<std::byte> bytes(64 * 40 * 12, std::byte{7});
    master_.send(link_, wire::FrameChunk{frame, 0, net::SharedBytes::of(bytes)});
    wire::FrameDone done;
    done.stats.frame = frame;
    done.stats.digest = sha256(bytes);
    done.stats.tile_edge_px = 16;
    master_.send(link_, std::move(done));
    master_.run_for(100ms);
  }
  // The master breaks the link off; what the client says of it is left for expect_said().
  void lose_link() {
    master_.close(link_);
    master_.run_for(10ms);
  }
  void expect_said(const std::vector<std::string>& words) {
    EXPECT_EQ(said_, words);
    said_.clear();
  }

  sim::EventQueue queue_{1};
  slave::VirtualMaster master_{queue_};
  std::unique_ptr<sim::Process> process_ =
      std::make_unique<sim::Process>(queue_, "anna", master_.network().add_node({}));
  net::RenewalAccess renewal_;  // of the client that is started next
  bool issues_certificates_ = false;
  std::unique_ptr<LastingClient> client_;
  std::vector<std::string> said_;
  std::size_t link_ = 0;
};

TEST_F(LastingClientTest, FramesWithoutAnOutcomeAreSubmittedToEachMasterThatComes) {
  start();
  welcome();
  master_.run_for(10ms);
  commit(1);
  submit(0, 1);
  submit(1, 1);
  for (int master = 0; master < 3; ++master) {
    expect_scene(1);
    expect_submit(0, 1);
    expect_submit(1, 1);
    lose_link();
    welcome();
  }
  expect_scene(1);
  expect_submit(0, 1);
  expect_submit(1, 1);
  deliver(0);
  expect_said({"welcome", "away", "welcome", "away", "welcome", "away", "welcome", "frame 0"});
  lose_link();
  welcome();
  expect_scene(1);
  expect_submit(1, 1);
  deliver(1);
  expect_said({"away", "welcome", "frame 1"});
}

TEST_F(LastingClientTest, EachFrameGoesBehindItsSceneAndOldScenesAreForgotten) {
  start();
  welcome();
  master_.run_for(10ms);
  for (const SceneVersion version : {1u, 2u, 3u}) commit(version);  // nobody asks for 1 and 2
  submit(0, 3);
  commit(4);
  submit(1, 4);
  master_.run_for(10ms);
  lose_link();
  while (const auto event = master_.next()) {
    if (!event->message) break;  // all that the first link brought
  }
  welcome();
  expect_scene(3);
  expect_submit(0, 3);
  expect_scene(4);
  expect_submit(1, 4);
  deliver(0);
  lose_link();
  welcome();
  expect_scene(4);
  expect_submit(1, 4);
}

TEST_F(LastingClientTest, WhatIsGivenUpWhileTheMasterIsAwayIsOverAtOnce) {
  start();
  welcome();
  master_.run_for(10ms);
  commit(1);
  submit(0, 1);
  submit(1, 1);
  client_->cancel_all();  // the master will not answer that any more
  submit(2, 1);
  master_.set_away(true);
  master_.run_for(10ms);
  lose_link();
  expect_said({"welcome", "away", "no frame 0", "no frame 1"});
  client_->cancel_all();
  expect_said({"no frame 2"});
  submit(3, 1);
  master_.run_for(10min);
  EXPECT_GE(said_.size(), 100u) << "it has been looked for";
  master_.set_away(false);
  while (const auto event = master_.next()) {
    if (event->message && std::holds_alternative<wire::Hello>(*event->message)) {
      link_ = event->link;
      break;
    }
  }
  master_.send(link_, wire::Welcome{1, 7, 7, 250, 59});
  expect_scene(1);
  expect_submit(3, 1);
}

TEST_F(LastingClientTest, ACertificateIsAskedForWhenItIsDueAndTheMasterMakesSome) {
  bool is_due = true;
  std::vector<std::string> answers;
  renewal_.request = [&]() -> std::optional<std::vector<std::byte>> {
    if (!std::exchange(is_due, false)) return std::nullopt;
    return std::vector<std::byte>(100);
  };
  renewal_.granted = [&](std::span<const std::byte> certificate, const std::string& reason) {
    answers.push_back(std::to_string(certificate.size()) + reason);
  };
  start();
  welcome();
  master_.run_for(2min);
  EXPECT_TRUE(is_due) << "this master makes none";
  issues_certificates_ = true;
  lose_link();
  welcome();
  EXPECT_EQ(master_.expect<wire::CertificateRequest>().der.size(), 100u);
  master_.send(link_, wire::CertificateGrant{{}, " not now"});
  master_.run_for(2s);
  is_due = true;
  EXPECT_EQ(master_.expect<wire::CertificateRequest>().der.size(), 100u) << "and looks again";
  master_.send(link_, wire::CertificateGrant{std::vector<std::byte>(7), ""});
  master_.run_for(10ms);
  EXPECT_EQ(answers, (std::vector<std::string>{"0 not now", "7"}));
  expect_said({"welcome", "away", "welcome"});
}

TEST_F(LastingClientTest, AtFirstAPersonWaitsForTheWord) {
  master_.set_away(true);
  start();
  master_.run_for(10min);
  expect_said({"ended: nobody is there"});
  EXPECT_EQ(master_.attempts(), 1);
}

TEST_F(LastingClientTest, AMasterThatIsBusyAtFirstIsFinalAndLaterIsTriedAgain) {
  start();
  welcome();
  master_.run_for(10ms);
  lose_link();
  for (int tries = 0; tries < 20; ++tries) {
    (void)master_.expect<wire::Hello>(&link_);
    master_.send(link_, wire::Refuse{wire::RefuseCode::kBusy, "another is here"});
    EXPECT_TRUE(master_.expect_closed(link_));
  }
  welcome();
  master_.run_for(10ms);
  EXPECT_EQ(said_.back(), "welcome");
  client_.reset();
  said_.clear();
  while (const auto event = master_.next()) {
    if (!event->message) break;
  }
  start();
  (void)master_.expect<wire::Hello>(&link_);
  master_.send(link_, wire::Refuse{wire::RefuseCode::kBusy, "another is here"});
  master_.run_for(1min);
  expect_said({"ended: the master refused: another is here"});
}

TEST_F(LastingClientTest, NonsenseWithoutEndIsFinal) {
  start();
  welcome();
  master_.run_for(10ms);
  said_.clear();
  for (int link = 0; link < LastingClient::kBreachesMax; ++link) {
    if (link > 0) welcome();
    master_.run_for(10ms);
    master_.send(link_, wire::FrameEnd{3});
    EXPECT_TRUE(master_.expect_closed(link_));
  }
  ASSERT_FALSE(said_.empty());
  EXPECT_EQ(said_.back().rfind("ended: ", 0), 0u) << said_.back();
  master_.run_for(1min);
  EXPECT_EQ(said_.size(), 2u * LastingClient::kBreachesMax - 1);
}

TEST_F(LastingClientTest, AMasterThatSaysNothingIsLeft) {
  start();
  welcome();
  master_.run_for(10ms);
  lose_link();
  (void)master_.expect<wire::Hello>(&link_);
  EXPECT_TRUE(master_.expect_closed(link_)) << "it had its time to welcome";
  welcome();
  master_.run_for(10ms);
  EXPECT_EQ(said_.back(), "welcome");
}

}  // namespace
}  // namespace tessera::master
