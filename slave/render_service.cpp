// SPDX-License-Identifier: Apache-2.0
#include "slave/render_service.h"

#include <algorithm>
#include <cstdlib>
#include <cstring>
#include <exception>
#include <utility>

#include "common/base/limits.h"
#include "common/base/log.h"
#include "common/frame/frame_image.h"
#include "slave/core/integrate/planes/plane_tile.h"
#include "slave/core/integrate/tile_renderer.h"
#include "slave/slave_metrics.h"

namespace tessera::slave {

// Scratch of one render thread.
class RenderService::Worker {
 public:
  std::uint32_t index = 0;  // among the render threads
  core::TileRenderer renderer;
  core::PlaneTile planes;
  std::vector<float> rgb, plane_values;
};

RenderService::RenderService(int threads, TestHooks hooks, PixelCoder& coder, OnDone on_done,
                             TileQueue::OnWaiting on_idle)
    : hooks_(hooks),
      coder_(coder),
      on_done_(std::move(on_done)),
      queue_(kTilesLeasedMax, std::move(on_idle)) {
  {
    MutexLock lock(mutex_);
    workers_running_ = threads;
  }
  for (int i = 0; i < threads; ++i)
    threads_.emplace_back([this, i] { work(static_cast<std::uint32_t>(i)); });
}

RenderService::~RenderService() {
  stop(std::chrono::milliseconds(0), [] {});
}

void RenderService::stop(std::chrono::milliseconds patience, const std::function<void()>& give_up) {
  if (threads_.empty()) return;
  queue_.close();
  bool is_patient = true;
  {
    const TimePoint deadline = Clock::now() + patience;
    MutexLock lock(mutex_);
    while (workers_running_ > 0 && is_patient) {
      is_patient = worker_ended_.wait_until(mutex_, deadline);
    }
  }
  if (!is_patient) give_up();
  for (std::thread& thread : threads_) thread.join();
  threads_.clear();
}

void RenderService::work(std::uint32_t index) {
  {
    Worker worker;
    worker.index = index;
    while (std::optional<TileJob> job = queue_.pop()) {
      std::optional<wire::TileResult> result;
      // A tile is left once at most, so that no thread runs in circles.
      core::MetBuilds met(job->has_come_back ? core::MetBuilds::WhenBusy::kWait
                                             : core::MetBuilds::WhenBusy::kLeaveTile);
      try {
        if (!job->frame->is_cancelled) result = render(*job, worker);
      } catch (const std::exception& e) {
        log_error("tile-failed", std::string("a tile could not be rendered: ") + e.what(), {});
      }
      if (met.has_left() && met.failure().is_ok() && put_back(*job)) continue;
      if (met.has_left() || !met.failure().is_ok()) result.reset();
      job->frame->failure.add(met.failure());
      on_done_(*job, std::move(result));
    }
  }
  MutexLock lock(mutex_);
  --workers_running_;
  worker_ended_.notify_all();
}

bool RenderService::put_back(TileJob job) {
  job.has_come_back = true;
  return queue_.try_push(std::move(job));
}

std::optional<wire::TileResult> RenderService::render(const TileJob& job, Worker& worker) {
  const TimePoint began = Clock::now();
  const wire::FrameBegin& begin = job.frame->begin;
  const TileRect rect = job.frame->grid.rect(job.tile);
  const std::size_t floats = 3 * static_cast<std::size_t>(rect.pixel_count());
  if (worker.rgb.size() < floats) worker.rgb.resize(floats);
  const std::span<float> rgb(worker.rgb.data(), floats);

  wire::TileResult result;
  const int ordinal = ++tiles_begun_;
  if (ordinal == hooks_.tile_aborted_at) std::abort();
  const bool is_poison = begin.frame == static_cast<FrameId>(hooks_.frame_aborted_in) &&
                         job.tile == static_cast<TileIndex>(hooks_.tile_aborted_in);
  if (is_poison && hooks_.tile_aborted_in >= 0) {
    std::this_thread::sleep_for(std::chrono::milliseconds(hooks_.abort_after_ms));
    std::abort();
  }
  const bool is_frozen = hooks_.tile_frozen_at > 0 && ordinal >= hooks_.tile_frozen_at;
  while (is_frozen && !job.frame->is_cancelled)
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
  if (hooks_.tile_sleep_ms > 0) {
    const TimePoint until = began + std::chrono::milliseconds(hooks_.tile_sleep_ms);
    while (Clock::now() < until && !job.frame->is_cancelled) {
      std::this_thread::sleep_for(
          std::min<Duration>(until - Clock::now(), std::chrono::milliseconds(5)));
    }
  }
  result.rays = worker.renderer.render(*job.frame->scene, begin.settings, begin.isa, rect, rgb,
                                       &job.frame->is_cancelled, &job.frame->light);
  const PixelLayout layout(begin.settings);
  const auto pixel_count = static_cast<std::size_t>(rect.pixel_count());
  result.pixels.resize(pixel_count * layout.pixel_bytes());
  const auto pixels = std::span(result.pixels);
  const std::size_t colour_bytes = pixel_count * layout.colour_bytes();
  if (!begin.settings.planes.is_empty()) {
    worker.plane_values.resize(pixel_count * channel_count(begin.settings.planes));
    result.rays += worker.planes.render(*job.frame->scene, begin.settings, begin.isa, rect,
                                        worker.plane_values, &job.frame->is_cancelled);
    std::memcpy(pixels.data() + colour_bytes, worker.plane_values.data(),
                pixels.size() - colour_bytes);
  }
  if (job.frame->is_cancelled) return std::nullopt;
  if (hooks_.tile_wrong_every > 0 && ordinal % hooks_.tile_wrong_every == 0) rgb[0] += 0.5F;
  encode_pixels(rgb, layout.format(), pixels.first(colour_bytes), begin.settings.display);
  coder_.code(begin, result);
  result.frame = begin.frame;
  result.version = begin.version;
  result.tile = job.tile;
  result.attempt = job.attempt;
  result.seconds = seconds(Clock::now() - began);
  result.began_ns = nanoseconds(began);
  result.worker = worker.index;
  result.starved_seconds = queue_.take_starved_seconds();
  SlaveMetrics& cells = slave_metrics();
  cells.tile_seconds.observe(result.seconds);
  cells.starved_seconds.add(result.starved_seconds);
  cells.rays_primary.add(result.rays.primary);
  cells.rays_shadow.add(result.rays.shadow);
  cells.rays_secondary.add(result.rays.secondary);
  return result;
}

}  // namespace tessera::slave
