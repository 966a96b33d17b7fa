// SPDX-License-Identifier: Apache-2.0
// The Asio side of IoThread, for common/net alone.
// Threads. As io_thread.h says. No header outside this folder includes it, so that Asio stays here.
#pragma once

#include <asio.hpp>
#include <atomic>
#include <thread>

#include "common/net/io_thread.h"

namespace tessera::net {

struct IoThread::Impl {
  asio::io_context context{1};
  asio::executor_work_guard<asio::io_context::executor_type> work{context.get_executor()};
  std::thread thread;
  std::atomic<bool> is_stopped{false};
};

inline asio::io_context& context_of(IoThread& io) { return io.impl().context; }

}  // namespace tessera::net
