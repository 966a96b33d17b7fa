#include "common/wire/scene_receiver.h"

#include <new>
#include <stdexcept>
#include <utility>

namespace tessera::wire {

Status SceneReceiver::announce(SceneAnnounce announce, Actions& actions) {
  if (announce.version <= newest_announced_) {
    return Status::data_loss("SceneAnnounce.version " + std::to_string(announce.version) +
                             " does not follow " + std::to_string(newest_announced_));
  }
  if (waiting_.size() >= kAnnouncedMax) {
    return Status::resource_exhausted("more than " + std::to_string(kAnnouncedMax) +
                                      " scenes announced and not complete");
  }
  newest_announced_ = announce.version;
  waiting_.push_back(std::move(announce));
  if (!head_) serve_next(actions);
  return Status::ok();
}

void SceneReceiver::serve_next(Actions& actions) {
  while (!head_ && !waiting_.empty()) {
    head_ = std::make_unique<Head>();
    head_->announce = std::move(waiting_.front());
    waiting_.pop_front();
    const SceneAnnounce& a = head_->announce;
    SceneNeed need;
    need.version = a.version;
    head_->blocks.resize(a.digests.size());
    for (std::uint32_t i = 0; i < a.digests.size(); ++i) {
      const auto cached = cache_.find(a.digests[i]);
      if (cached != cache_.end()) {
        head_->blocks[i] = cached->second;
        continue;
      }
      std::vector<std::uint32_t>& indices = head_->lacking[a.digests[i]];
      if (indices.empty()) need.blocks.push_back(i);
      indices.push_back(i);
    }
    actions.need.push_back(std::move(need));
    if (head_->lacking.empty()) finish_head(actions);
  }
}

Status SceneReceiver::chunk(const SceneChunk& chunk, Actions& actions) {
  if (!head_ || chunk.version != head_->announce.version) {
    // Pieces of a version that failed or was retired may still be under way.
    const SceneVersion begun = head_ ? head_->announce.version
                                     : newest_announced_ + 1;  // all that were announced are done
    if (chunk.version < begun) return Status::ok();
    return Status::data_loss("SceneChunk of version " + std::to_string(chunk.version) +
                             ", which was not asked for");
  }
  const SceneAnnounce& a = head_->announce;
  const std::string place = "SceneChunk of block " + std::to_string(chunk.block);
  if (chunk.block >= a.digests.size()) return Status::data_loss(place + ": there is no such block");
  const auto lacking = head_->lacking.find(a.digests[chunk.block]);
  if (lacking == head_->lacking.end() || lacking->second.front() != chunk.block) {
    return Status::data_loss(place + ": the block was not asked for");
  }
  const std::uint64_t size = a.sizes[chunk.block];
  try {
    Partial& partial = head_->partial[chunk.block];
    if (chunk.offset != partial.bytes.size() || chunk.bytes.bytes.size() > size - chunk.offset) {
      return Status::data_loss(place + ": the piece does not continue the block");
    }
    if (partial.bytes.empty()) partial.bytes.reserve(static_cast<std::size_t>(size));
    partial.bytes.insert(partial.bytes.end(), chunk.bytes.bytes.begin(), chunk.bytes.bytes.end());
    partial.hash.update(chunk.bytes.bytes);
    if (partial.bytes.size() < size) return Status::ok();
    if (partial.hash.finish() != a.digests[chunk.block]) {
      fail_head("block " + std::to_string(chunk.block) + " does not have its digest", actions);
      return Status::ok();
    }
    const auto whole = std::make_shared<const std::vector<std::byte>>(std::move(partial.bytes));
    for (const std::uint32_t index : lacking->second) head_->blocks[index] = whole;
  } catch (const std::bad_alloc&) {
    fail_head("no memory for a scene block of " + std::to_string(size) + " bytes", actions);
    return Status::ok();
  }
  head_->partial.erase(chunk.block);
  head_->lacking.erase(lacking);
  if (head_->lacking.empty()) {
    finish_head(actions);
    serve_next(actions);
  }
  return Status::ok();
}

void SceneReceiver::finish_head(Actions& actions) {
  const std::unique_ptr<Head> head = std::move(head_);
  Complete complete;
  complete.version = head->announce.version;
  for (std::size_t i = 0; i < head->blocks.size(); ++i) {
    if (head->blocks[i]->size() != head->announce.sizes[i]) {
      actions.failed.push_back(
          {complete.version, "block " + std::to_string(i) + " does not have its announced size"});
      return;
    }
    complete.scene.blocks.push_back({head->announce.digests[i], std::move(head->blocks[i])});
  }
  keep(complete.scene);
  actions.complete.push_back(std::move(complete));
}

void SceneReceiver::keep(const EncodedScene& scene) {
  kept_.push_back(scene);
  if (kept_.size() > kScenesKept) kept_.pop_front();
  cache_.clear();
  for (const EncodedScene& k : kept_) {
    for (const SceneBlock& block : k.blocks) cache_.emplace(block.digest, block.bytes);
  }
}

void SceneReceiver::fail_head(std::string reason, Actions& actions) {
  actions.failed.push_back({head_->announce.version, std::move(reason)});
  head_.reset();
  serve_next(actions);
}

void SceneReceiver::retire(SceneVersion first_kept, Actions& actions) {
  while (!waiting_.empty() && waiting_.front().version < first_kept) waiting_.pop_front();
  if (head_ && head_->announce.version < first_kept) {
    head_.reset();
    serve_next(actions);
  }
}

void SceneReceiver::reset() {
  waiting_.clear();
  head_.reset();
  newest_announced_ = 0;
}

}  // namespace tessera::wire
