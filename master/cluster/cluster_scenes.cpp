// SPDX-License-Identifier: Apache-2.0
// What a cluster does about scenes: offers them, hears who cannot hold them, and lets data for
// slaves that join yield to the frames in work.
#include <algorithm>
#include <string>
#include <utility>

#include "common/base/byte_text.h"
#include "common/base/log.h"
#include "master/cluster/cluster.h"

namespace tessera::master {
namespace {

// Interval at which data that yields is looked at; a window of 64 KiB takes as long at 100 Mbit/s.
constexpr std::chrono::milliseconds kGentleLook{5};

// The memory that a slave which has nothing of the scene takes for it.
std::uint64_t bytes_to_hold(const EncodedScene& scene) {
  return 2 * scene.total_bytes() + scene.index_bytes;
}

}  // namespace

void Cluster::commit_scene(SceneVersion version, SharedScene scene) {
  scenes_[version] = scene;
  std::erase_if(scenes_, [&](const auto& entry) {  // older ones, unless a frame shows them
    return entry.first < version && !needed_.contains(entry.first);
  });
  for (auto& [session, slave] : slaves_) {
    if (slave->is_joined()) offer(session, version, scene);
  }
}

void Cluster::need_scene(SceneVersion version) {
  needed_.insert(version);
  for (auto& [session, slave] : slaves_) {
    if (slave->is_joined()) slave->sender->need(version);
  }
}

void Cluster::retire_scenes(SceneVersion first_kept, bool keeps_newest) {
  scenes_.erase(scenes_.begin(), scenes_.lower_bound(first_kept));
  needed_.erase(needed_.begin(), needed_.lower_bound(first_kept));
  relay_.retire(first_kept);
  for (auto& [session, slave] : slaves_) {
    if (slave->is_joined()) slave->sender->retire(first_kept, keeps_newest);
  }
}

void Cluster::offer(SessionId session, SceneVersion version, const SharedScene& scene) {
  SlaveEntry& slave = *slaves_.at(session);
  const auto unfit = unfit_.find(slave.hello.name);
  const bool is_hopeless = unfit != unfit_.end() &&
                           slave.hello.memory_bytes <= unfit->second.memory_bytes &&
                           bytes_to_hold(*scene) >= unfit->second.scene_bytes;
  if (!is_hopeless) return slave.sender->commit(version, scene);
  not_offered_.emplace_back(session, version);
  not_offered_timer_.start_once(std::chrono::milliseconds(0), [this] {
    for (const auto& [who, what] : std::exchange(not_offered_, {})) {
      const auto found = scenes_.find(what);
      if (found == scenes_.end() || !slaves_.contains(who)) continue;
      events_.scene_failed(who, what, cannot_hold_text(*found->second));
    }
  });
}

void Cluster::on_scene_failed(SessionId session, wire::SceneFailed failed) {
  SlaveEntry& slave = *slaves_.at(session);
  const auto scene = scenes_.find(failed.version);
  if (scene == scenes_.end()) return slave.sender->on_answered(failed.version);  // retired
  log_warn("scene-failed", failed.reason, {{"slave", slave.hello.name}});
  if (failed.needed_bytes > 0) {
    if (unfit_.size() >= kUnfitMax) unfit_.clear();
    unfit_[slave.hello.name] = {bytes_to_hold(*scene->second), slave.hello.memory_bytes};
    failed.reason = cannot_hold_text(*scene->second);
  }
  relay_.gave_up(session, failed.version);
  slave.sender->on_answered(failed.version);
  events_.scene_failed(session, failed.version, failed.reason);
}

std::string Cluster::cannot_hold_text(const EncodedScene& scene) const {
  const SlaveEntry* largest = nullptr;
  for (const auto& [session, slave] : slaves_) {
    if (!slave->is_joined()) continue;
    if (largest == nullptr || slave->hello.memory_bytes > largest->hello.memory_bytes) {
      largest = slave.get();
    }
  }
  std::string text = "it needs about " + mib_text(bytes_to_hold(scene)) + " of free memory";
  if (largest != nullptr && largest->hello.memory_bytes > 0) {
    text += "; the largest slave, '" + largest->hello.name + "', may take " +
            mib_text(largest->hello.memory_bytes) + " in all";
  }
  return text + ". Add a slave with more memory, or make the scene smaller";
}

// Follows which frames slaves have in work, from the messages that are sent to them.
void Cluster::watch_frames(SessionId session, const wire::Message& message) {
  if (const auto* begin = std::get_if<wire::FrameBegin>(&message)) {
    open_frames_.emplace(session, begin->frame);
  } else if (const auto* end = std::get_if<wire::FrameEnd>(&message)) {
    open_frames_.erase({session, end->frame});
  }
}

// Whether other slaves render while this one, which has just come, still lacks the scene. A slave
// that has once kept up is late only by a moment when the next scene is ready elsewhere; if its
// data yielded, it would stay late.
bool Cluster::is_behind(SessionId session) const {
  if (open_frames_.empty() || !slaves_.at(session)->sender->is_joining()) return false;
  const auto own = open_frames_.lower_bound({session, 0});
  return own == open_frames_.end() || own->first != session;
}

void Cluster::set_pace(SessionId session) {
  const bool is_gentle = is_behind(session);
  slaves_.at(session)->sender->set_gentle(is_gentle);
  if (!is_gentle || std::exchange(is_pumping_gently_, true)) return;
  gentle_pump_.start_repeating(kGentleLook, [this] { pump_gently(); });
}

void Cluster::pump_gently() {
  bool is_any_held = false;
  for (auto& [session, slave] : slaves_) {
    if (!slave->is_joined() || !slave->sender->has_uploads()) continue;
    slave->sender->set_gentle(is_behind(session));
    slave->sender->pump();
    is_any_held |= is_behind(session) && slave->sender->has_uploads();
  }
  if (is_any_held) return;
  is_pumping_gently_ = false;
  gentle_pump_.cancel();
}

}  // namespace tessera::master
