// SPDX-License-Identifier: Apache-2.0
#include "slave/scene_builder.h"

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
    return preparation_.prepare(task, build_options_);
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

}  // namespace tessera::slave
