// The network thread: one Asio loop in one thread. Everything in common/net, and every protocol
// object built on it, belongs to exactly one IoThread and is touched on it alone.
//
// Asio does not appear in any header outside common/net; inside, io_thread_asio.h gives the
// context.
#pragma once

#include <chrono>
#include <functional>
#include <memory>
#include <string>

namespace tessera::net {

class IoThread {
 public:
  explicit IoThread(std::string thread_name);
  // Stops and joins. Requires: not called on the thread itself.
  ~IoThread();
  IoThread(const IoThread&) = delete;
  IoThread& operator=(const IoThread&) = delete;

  // Runs `task` on the thread, in order of posting. Any thread. After stop() tasks are dropped.
  void post(std::function<void()> task);

  // Runs `task` on the thread and waits for it. Any other thread; runs directly on the thread
  // itself.
  void run_and_wait(std::function<void()> task);

  bool is_current() const;

  // Ends the loop after the tasks posted so far, and joins. Safe to call twice. Any other thread.
  void stop();

  struct Impl;
  Impl& impl() { return *impl_; }

 private:
  std::unique_ptr<Impl> impl_;
};

// One-shot or repeating timer. Io thread only; destroying it cancels it, and the callback never
// runs after.
class Timer {
 public:
  explicit Timer(IoThread& io);
  ~Timer();
  Timer(const Timer&) = delete;
  Timer& operator=(const Timer&) = delete;

  void start_once(std::chrono::milliseconds delay, std::function<void()> callback);
  void start_repeating(std::chrono::milliseconds interval, std::function<void()> callback);
  void cancel();

 private:
  struct Impl;
  std::shared_ptr<Impl> impl_;
};

}  // namespace tessera::net
