// SPDX-License-Identifier: Apache-2.0
// The render threads of one slave. Each takes a tile from the queue, renders it, encodes its pixels
// straight into the payload that travels, and hands it over.
//
// Threads. Owned by the node. Everything but stop() from any thread; stop() from the owner's.
// Invariants. (1) Each job pushed leaves exactly once: rendered, cancelled (on_done with no result)
// or taken out by remove_*(). (2) on_done runs on a render thread and must not block.
#pragma once

#include <atomic>
#include <chrono>
#include <functional>
#include <optional>
#include <thread>
#include <vector>

#include "common/base/mutex.h"
#include "slave/pixel_coder.h"
#include "slave/test_hooks.h"
#include "slave/tile_queue.h"

namespace tessera::slave {

class RenderService {
 public:
  using OnDone = std::function<void(const TileJob&, std::optional<wire::TileResult>)>;

  // `coder` outlives the service. `on_idle` is told how many render threads have no tile, under a
  // lock; may be null.
  RenderService(int threads, TestHooks hooks, PixelCoder& coder, OnDone on_done,
                TileQueue::OnWaiting on_idle = nullptr);
  ~RenderService();  // stop()

  TileQueue& queue() { return queue_; }

  // Takes no more jobs and waits at most `patience` for the tiles being rendered; then calls
  // `give_up`, which must cancel their frames, and joins. Requires: the queued jobs were taken out.
  void stop(std::chrono::milliseconds patience, const std::function<void()>& give_up);

 private:
  class Worker;
  void work(std::uint32_t index);
  // Puts a tile behind the others of its frame that wait. Returns: false when the queue is closed.
  bool put_back(TileJob job);
  std::optional<wire::TileResult> render(const TileJob& job, Worker& worker);

  const TestHooks hooks_;
  std::atomic<int> tiles_begun_ = 0;
  PixelCoder& coder_;
  const OnDone on_done_;
  TileQueue queue_;

  Mutex mutex_;
  CondVar worker_ended_;
  int workers_running_ TESSERA_GUARDED_BY(mutex_) = 0;

  std::vector<std::thread> threads_;
};

}  // namespace tessera::slave
