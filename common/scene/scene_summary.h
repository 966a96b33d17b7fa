// SPDX-License-Identifier: Apache-2.0
// What identifies a scene, and its size, from the names of its blocks. A scene's digest is the
// SHA-256 of the SHA-256s of its blocks' digests, 256 blocks each, in order: so a version that
// differs in few blocks of thousands is summed up by hashing few digests anew.
//
// Threads. One at a time.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "common/base/digest.h"
#include "common/scene/scene_codec.h"

namespace tessera {

// The digest of a scene whose blocks have these.
Digest scene_digest(std::span<const Digest> blocks);

struct SceneSummary {
  Digest digest;
  std::uint64_t bytes = 0;  // of all blocks
};

// Sums up version after version; what a version shares with the one before is not looked at.
class SceneSummarizer {
 public:
  SceneSummary of(const BlockTable& blocks);

 private:
  BlockTable::Trace seen_;
  std::vector<SceneSummary> groups_;  // by chunk of the table
};

}  // namespace tessera
