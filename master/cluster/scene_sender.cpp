// SPDX-License-Identifier: Apache-2.0
#include "master/cluster/scene_sender.h"

#include <algorithm>
#include <utility>

#include "common/base/clock.h"
#include "common/base/limits.h"
#include "common/wire/chunk_coding.h"
#include "master/cluster/master_metrics.h"

namespace tessera::master {
namespace {

static_assert(kSceneChunkBytes < net::kSendQueueLowBytes,
              "on_drained comes only after the queue was above its low mark");

}  // namespace

void SceneSender::commit(SceneVersion version, SharedScene scene) {
  if (version < first_kept_) return;
  scenes_[version] = std::move(scene);
  std::erase_if(scenes_, [&](const auto& entry) {
    return entry.first < version && !announced_.contains(entry.first) &&
           !needed_.contains(entry.first);
  });
  announce_next();
}

void SceneSender::need(SceneVersion version) {
  needed_.insert(version);
  announce_next();
}

void SceneSender::announce_next() {
  while (announced_.size() < kUnansweredMax) {
    const SceneVersion last = announced_.empty() ? 0 : *announced_.rbegin();
    const auto next = std::find_if(scenes_.begin(), scenes_.end(), [&](const auto& entry) {
      const bool is_newest = entry.first == scenes_.rbegin()->first && live_.size() < kLiveMax;
      return entry.first > last && (is_newest || needed_.contains(entry.first));
    });
    if (next == scenes_.end()) return;
    announce(next->first, next->second);
  }
}

void SceneSender::announce(SceneVersion version, const SharedScene& scene) {
  wire::SceneAnnounce announce;
  announce.version = version;
  announce.index_bytes = scene->index_bytes;
  announce.time_seconds = scene->time_seconds;
  newest_blocks_.describe(scene->blocks, announce);
  announced_.insert(version);
  live_.insert(version);
  link_.send(std::move(announce));
}

Status SceneSender::on_need(const wire::SceneNeed& need) {
  if (need.version < first_kept_) return Status::ok();  // retired meanwhile
  if (need.blocks.empty()) return Status::ok();
  if (!asked_.insert(need.version).second) {
    return Status::data_loss("a second SceneNeed for one version");
  }
  const auto scene = scenes_.find(need.version);
  std::uint64_t bytes = 0;
  for (const std::uint32_t block : need.blocks) {
    if (scene == scenes_.end() || !announced_.contains(need.version) ||
        block >= scene->second->blocks.size()) {
      return Status::data_loss("SceneNeed for a block that was not announced");
    }
    bytes += scene->second->blocks[block].bytes->size();
  }
  codings_ = need.codings;
  const bool is_fed = feed_by_ && feed_by_(need.version, bytes);
  for (const std::uint32_t block : need.blocks) {
    const bool is_list = !is_one_chunk(scene->second->blocks[block].bytes->size());
    if (is_list || !is_fed) uploads_.push_back({need.version, block, is_list, {}, 0});
  }
  pump();
  return Status::ok();
}

Status SceneSender::on_chunk_need(wire::SceneChunkNeed need) {
  if (need.version < first_kept_) return Status::ok();
  const auto scene = scenes_.find(need.version);
  if (scene == scenes_.end() || !asked_.contains(need.version) ||
      need.block >= scene->second->blocks.size()) {
    return Status::data_loss("SceneChunkNeed for a block that was not announced");
  }
  const SceneBlock& block = scene->second->blocks[need.block];
  if (need.chunks.size() != chunk_count(block.bytes->size())) {
    return Status::data_loss("SceneChunkNeed for another number of chunks than the block has");
  }
  if (++chunk_asks_[need.version] > kAskedAgainMax * scene->second->blocks.size()) {
    return Status::data_loss("SceneChunkNeed again and again for one version");
  }
  // What is asked for anew replaces what is still to be sent of the block.
  std::erase_if(uploads_, [&](const Upload& upload) {
    return upload.version == need.version && upload.block == need.block && !upload.is_list;
  });
  uploads_.push_back({need.version, need.block, false, std::move(need.chunks), 0});
  pump();
  return Status::ok();
}

void SceneSender::on_answered(SceneVersion version) {
  is_joining_ = false;
  announced_.erase(version);
  needed_.erase(version);
  asked_.erase(version);
  chunk_asks_.erase(version);
  scenes_.erase(version);
  announce_next();
}

void SceneSender::pump() {
  while (!uploads_.empty() && link_.connection().queue_bytes() <= net::kSendQueueLowBytes) {
    Upload& upload = uploads_.front();
    const auto scene = scenes_.find(upload.version);
    if (scene == scenes_.end()) {
      uploads_.pop_front();
      continue;
    }
    const net::LinkCounters counters = link_.connection().link_counters();
    rate_.observe(counters);
    chooser_.set_link(rate_.bytes_per_second());
    if (is_gentle_) {
      if (!pace_.may_send(Clock::now(), counters)) return;
      pace_.sent(Clock::now());
    }
    if (send_some(upload, scene->second->blocks[upload.block])) uploads_.pop_front();
  }
}

bool SceneSender::send_some(Upload& upload, const SceneBlock& block) {
  if (upload.is_list) {
    link_.send(wire::SceneChunkList{upload.version, upload.block, *block.chunks});
    return true;
  }
  const std::uint32_t count = chunk_count(block.bytes->size());
  const auto is_wanted = [&](std::uint32_t index) {
    return upload.chunks.empty() || upload.chunks[index];
  };
  while (upload.next < count && !is_wanted(upload.next)) ++upload.next;
  if (upload.next == count) return true;
  send_chunk(upload, block, upload.next++);
  return upload.next == count;
}

void SceneSender::send_chunk(const Upload& upload, const SceneBlock& block, std::uint32_t index) {
  const std::uint64_t offset = std::uint64_t{index} * kSceneChunkBytes;
  net::SharedBytes bytes{
      block.bytes,
      std::span(*block.bytes).subspan(offset, chunk_bytes(block.bytes->size(), index))};
  wire::SceneChunk chunk{upload.version, upload.block, offset, bytes};
  wire::code_chunk(chooser_, codings_, chunk);
  master_metrics().scene_bytes_sent.add(chunk.bytes.bytes.size());
  link_.send(std::move(chunk));
}

void SceneSender::retire(SceneVersion first_kept, bool keeps_newest) {
  if (first_kept <= first_kept_) return;
  first_kept_ = first_kept;
  scenes_.erase(scenes_.begin(), scenes_.lower_bound(first_kept));
  const auto kept = announced_.lower_bound(first_kept);
  if (kept != announced_.begin()) is_joining_ = false;
  announced_.erase(announced_.begin(), kept);
  needed_.erase(needed_.begin(), needed_.lower_bound(first_kept));
  asked_.erase(asked_.begin(), asked_.lower_bound(first_kept));
  chunk_asks_.erase(chunk_asks_.begin(), chunk_asks_.lower_bound(first_kept));
  live_.erase(live_.begin(), live_.lower_bound(first_kept));
  std::erase_if(uploads_, [&](const Upload& upload) { return upload.version < first_kept; });
  link_.send(wire::SceneRetire{first_kept, keeps_newest});
  announce_next();
}

}  // namespace tessera::master
