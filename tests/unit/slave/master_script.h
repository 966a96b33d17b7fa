// SPDX-License-Identifier: Apache-2.0
// The master's half of a conversation with one slave. It sends only what the test tells it to (but
// for Pong) and hands out what came, message by message. The transport is that of the two classes
// that implement it: FakeMaster (threads, real time) and VirtualMaster (tests/sim's time).
//
// Threads. The test's.
#pragma once

#include <gtest/gtest.h>

#include <optional>
#include <string>
#include <vector>

#include "common/scene/scene_codec.h"
#include "common/wire/codec.h"

namespace tessera::slave {

class MasterScript {
 public:
  // An arrival: a message, or the end of a link.
  struct Event {
    std::size_t link = 0;  // numbered in order of opening
    std::optional<wire::Message> message;
    std::string closed;
  };

  virtual ~MasterScript() = default;

  // Returns: the next message but heartbeats, or the end of a link; nothing when time is up.
  virtual std::optional<Event> next() = 0;
  virtual void send(std::size_t link, wire::Message message) = 0;
  virtual void close(std::size_t link) = 0;

  // Returns: the next event, which must be an M; a default M when the test has failed.
  template <typename M>
  M expect(std::size_t* link = nullptr) {
    const std::optional<Event> event = next();
    if (!event) {
      ADD_FAILURE() << "nothing came";
      return {};
    }
    if (!event->message || !std::holds_alternative<M>(*event->message)) {
      ADD_FAILURE() << "instead came "
                    << (event->message ? wire::message_name(*event->message) : event->closed);
      return {};
    }
    if (link != nullptr) *link = event->link;
    return std::get<M>(*event->message);
  }

  // Skips events up to the end of `link`. Returns: whether that came.
  bool expect_closed(std::size_t link) {
    while (std::optional<Event> event = next()) {
      if (event->link == link && !event->message) return true;
    }
    return false;
  }

  // Expects that the slave refuses the session for a reason with `word` in it and closes a link.
  void expect_breach(const std::string& word) {
    bool is_told = false;
    while (const auto event = next()) {
      if (!event->message) break;
      if (const auto* refuse = std::get_if<wire::Refuse>(&*event->message)) {
        is_told = true;
        EXPECT_EQ(refuse->code, wire::RefuseCode::kProtocol);
        EXPECT_NE(refuse->reason.find(word), std::string::npos) << refuse->reason;
      }
    }
    EXPECT_TRUE(is_told);
  }

  bool issues_certificates = false;  // as the next Welcome says

  // Exchanges Hello, Welcome, Join and Joined; `tile` and `scene` are the links from then on.
  void shake_hands(std::uint32_t heartbeat_ms = 250, std::uint32_t missed_max = 4) {
    skip_to_hello();  // past what an earlier session left behind
    const wire::Welcome welcome{1,          ++session_,         4711 + session_, heartbeat_ms,
                                missed_max, issues_certificates};
    send(tile, welcome);
    const wire::Join join = expect<wire::Join>(&scene);
    EXPECT_EQ(join.session, welcome.session);
    EXPECT_EQ(join.token, welcome.token);
    EXPECT_NE(tile, scene);
    send(scene, wire::Joined{});
  }

  void announce(SceneVersion version, const EncodedScene& encoded) {
    wire::SceneAnnounce announce;
    announce.version = version;
    for (const SceneBlock& block : encoded.blocks) {
      announce.digests.push_back(block.digest);
      announce.sizes.push_back(block.bytes->size());
    }
    send(scene, std::move(announce));
  }

  // Runs the whole scene pipeline up to SceneBuilt. Returns: how many blocks the slave lacked.
  std::size_t give_scene(SceneVersion version, const EncodedScene& encoded) {
    announce(version, encoded);
    const wire::SceneNeed need = expect<wire::SceneNeed>();
    EXPECT_EQ(need.version, version);
    for (const std::uint32_t block : need.blocks) {
      const BlockBytes& bytes = encoded.blocks.at(block).bytes;
      send(scene, wire::SceneChunk{version, block, 0, {bytes, *bytes}});
    }
    built = expect<wire::SceneBuilt>();
    EXPECT_EQ(built.version, version);
    return need.blocks.size();
  }

  static FrameSettings small_frame() {
    FrameSettings settings;
    settings.width_px = 64;
    settings.height_px = 40;
    settings.tile_edge_px = 16;  // 4 x 3 tiles, the last row 8 high
    settings.renderer = Renderer::kPrimary;
    return settings;
  }
  void begin(FrameId frame, SceneVersion version) {
    send(tile, wire::FrameBegin{frame, version, Isa::kScalar, small_frame()});
  }
  void lease(FrameId frame, TileIndex index, Attempt attempt = 1) {
    send(tile, wire::TileLease{frame, index, attempt});
  }

  std::size_t tile = 0, scene = 0;  // the links of the session
  wire::Hello hello;                // of the session
  wire::SceneBuilt built;           // the last one

 private:
  void skip_to_hello() {
    while (const std::optional<Event> event = next()) {
      if (!event->message || !std::holds_alternative<wire::Hello>(*event->message)) continue;
      hello = std::get<wire::Hello>(*event->message);
      tile = event->link;
      return;
    }
    ADD_FAILURE() << "no Hello came";
  }

  std::uint64_t session_ = 0;
};

}  // namespace tessera::slave
