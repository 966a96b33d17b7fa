// SPDX-License-Identifier: Apache-2.0
// The Asio side of IoThread, for common/net alone.
// Threads. As io_thread.h says. No header outside this folder includes it, so that Asio stays here.
#pragma once

#include <asio.hpp>
#include <atomic>
#include <functional>
#include <thread>
#include <utility>

#include "common/base/mutex.h"
#include "common/net/io_thread.h"

namespace tessera::net {

struct IoThread::Impl {
  asio::io_context context{1};
  asio::executor_work_guard<asio::io_context::executor_type> work{context.get_executor()};
  std::thread thread;                 // its owner's
  std::atomic<std::thread::id> id{};  // of the thread while it runs the loop
  Mutex gate;                         // held to post: a task is before the last one, or dropped
  bool is_stopped TESSERA_GUARDED_BY(gate) = false;

  // Returns: false where the loop has ended, or ends; the task is dropped then.
  bool post(std::function<void()> task) TESSERA_EXCLUDES(gate) {
    MutexLock lock(gate);
    if (is_stopped) return false;
    asio::post(context, std::move(task));
    return true;
  }
};

inline asio::io_context& context_of(IoThread& io) { return io.impl().context; }

}  // namespace tessera::net
