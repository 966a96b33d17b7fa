// SPDX-License-Identifier: Apache-2.0
// The relay's half of a slave in virtual time (tests/sim): a receiver of scenes, the slaves that it
// feeds and the one that feeds it. What a master would say to it, the test says.
//
// Threads. The test's.
#pragma once

#include <gtest/gtest.h>

#include <memory>
#include <optional>
#include <random>
#include <string>
#include <utility>
#include <vector>

#include "common/wire/codec.h"
#include "common/wire/scene_receiver.h"
#include "slave/relay_child.h"
#include "slave/relay_feeder.h"
#include "tests/sim/door.h"
#include "tests/sim/network.h"

namespace tessera::slave {

using Bytes = std::vector<std::byte>;

// A block of bytes that no codec shrinks; the last of its chunks is not full.
inline Bytes noise(std::uint32_t chunks) {
  std::mt19937 random(5);
  Bytes bytes(chunks * kSceneChunkBytes - 77);
  for (std::byte& b : bytes) b = static_cast<std::byte>(random());
  return bytes;
}

inline wire::SceneChunk chunk_of(SceneVersion version, const Bytes& block, std::uint32_t index) {
  const auto begin = block.begin() + static_cast<std::ptrdiff_t>(index * kSceneChunkBytes);
  return {version, 0, std::uint64_t{index} * kSceneChunkBytes,
          net::SharedBytes::of(
              {begin, begin + static_cast<std::ptrdiff_t>(chunk_bytes(block.size(), index))})};
}

class RelaySlave {
 public:
  static constexpr std::uint64_t kToken = 4711;
  static constexpr std::uint16_t kPort = 7500;

  RelaySlave(sim::EventQueue& queue, sim::Network& network, std::string name,
             const sim::LinkModel& link = {})
      : queue_(queue), network_(network), node_(network.add_node(link)) {
    process_ = std::make_unique<sim::Process>(queue, std::move(name), node_);
    access_.connect = [this](const net::Endpoint& at,
                             std::function<void(Result<net::ConnectionPtr>)> on_connected) {
      ++connects;
      return network_.connect(*process_, network_.node_of(at.host), std::move(on_connected));
    };
    door_ = std::make_unique<sim::Door>(*process_, kPort);
    feeder_ = std::make_unique<RelayFeeder>(*process_, receiver_, kToken);
    network.listen(*process_, [this](const net::ConnectionPtr& connection) {
      door_->accept(connection);
      feeder_->accept(connection, door_.get());
    });
    child_ = std::make_unique<RelayChild>(
        *process_, access_,
        RelayChild::Events{[this](const wire::SceneChunk& chunk) { return on_chunk(chunk); },
                           [this](wire::RelayFailed f) { failures.push_back(std::move(f)); }});
  }
  ~RelaySlave() { end(true); }
  RelaySlave(const RelaySlave&) = delete;
  RelaySlave& operator=(const RelaySlave&) = delete;

  // Ends the process. is_power_lost: nobody is told.
  void end(bool is_power_lost) {
    if (!process_) return;
    network_.on_process_ended(*process_, is_power_lost);
    process_->end();
    child_.reset();
    feeder_.reset();
    door_.reset();
    process_.reset();
  }

  // ---- what its master says
  void announce(SceneVersion version, const Bytes& block) {
    wire::SceneReceiver::Actions actions;
    wire::SceneAnnounce announce;
    announce.version = version;
    announce.digests = {make_scene_block(block).digest};
    announce.sizes = {block.size()};
    EXPECT_TRUE(receiver_.announce(announce, actions).is_ok());
    EXPECT_TRUE(receiver_.list({version, 0, chunk_digests(block)}, actions).is_ok());
    perform(actions);
  }
  void give(SceneVersion version, const Bytes& block, std::uint32_t index) {
    wire::SceneReceiver::Actions actions;
    EXPECT_TRUE(receiver_.chunk(chunk_of(version, block, index), actions).is_ok());
    perform(actions);
  }
  void follow(SceneVersion version, const RelaySlave& feeder, std::uint64_t token = kToken) {
    child_->follow(word(version, feeder.node(), token), receiver_.lacking());
  }

  static wire::RelayFrom word(SceneVersion version, int node, std::uint64_t token = kToken) {
    // A feeder's session has a number of its own.
    return {version, static_cast<SessionId>(node) + 100, sim::Network::host_of(node), kPort, token};
  }

  RelayAccess& access() { return access_; }
  RelayChild& child() { return *child_; }
  RelayFeeder& feeder() { return *feeder_; }
  sim::Process& process() { return *process_; }
  int node() const { return node_; }

  // What came from other slaves, and what became of it.
  std::vector<std::pair<std::uint32_t, TimePoint>> stored;
  std::optional<TimePoint> complete_at;
  std::vector<wire::RelayFailed> failures;
  int connects = 0;
  bool is_out_of_memory = false;

 private:
  std::optional<wire::RelayFault> on_chunk(const wire::SceneChunk& chunk) {
    using Verdict = wire::SceneReceiver::Verdict;
    wire::SceneReceiver::Actions actions;
    const Verdict verdict = is_out_of_memory ? Verdict::kNoMemory : receiver_.take(chunk, actions);
    if (verdict == Verdict::kStored) {
      stored.emplace_back(static_cast<std::uint32_t>(chunk.offset / kSceneChunkBytes),
                          queue_.now());
    }
    perform(actions);
    return relay_fault_of(verdict);
  }
  void perform(const wire::SceneReceiver::Actions& actions) {
    for (const SceneVersion version : actions.begun) feeder_->on_begun(version);
    for (const auto& arrival : actions.arrived) feeder_->on_arrived(arrival);
    if (actions.complete.empty()) return;
    complete_at = queue_.now();
    child_->rest();
  }

  sim::EventQueue& queue_;
  sim::Network& network_;
  const int node_;
  std::unique_ptr<sim::Process> process_;
  RelayAccess access_;
  wire::SceneReceiver receiver_;
  std::unique_ptr<sim::Door> door_;
  std::unique_ptr<RelayFeeder> feeder_;
  std::unique_ptr<RelayChild> child_;
};

}  // namespace tessera::slave
