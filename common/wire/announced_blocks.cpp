// SPDX-License-Identifier: Apache-2.0
#include "common/wire/announced_blocks.h"

#include <utility>

namespace tessera::wire {

void AnnouncedBlocks::describe(std::vector<Digest> digests, std::vector<std::uint64_t> sizes,
                               SceneAnnounce& announce) {
  announce.is_again = digests.size() == digests_.size();
  announce.places.clear();
  // Where most blocks differ, all are named, without their places.
  const std::size_t places_max = digests.size() / 2;
  for (std::uint32_t i = 0; announce.is_again && i < digests.size(); ++i) {
    if (digests[i] == digests_[i]) continue;
    announce.is_again = announce.places.size() < places_max;
    announce.places.push_back(i);
  }
  if (announce.is_again) {
    for (const std::uint32_t place : announce.places) {
      announce.digests.push_back(digests[place]);
      announce.sizes.push_back(sizes[place]);
    }
  } else {
    announce.places.clear();
    announce.digests = digests;
    announce.sizes = sizes;
  }
  digests_ = std::move(digests);
  sizes_ = std::move(sizes);
}

Status AnnouncedBlocks::complete(SceneAnnounce& announce) {
  if (announce.is_again) {
    if (digests_.empty())
      return Status::data_loss("SceneAnnounce.is_again, but no scene was announced before");
    // The codec has looked that places rise.
    if (!announce.places.empty() && announce.places.back() >= digests_.size())
      return Status::data_loss("SceneAnnounce.places names a block that the scene before lacks");
    for (std::size_t i = 0; i < announce.places.size(); ++i) {
      digests_[announce.places[i]] = announce.digests[i];
      sizes_[announce.places[i]] = announce.sizes[i];
    }
    announce.is_again = false;
    announce.places.clear();
    announce.digests = digests_;
    announce.sizes = sizes_;
  } else {
    digests_ = announce.digests;
    sizes_ = announce.sizes;
  }
  return Status::ok();
}

void AnnouncedBlocks::forget() {
  digests_.clear();
  sizes_.clear();
}

}  // namespace tessera::wire
