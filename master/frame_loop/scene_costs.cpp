// SPDX-License-Identifier: Apache-2.0
#include "master/frame_loop/scene_costs.h"

#include <algorithm>
#include <utility>

namespace tessera::master {

void SceneCosts::built(SceneVersion version, double build_seconds, std::uint64_t primitives) {
  Build& build = builds_[version];
  build.seconds = std::max(build.seconds, build_seconds);
  build.primitives = std::max(build.primitives, primitives);
}

void SceneCosts::retire(SceneVersion first_kept) {
  const auto kept = builds_.lower_bound(first_kept);
  for (auto old = builds_.begin(); old != kept; ++old)
    owed_primitives_ += old->second.primitives - old->second.charged;
  builds_.erase(builds_.begin(), kept);
}

void SceneCosts::look(bool is_waiting, TimePoint now) {
  if (is_waiting && !waiting_since_) waiting_since_ = now;
  if (is_waiting || !waiting_since_) return;
  waited_seconds_ += seconds(now - *waiting_since_);
  waiting_since_.reset();
}

void SceneCosts::charge(FrameStats& stats, std::uint64_t scene_bytes_sent) {
  if (const auto build = builds_.find(stats.scene_version); build != builds_.end())
    stats.build_seconds = build->second.seconds;
  SceneCost& cost = stats.scene_cost;
  cost.built_primitives = std::exchange(owed_primitives_, 0);
  for (auto& [version, build] : builds_)
    cost.built_primitives += build.primitives - std::exchange(build.charged, build.primitives);
  cost.wait_seconds = std::exchange(waited_seconds_, 0);
  cost.bytes = scene_bytes_sent - std::exchange(bytes_charged_, scene_bytes_sent);
}

}  // namespace tessera::master
