// SPDX-License-Identifier: Apache-2.0
// The blocks of the newest scene that was announced on a connection, as both of its ends know them:
// where the next scene has as many, only those that differ are named.
//
// Threads. One at a time.
#pragma once

#include <cstdint>
#include <vector>

#include "common/base/digest.h"
#include "common/base/status.h"
#include "common/wire/messages.h"

namespace tessera::wire {

class AnnouncedBlocks {
 public:
  // For the sender: says in `announce` which blocks the scene has. Requires: equal digests have
  // equal sizes.
  void describe(std::vector<Digest> digests, std::vector<std::uint64_t> sizes,
                SceneAnnounce& announce);
  // For the receiver: puts the blocks of the announcement before where nothing is said of them, so
  // that all are named. Returns: kDataLoss, and then nothing has changed.
  Status complete(SceneAnnounce& announce);
  void forget();

 private:
  std::vector<Digest> digests_;
  std::vector<std::uint64_t> sizes_;
};

}  // namespace tessera::wire
