// SPDX-License-Identifier: Apache-2.0
#include "slave/scene_builder.h"

#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <exception>
#include <system_error>
#include <utility>

#include "common/base/clock.h"

namespace tessera::slave {

namespace {

// Threads that a build starts inherit the priority. At nice 10 a thread gets about a tenth of the
// time of a render thread with which it shares a processor. It does no harm if this fails.
void lower_priority(int thread) {
  constexpr int kNice = 10;
  const auto who = static_cast<id_t>(thread);
  (void)setpriority(PRIO_PROCESS, who, std::max(kNice, getpriority(PRIO_PROCESS, who)));
}

}  // namespace

SceneBuilder::SceneBuilder(const core::BuildOptions& options, OnBuilt on_built)
    : build_options_(options), on_built_(std::move(on_built)) {
  build_options_.is_cancelled = &is_cancelled_;
  thread_ = std::thread([this] { work(); });
}

SceneBuilder::~SceneBuilder() { stop(); }

bool SceneBuilder::try_push(BuildTask task) {
  {
    MutexLock lock(mutex_);
    if (!order_.try_push(std::move(task))) return false;
    if (order_.is_to_stop()) is_cancelled_ = true;
  }
  has_next_.notify_one();
  return true;
}

void SceneBuilder::retire(std::uint64_t generation, SceneVersion first_kept) {
  MutexLock lock(mutex_);
  order_.retire(generation, first_kept);
  if (order_.is_to_stop()) is_cancelled_ = true;
}

void SceneBuilder::stop() {
  if (!thread_.joinable()) return;
  {
    MutexLock lock(mutex_);
    is_stopped_ = true;
    is_cancelled_ = true;
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

void SceneBuilder::set_rendering(bool is_rendering) {
  MutexLock lock(mutex_);
  is_rendering_ = is_rendering;
  if (is_rendering_ && build_thread_ != 0) lower_priority(build_thread_);
}

// A thread whose priority was lowered cannot get it back, so each build has its own.
void SceneBuilder::work() {
  while (const BuildTask* task = begin_next()) {
    try {
      std::jthread([this, task] { run(*task); });
    } catch (const std::system_error&) {
      run(*task);  // the system has no more threads
    }
  }
}

void SceneBuilder::run(const BuildTask& task) {
  {
    MutexLock lock(mutex_);
    build_thread_ = gettid();
    if (is_rendering_) lower_priority(build_thread_);
  }
  const TimePoint began = Clock::now();
  BuildOutcome outcome = build(task);
  outcome.seconds = seconds(Clock::now() - began);
  const bool was_stopped =
      !outcome.scene.is_ok() && outcome.scene.status().code() == StatusCode::kCancelled;
  {
    MutexLock lock(mutex_);
    build_thread_ = 0;
    if (is_stopped_ || !order_.finish(was_stopped)) return;
  }
  on_built_(std::move(outcome));
}

BuildOutcome SceneBuilder::build(const BuildTask& task) {
  BuildOutcome outcome{task.generation, task.version, 0, Status::cancelled("not built yet")};
  try {
    Result<Scene> scene = decoder_.decode(task.scene);
    if (!scene.is_ok()) {
      outcome.scene = scene.status();
      return outcome;
    }
    Result<Scene> posed = poser_.at(*scene, task.scene.time_seconds);
    if (!posed.is_ok()) {
      outcome.scene = posed.status();
      return outcome;
    }
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
