#include "master/cluster/scene_sender.h"

#include <algorithm>
#include <utility>

#include "master/cluster/master_metrics.h"

namespace tessera::master {
namespace {

// One piece; heartbeats and leases on a link of 100 Mbit/s wait at most 20 ms behind it.
constexpr std::uint64_t kPieceBytes = 256 * 1024;
static_assert(kPieceBytes <= kSceneChunkBytesMax);
static_assert(kPieceBytes < net::kSendQueueLowBytes,
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
    wire::SceneAnnounce announce;
    announce.version = next->first;
    for (const SceneBlock& block : next->second->blocks) {
      announce.digests.push_back(block.digest);
      announce.sizes.push_back(block.bytes->size());
    }
    announced_.insert(next->first);
    live_.insert(next->first);
    link_.send(std::move(announce));
  }
}

Status SceneSender::on_need(const wire::SceneNeed& need) {
  if (need.version < first_kept_) return Status::ok();  // retired meanwhile
  if (!need.blocks.empty() && !asked_.insert(need.version).second) {
    return Status::data_loss("a second SceneNeed for one version");
  }
  const auto scene = scenes_.find(need.version);
  for (const std::uint32_t block : need.blocks) {
    if (scene == scenes_.end() || !announced_.contains(need.version) ||
        block >= scene->second->blocks.size()) {
      return Status::data_loss("SceneNeed for a block that was not announced");
    }
    uploads_.push_back({need.version, block, 0});
  }
  pump();
  return Status::ok();
}

void SceneSender::on_answered(SceneVersion version) {
  announced_.erase(version);
  needed_.erase(version);
  asked_.erase(version);
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
    const BlockBytes& bytes = scene->second->blocks[upload.block].bytes;
    const std::uint64_t size = std::min<std::uint64_t>(bytes->size() - upload.offset, kPieceBytes);
    net::SharedBytes piece{bytes, std::span(*bytes).subspan(upload.offset, size)};
    link_.send(wire::SceneChunk{upload.version, upload.block, upload.offset, std::move(piece)});
    master_metrics().scene_bytes_sent.add(size);
    upload.offset += size;
    if (upload.offset >= bytes->size()) uploads_.pop_front();
  }
}

void SceneSender::retire(SceneVersion first_kept) {
  if (first_kept <= first_kept_) return;
  first_kept_ = first_kept;
  scenes_.erase(scenes_.begin(), scenes_.lower_bound(first_kept));
  announced_.erase(announced_.begin(), announced_.lower_bound(first_kept));
  needed_.erase(needed_.begin(), needed_.lower_bound(first_kept));
  asked_.erase(asked_.begin(), asked_.lower_bound(first_kept));
  live_.erase(live_.begin(), live_.lower_bound(first_kept));
  std::erase_if(uploads_, [&](const Upload& upload) { return upload.version < first_kept; });
  link_.send(wire::SceneRetire{first_kept});
  announce_next();
}

}  // namespace tessera::master
