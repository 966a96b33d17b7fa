// SPDX-License-Identifier: Apache-2.0
#include "master/commands/scene_reload.h"

#include <utility>

#include "common/base/clock.h"
#include "master/commands/animation_choice.h"

namespace tessera::master {
namespace {

// Between two looks: a file that is written in pieces is not read before it has been left alone for
// so long, and a person who has saved it hardly waits.
constexpr double kLookSeconds = 0.25;

}  // namespace

SceneReload::SceneReload(const MasterOptions& options, const std::optional<FileLook>& first)
    : options_(options), watch_(first) {
  if (!options.scene.starts_with("builtin:")) thread_ = std::thread([this] { work(); });
}

SceneReload::~SceneReload() {
  {
    MutexLock lock(mutex_);
    is_stopped_ = true;
  }
  stopped_.notify_all();
  if (thread_.joinable()) thread_.join();
}

bool SceneReload::is_stopped() const {
  MutexLock lock(mutex_);
  return is_stopped_;
}

void SceneReload::work() {
  while (true) {
    const TimePoint next_look = Clock::now() + from_seconds(kLookSeconds);
    {
      MutexLock lock(mutex_);
      while (!is_stopped_ && stopped_.wait_until(mutex_, next_look)) continue;
      if (is_stopped_) return;
    }
    if (watch_.is_changed(look_at_file(options_.scene))) newest_.put(read());
  }
}

Result<LoadedScene> SceneReload::read() const {
  const auto goes_on = [this](const std::string&, double) { return !is_stopped(); };
  auto loaded = load_scene(options_.scene, goes_on, options_.import_limits);
  if (!loaded.is_ok()) return loaded;
  const auto played = choose_animation(loaded->scene, options_.animation);
  if (!played.is_ok()) return played.status();
  return loaded;
}

}  // namespace tessera::master
