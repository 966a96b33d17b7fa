// SPDX-License-Identifier: Apache-2.0
#include "common/wire/announced_blocks.h"

#include <utility>
#include <vector>

namespace tessera::wire {

void AnnouncedBlocks::describe(const BlockTable& blocks, SceneAnnounce& announce) {
  announce.is_again = blocks.size() == names_.size();
  announce.places.clear();
  BlockNames::Editor names(names_);
  names.resize(blocks.size());
  const auto compare = [&](std::size_t i) {
    const BlockName name{blocks[i].digest, blocks[i].bytes->size()};
    if (names[i] == name) return;
    names.edit(i) = name;
    announce.places.push_back(static_cast<std::uint32_t>(i));
  };
  described_.for_each_apart(blocks, compare);
  names_ = names.finish();
  described_ = BlockTable::Trace(blocks);
  // Where most blocks differ, all are named, without their places.
  announce.is_again = announce.is_again && announce.places.size() <= blocks.size() / 2;
  if (announce.is_again) {
    for (const std::uint32_t place : announce.places) {
      announce.digests.push_back(names_[place].digest);
      announce.sizes.push_back(names_[place].size_bytes);
    }
    return;
  }
  announce.places.clear();
  for (const BlockName& name : names_) {
    announce.digests.push_back(name.digest);
    announce.sizes.push_back(name.size_bytes);
  }
}

Status AnnouncedBlocks::take(const SceneAnnounce& announce) {
  if (announce.is_again) {
    if (names_.empty())
      return Status::data_loss("SceneAnnounce.is_again, but no scene was announced before");
    // The codec has looked that places rise.
    if (!announce.places.empty() && announce.places.back() >= names_.size())
      return Status::data_loss("SceneAnnounce.places names a block that the scene before lacks");
    BlockNames::Editor names(names_);
    for (std::size_t i = 0; i < announce.places.size(); ++i) {
      BlockName& name = names.edit(announce.places[i]);
      total_bytes_ += announce.sizes[i] - name.size_bytes;
      name = {announce.digests[i], announce.sizes[i]};
    }
    names_ = names.finish();
    return Status::ok();
  }
  std::vector<BlockName> names;
  names.reserve(announce.digests.size());
  total_bytes_ = 0;
  for (std::size_t i = 0; i < announce.digests.size(); ++i) {
    names.push_back({announce.digests[i], announce.sizes[i]});
    total_bytes_ += announce.sizes[i];
  }
  names_ = std::move(names);
  return Status::ok();
}

void AnnouncedBlocks::forget() {
  names_ = {};
  total_bytes_ = 0;
  described_ = {};
}

}  // namespace tessera::wire
