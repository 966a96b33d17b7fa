// SPDX-License-Identifier: Apache-2.0
// The blocks of the newest scene that was announced on a connection, as both of its ends know them:
// where the next scene has as many, only those that differ are named.
//
// Threads. One at a time.
#pragma once

#include <cstdint>

#include "common/base/digest.h"
#include "common/base/shared_table.h"
#include "common/base/status.h"
#include "common/scene/scene_codec.h"
#include "common/wire/messages.h"

namespace tessera::wire {

struct BlockName {
  Digest digest;
  std::uint64_t size_bytes = 0;
  bool operator==(const BlockName&) const = default;
};
using BlockNames = SharedTable<BlockName>;

class AnnouncedBlocks {
 public:
  // For the sender: says in `announce` which blocks the scene has. Requires: equal digests have
  // equal sizes.
  void describe(const BlockTable& blocks, SceneAnnounce& announce);
  // For the receiver: the blocks are those of the announcement before where nothing is said of
  // them. Returns: kDataLoss, and then nothing has changed.
  Status take(const SceneAnnounce& announce);
  void forget();

  const BlockNames& names() const { return names_; }
  // Of all blocks; meaningless where a peer says sizes whose sum passes 64 bits.
  std::uint64_t total_bytes() const { return total_bytes_; }

 private:
  BlockNames names_;
  std::uint64_t total_bytes_ = 0;
  BlockTable::Trace described_;  // what describe() was given last
};

}  // namespace tessera::wire
