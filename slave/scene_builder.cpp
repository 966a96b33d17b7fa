// SPDX-License-Identifier: Apache-2.0
#include "slave/scene_builder.h"

#include <exception>
#include <utility>

#include "common/base/clock.h"

namespace tessera::slave {

SceneBuilder::SceneBuilder(const core::BuildOptions& options, OnBuilt on_built)
    : SceneBuilder(options, std::move(on_built), BuildPace(options.threads)) {}

SceneBuilder::SceneBuilder(const core::BuildOptions& options, OnBuilt on_built,
                           const BuildPace& pace)
    : build_options_(options), on_built_(std::move(on_built)), gate_(pace, is_cancelled_) {
  build_options_.is_cancelled = &is_cancelled_;
  thread_ = std::thread([this] { work(); });
}

SceneBuilder::~SceneBuilder() { stop(); }

bool SceneBuilder::try_push(BuildTask task) {
  {
    MutexLock lock(mutex_);
    if (!order_.try_push(std::move(task))) return false;
    if (order_.is_to_stop()) cancel();
  }
  has_next_.notify_one();
  return true;
}

void SceneBuilder::retire(std::uint64_t generation, SceneVersion first_kept) {
  MutexLock lock(mutex_);
  order_.retire(generation, first_kept);
  if (order_.is_to_stop()) cancel();
}

void SceneBuilder::cancel() {
  is_cancelled_ = true;
  gate_.wake();
}

void SceneBuilder::stop() {
  if (!thread_.joinable()) return;
  {
    MutexLock lock(mutex_);
    is_stopped_ = true;
    cancel();
  }
  has_next_.notify_one();
  thread_.join();
}

const BuildTask* SceneBuilder::begin_next() {
  MutexLock lock(mutex_);
  while (!order_.has_next() && !is_stopped_) has_next_.wait(mutex_);
  if (is_stopped_) return nullptr;
  is_cancelled_ = false;
  return &order_.start_next();
}

void SceneBuilder::work() {
  while (const BuildTask* task = begin_next()) run(*task);
}

void SceneBuilder::run(const BuildTask& task) {
  const TimePoint began = Clock::now();
  BuildOutcome outcome = [this, &task] {
    const WorkGate::Visit visit(&gate_);
    return build(task);
  }();
  outcome.seconds = seconds(Clock::now() - began);
  const bool was_stopped =
      !outcome.scene.is_ok() && outcome.scene.status().code() == StatusCode::kCancelled;
  {
    MutexLock lock(mutex_);
    if (is_stopped_ || !order_.finish(was_stopped)) return;
  }
  on_built_(std::move(outcome));
}

BuildOutcome SceneBuilder::build(const BuildTask& task) {
  BuildOutcome outcome{task.generation, task.version, 0, Status::cancelled("not built yet")};
  try {
    give_way();
    Result<Scene> scene = decoder_.decode(task.scene);
    if (!scene.is_ok()) {
      outcome.scene = scene.status();
      return outcome;
    }
    give_way();
    Result<Scene> posed = poser_.at(*scene, task.scene.time_seconds);
    if (!posed.is_ok()) {
      outcome.scene = posed.status();
      return outcome;
    }
    give_way();
    const std::shared_ptr<const Newest> before = newest();
    core::BuildOptions options = build_options_;
    options.other = before ? before->prepared.get() : nullptr;
    outcome.scene = core::PreparedScene::build(*posed, options);
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

std::shared_ptr<const SceneBuilder::Newest> SceneBuilder::newest() const {
  MutexLock lock(mutex_);
  return newest_;
}

void SceneBuilder::forget_newest() {
  std::shared_ptr<const Newest> forgotten;
  MutexLock lock(mutex_);
  forgotten.swap(newest_);
}

}  // namespace tessera::slave
