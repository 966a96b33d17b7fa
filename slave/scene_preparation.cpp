// SPDX-License-Identifier: Apache-2.0
#include "slave/scene_preparation.h"

#include <exception>
#include <string>
#include <utility>

#include "common/base/work_gate.h"

namespace tessera::slave {

BuildOutcome ScenePreparation::prepare(const BuildTask& task, core::BuildOptions options) {
  BuildOutcome outcome{task.generation, task.version, 0, Status::cancelled("not built yet")};
  try {
    give_way();
    auto scene = decoder_.decode_shared(task.scene);
    if (!scene.is_ok()) {
      outcome.scene = scene.status();
      return outcome;
    }
    give_way();
    auto posed = posed_at(*scene, task.scene.time_seconds);
    if (!posed.is_ok()) {
      outcome.scene = posed.status();
      return outcome;
    }
    give_way();
    const std::shared_ptr<const Newest> before = newest();
    options.other = before ? before->prepared.get() : nullptr;
    outcome.scene = core::PreparedScene::build(**posed, options);
    if (!outcome.scene.is_ok()) return outcome;
    const core::PreparedScene& built = **outcome.scene;
    if (!before || !built.has_geometry_of(*before->prepared))
      outcome.built_primitives = built.built_primitives() + built.fitted_primitives();
    auto now = std::make_shared<const Newest>(
        Newest{*std::move(scene), *std::move(posed), *outcome.scene});
    MutexLock lock(mutex_);
    newest_ = std::move(now);  // `before` ends outside of the lock
  } catch (const std::exception& e) {
    outcome.scene =
        Status::resource_exhausted(std::string("the scene could not be built: ") + e.what());
  }
  return outcome;
}

Result<std::shared_ptr<const Scene>> ScenePreparation::posed_at(
    const std::shared_ptr<const Scene>& scene, double seconds) {
  if (!scene->animation) return scene;
  Result<Scene> posed = poser_.at(*scene, seconds);
  if (!posed.is_ok()) return posed.status();
  return std::make_shared<const Scene>(*std::move(posed));
}

std::shared_ptr<const ScenePreparation::Newest> ScenePreparation::newest() const {
  MutexLock lock(mutex_);
  return newest_;
}

void ScenePreparation::forget_newest() {
  std::shared_ptr<const Newest> forgotten;
  MutexLock lock(mutex_);
  forgotten.swap(newest_);
}

}  // namespace tessera::slave
