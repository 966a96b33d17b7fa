// SPDX-License-Identifier: Apache-2.0
#include "tests/sim/sim_workshop.h"

#include <algorithm>
#include <utility>

#include "common/base/limits.h"
#include "tests/sim/picture.h"

namespace tessera::sim {
namespace {

constexpr std::chrono::milliseconds kThaw{
    10};  // frozen threads look so often whether they may go on

}  // namespace

SimWorkshop::SimWorkshop(Process& process, WorkModel model)
    : process_(process), model_(std::move(model)), is_frozen_(model_.is_frozen_for_good) {
  account_waiting();
}

bool SimWorkshop::try_push(slave::TileJob job) {
  if (jobs_.size() >= static_cast<std::size_t>(kTilesLeasedMax)) return false;
  jobs_.push_back(std::move(job));
  start_work();
  return true;
}

void SimWorkshop::account_waiting() {
  starvation_.set_waiting(model_.threads - static_cast<int>(running_.size()),
                          process_.queue().now());
}

void SimWorkshop::start_work() {
  while (!jobs_.empty() && running_.size() < static_cast<std::size_t>(model_.threads)) {
    running_.push_back({std::move(jobs_.front()), process_.queue().now()});
    jobs_.pop_front();
    account_waiting();
    const RunIterator run = std::prev(running_.end());
    const std::uint64_t id = run_ids_[&*run] = ++next_run_;
    if (model_.on_begin) model_.on_begin(run->job.tile);
    const bool is_dropped = run->job.frame->is_cancelled;
    const double cost = is_dropped ? 0 : model_.tile_seconds(*run->job.frame, run->job.tile);
    process_.run_at(process_.queue().now() + from_seconds(cost), Duration::zero(),
                    [this, run, id, at = &*run] {
                      const auto found = run_ids_.find(at);
                      if (found != run_ids_.end() && found->second == id) finish(run);
                    });
  }
}

void SimWorkshop::finish(RunIterator run) {
  if (model_.is_frozen_for_good) return;  // nobody needs to look
  if (is_frozen_) {
    const std::uint64_t id = run_ids_[&*run];
    process_.run_at(process_.queue().now() + kThaw, Duration::zero(), [this, run, id, at = &*run] {
      const auto found = run_ids_.find(at);
      if (found != run_ids_.end() && found->second == id) finish(run);
    });
    return;
  }
  const Run done = std::move(*run);
  run_ids_.erase(&*run);
  running_.erase(run);
  busy_seconds_ += seconds(process_.queue().now() - done.began);
  account_waiting();
  std::optional<wire::TileResult> result;
  const bool is_failed = !done.job.frame->failure.get().is_ok();
  if (!done.job.frame->is_cancelled && !is_failed) result = render(done);
  start_work();  // a render thread takes the next tile before the network thread sees this one
  node_->on_tile_done(done.job, std::move(result));
}

wire::TileResult SimWorkshop::render(const Run& run) {
  const wire::FrameBegin& begin = run.job.frame->begin;
  const TileRect rect = run.job.frame->grid.rect(run.job.tile);
  wire::TileResult result;
  result.frame = begin.frame;
  result.version = begin.version;
  result.tile = run.job.tile;
  result.attempt = run.job.attempt;
  result.seconds = seconds(process_.queue().now() - run.began);
  result.starved_seconds = starvation_.take(process_.queue().now());
  starved_total_ += result.starved_seconds;
  result.rays.primary = static_cast<std::uint64_t>(rect.pixel_count());
  result.pixels.resize(static_cast<std::size_t>(rect.pixel_count()) *
                       static_cast<std::size_t>(bytes_per_pixel(begin.settings.pixel_format)));
  if (model_.has_pixels) {
    draw(shown_by(*run.job.frame->scene), begin.settings, rect, result.pixels);
  }
  if (model_.alter) model_.alter(result);
  return result;
}

// Tiles of a cancelled frame end early.
void SimWorkshop::drop_cancelled() {
  for (auto run = running_.begin(); run != running_.end(); ++run) {
    if (!run->job.frame->is_cancelled) continue;
    const std::uint64_t id = run_ids_[&*run];
    process_.post([this, run, id, at = &*run] {
      const auto found = run_ids_.find(at);
      if (found != run_ids_.end() && found->second == id) finish(run);
    });
  }
}

void SimWorkshop::remove_frame(const slave::FrameWork* frame) {
  std::erase_if(jobs_, [frame](const slave::TileJob& job) { return job.frame.get() == frame; });
  drop_cancelled();
}

std::deque<slave::TileJob> SimWorkshop::remove_all() {
  drop_cancelled();
  return std::exchange(jobs_, {});
}

void SimWorkshop::set_open_frames(std::size_t frames) {
  starvation_.set_open_frames(static_cast<int>(frames), process_.queue().now());
}

bool SimWorkshop::try_push(slave::BuildTask task) {
  if (model_.on_scene) model_.on_scene(task.version, task.scene);
  if (!builds_.try_push(std::move(task))) return false;
  if (building_ == nullptr) build_next();
  stop_build_if_due();
  return true;
}

void SimWorkshop::retire(std::uint64_t generation, SceneVersion first_kept) {
  builds_.retire(generation, first_kept);
  stop_build_if_due();
}

void SimWorkshop::build_next() {
  if (!builds_.has_next()) return;
  building_ = &builds_.start_next();
  const std::uint64_t build = ++build_;
  process_.run_at(process_.queue().now() + from_seconds(model_.build_seconds), Duration::zero(),
                  [this, build] {
                    if (build == build_ && building_ != nullptr) end_build(false);
                  });
}

// A build, which is on another thread, ends a little after it is told to.
void SimWorkshop::stop_build_if_due() {
  if (building_ == nullptr || !builds_.is_to_stop()) return;
  const std::uint64_t build = build_;
  process_.run_at(process_.queue().now(), Duration::zero(), [this, build] {
    if (build == build_ && building_ != nullptr) end_build(true);
  });
}

Result<std::shared_ptr<const core::PreparedScene>> SimWorkshop::prepare(
    const slave::BuildTask& task) {
  if (model_.builds) return preparation_.prepare(task, *model_.builds).scene;
  const Result<Shown> shown = shown_by(task.scene);
  if (!shown.is_ok()) return shown.status();
  return prepared_for(*shown);
}

void SimWorkshop::end_build(bool was_stopped) {
  using Built = Result<std::shared_ptr<const core::PreparedScene>>;
  const slave::BuildTask& task = *std::exchange(building_, nullptr);
  slave::BuildOutcome outcome{task.generation, task.version, was_stopped ? 0 : model_.build_seconds,
                              Built(Status::cancelled("stopped before it was built"))};
  if (model_.fails_builds) {
    outcome.scene = Built(Status::resource_exhausted("no memory for it"));
  } else if (!was_stopped) {
    outcome.scene = prepare(task);
  }
  const bool is_answered = builds_.finish(was_stopped);
  build_next();
  if (is_answered) node_->on_built(std::move(outcome));
}

}  // namespace tessera::sim
