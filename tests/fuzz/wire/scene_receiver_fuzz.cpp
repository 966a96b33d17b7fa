// SPDX-License-Identifier: Apache-2.0
// Any order of announcements, lists, chunks and retirements: scenes that come out have the digests
// and sizes that were announced, each version once, and what is asked for is what lacks.
#include <cstdlib>
#include <map>
#include <utility>

#include "common/wire/codec.h"
#include "common/wire/scene_receiver.h"
#include "tests/fuzz/peers/speech.h"

namespace {

using namespace tessera;
using wire::SceneReceiver;

constexpr std::uint64_t kRoomBytes = std::uint64_t{1} << 20;
constexpr int kMessagesMax = 200;

class Owner {
 public:
  explicit Owner(SceneReceiver::Use use)
      : receiver_([](std::uint64_t) { return std::optional(kRoomBytes); }, use) {}

  void step(test::FuzzInput& input) {
    const std::uint8_t kind = input.below(32);
    if (kind == 0) {
      receiver_.reset();
      announced_.clear();
      last_.forget();
    } else {
      // Only what a peer could have sent.
      auto message = as_received(test::Speech(input).scene_message());
      if (message.is_ok()) take(std::move(*message), kind < 8);
    }
  }

 private:
  static Result<wire::Message> as_received(wire::Message message) {
    net::Record record = wire::encode(std::move(message));
    return wire::decode(
        {record.type, record.header, {record.payload.bytes.begin(), record.payload.bytes.end()}});
  }

  void take(wire::Message message, bool is_of_stranger) {
    SceneReceiver::Actions actions;
    Status status;
    if (auto* announce = std::get_if<wire::SceneAnnounce>(&message)) {
      wire::SceneAnnounce copy = *announce;
      status = receiver_.announce(std::move(*announce), actions);
      if (status.is_ok()) remember(std::move(copy));
    } else if (auto* list = std::get_if<wire::SceneChunkList>(&message)) {
      status = receiver_.list(std::move(*list), actions);
    } else if (const auto* retire = std::get_if<wire::SceneRetire>(&message)) {
      receiver_.retire(retire->first_kept, actions);
    } else if (const auto* chunk = std::get_if<wire::SceneChunk>(&message)) {
      if (is_of_stranger) {
        (void)receiver_.take(*chunk, actions);
      } else {
        status = receiver_.chunk(*chunk, actions);
      }
    }
    if (!status.is_ok() && status.message().empty()) std::abort();
    look_at(actions);
  }

  void remember(wire::SceneAnnounce announce) {
    if (!last_.take(announce).is_ok()) std::abort();
    announced_[announce.version] = last_.names();
  }

  void look_at(const SceneReceiver::Actions& actions) {
    for (const auto& complete : actions.complete) {
      const auto found = announced_.find(complete.version);
      if (found == announced_.end()) std::abort();
      const wire::BlockNames& names = found->second;
      if (complete.scene.blocks.size() != names.size()) std::abort();
      for (std::size_t i = 0; i < names.size(); ++i) {
        const SceneBlock& block = complete.scene.blocks[i];
        if (names[i] != wire::BlockName{block.digest, block.bytes->size()}) std::abort();
        if (make_scene_block({block.bytes->begin(), block.bytes->end()}).digest != block.digest)
          std::abort();
      }
      announced_.erase(found);
    }
    for (const auto& failed : actions.failed) {
      if (failed.reason.empty() || announced_.erase(failed.version) != 1) std::abort();
    }
    if (actions.arrived.size() > kArrivedMax) std::abort();
    for (const auto& need : receiver_.lacking()) {
      net::SharedBytes bytes;
      for (std::uint32_t i = 0; i < need.chunks.size(); ++i) {
        const auto holding = receiver_.find(need.version, need.block, i, bytes);
        if (need.chunks[i] != (holding == SceneReceiver::Holding::kNotYet)) std::abort();
      }
    }
    if (receiver_.head_bytes() > kRoomBytes) std::abort();
  }

  static constexpr std::size_t kArrivedMax =
      100;  // far above the chunks of all blocks that there are

  SceneReceiver receiver_;
  std::map<SceneVersion, wire::BlockNames> announced_;  // neither complete nor failed
  wire::AnnouncedBlocks last_;
};

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  test::FuzzInput input(data, size);
  Owner owner(input.yes() ? SceneReceiver::Use::kBuilt : SceneReceiver::Use::kKept);
  for (int i = 0; i < kMessagesMax && !input.is_at_end(); ++i) owner.step(input);
  return 0;
}
