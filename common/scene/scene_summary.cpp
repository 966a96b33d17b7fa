// SPDX-License-Identifier: Apache-2.0
#include "common/scene/scene_summary.h"

#include <algorithm>
#include <utility>

namespace tessera {
namespace {

constexpr std::size_t kGroup = 256;  // blocks, as PROTOCOL.md says
static_assert(BlockTable::kChunk == kGroup);

SceneSummary sum_up(const BlockTable& blocks, std::size_t group) {
  Sha256 hash;
  SceneSummary summary;
  const std::size_t end = std::min(blocks.size(), (group + 1) * kGroup);
  for (std::size_t i = group * kGroup; i < end; ++i) {
    hash.update(std::as_bytes(std::span(blocks[i].digest.bytes)));
    summary.bytes += blocks[i].bytes->size();
  }
  summary.digest = hash.finish();
  return summary;
}

}  // namespace

Digest scene_digest(std::span<const Digest> blocks) {
  Sha256 all;
  for (; !blocks.empty(); blocks = blocks.subspan(std::min(kGroup, blocks.size()))) {
    const Digest group = sha256(std::as_bytes(blocks.first(std::min(kGroup, blocks.size()))));
    all.update(std::as_bytes(std::span(group.bytes)));
  }
  return all.finish();
}

SceneSummary SceneSummarizer::of(const BlockTable& blocks) {
  groups_.resize((blocks.size() + kGroup - 1) / kGroup);
  std::size_t next = 0;  // groups below are done
  // Where memory ends between here and the end, nothing is taken for seen.
  const BlockTable::Trace seen = std::exchange(seen_, {});
  seen.for_each_apart(blocks, [&](std::size_t i) {
    if (i / kGroup < next) return;
    groups_[i / kGroup] = sum_up(blocks, i / kGroup);
    next = i / kGroup + 1;
  });
  seen_ = BlockTable::Trace(blocks);
  Sha256 hash;
  SceneSummary all;
  for (const SceneSummary& group : groups_) {
    hash.update(std::as_bytes(std::span(group.digest.bytes)));
    all.bytes += group.bytes;
  }
  all.digest = hash.finish();
  return all;
}

Digest EncodedScene::digest() const { return SceneSummarizer().of(blocks).digest; }

}  // namespace tessera
