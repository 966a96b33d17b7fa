// SPDX-License-Identifier: Apache-2.0
#include "master/frame_loop/scene_moments.h"

#include <utility>

namespace tessera::master {

SceneMoments::Moment SceneMoments::commit(SceneVersion version, SharedScene scene) {
  Committed& committed = committed_[version];
  committed.scene = std::move(scene);
  return show(version, committed, 0);
}

std::optional<SceneMoments::Moment> SceneMoments::at(SceneVersion version, double seconds) {
  const auto found = committed_.find(version);
  if (found == committed_.end()) return std::nullopt;
  Committed& committed = found->second;
  const double time = committed.scene->is_animated() ? seconds : 0;
  if (const auto known = committed.numbers.find(time); known != committed.numbers.end())
    return Moment{known->second, nullptr};
  return show(version, committed, time);
}

SceneMoments::Moment SceneMoments::show(SceneVersion version, Committed& committed,
                                        double seconds) {
  Moment moment{++newest_number_, committed.scene};
  if (seconds != committed.scene->time_seconds) {
    auto scene = std::make_shared<EncodedScene>(*committed.scene);
    scene->time_seconds = seconds;
    moment.scene = std::move(scene);
  }
  committed.numbers[seconds] = moment.number;
  versions_[moment.number] = version;
  return moment;
}

void SceneMoments::retire(SceneVersion first_kept) {
  versions_.erase(versions_.begin(), versions_.lower_bound(first_kept));
  for (auto scene = committed_.begin(); scene != committed_.end();) {
    std::erase_if(scene->second.numbers,
                  [first_kept](const auto& entry) { return entry.second < first_kept; });
    const bool is_newest = std::next(scene) == committed_.end();
    scene =
        scene->second.numbers.empty() && !is_newest ? committed_.erase(scene) : std::next(scene);
  }
}

void SceneMoments::clear() {
  committed_.clear();
  versions_.clear();
}

}  // namespace tessera::master
