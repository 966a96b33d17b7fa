// SPDX-License-Identifier: Apache-2.0
// Messages as a fuzz input says them. Most numbers are small, and scenes are made of a few blocks
// that there are, so that what is said often means something to who hears it; the rest is bytes of
// the input as a record of any type.
//
// Threads. One.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "common/net/record.h"
#include "common/scene/scene_codec.h"
#include "common/wire/messages.h"
#include "tests/fuzz/fuzz_input.h"

namespace tessera::test {

// Names that a peer has been told, and may repeat.
struct Heard {
  SessionId session = 1;
  std::uint64_t token = 0;
  std::string host = "10.0.0.0";  // of a slave that feeds others
};

class Speech {
 public:
  explicit Speech(FuzzInput& input) : input_(input) {}

  net::Record record(const Heard& heard);
  // One of the messages that SceneReceiver takes, as the sender of scenes says them.
  wire::Message scene_message();

  std::uint64_t number();

 private:
  net::Record any_record();
  wire::Message message(std::uint8_t kind, const Heard& heard);
  wire::Message hello();
  wire::Message of_master(std::uint8_t kind);
  wire::Message of_slave(std::uint8_t kind);
  wire::Message of_relay(std::uint8_t kind, const Heard& heard);
  wire::Message of_application(std::uint8_t kind);
  wire::SceneAnnounce announce();
  wire::SceneChunkList chunk_list();
  wire::SceneChunk chunk();
  FrameSettings settings();
  std::uint32_t small() { return static_cast<std::uint32_t>(number()); }
  std::string name();
  std::string reason() { return std::string(input_.below(40), 'r'); }

  FuzzInput& input_;
};

// Blocks that scenes of Speech are made of: those of scenes 0 and 1 of tests/sim, and larger ones
// that have a chunk in common.
const std::vector<SceneBlock>& spoken_blocks();

}  // namespace tessera::test
