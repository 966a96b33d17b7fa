// SPDX-License-Identifier: Apache-2.0
// The network thread: one Asio loop in one thread, in real time. Sockets need an IoThread; the code
// above them takes any EventLoop.
//
// Asio does not appear in any header outside common/net; inside, io_thread_asio.h gives the
// context.
#pragma once

#include <functional>
#include <memory>
#include <string>

#include "common/net/event_loop.h"

namespace tessera::net {

class IoThread final : public EventLoop {
 public:
  explicit IoThread(std::string thread_name);
  // Stops and joins. Requires: not called on the thread itself.
  ~IoThread() override;
  IoThread(const IoThread&) = delete;
  IoThread& operator=(const IoThread&) = delete;

  void post(std::function<void()> task) override;
  void run_and_wait(std::function<void()> task) override;
  bool is_current() const override;
  std::unique_ptr<TimerBackend> make_timer() override;

  // Ends the loop after the tasks posted so far, and joins; later tasks are dropped, so that who
  // waits for one in run_and_wait() at the same time goes on. Safe to call twice, by one thread.
  void stop();

  struct Impl;
  Impl& impl() { return *impl_; }

 private:
  std::unique_ptr<Impl> impl_;
};

}  // namespace tessera::net
