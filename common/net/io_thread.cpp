// SPDX-License-Identifier: Apache-2.0
#include "common/net/io_thread.h"

#include <pthread.h>

#include <cstdio>
#include <future>
#include <utility>

#include "common/base/check.h"
#include "common/net/io_thread_asio.h"

namespace tessera::net {

IoThread::IoThread(std::string thread_name) : impl_(std::make_unique<Impl>()) {
  impl_->thread = std::thread([this, name = thread_name.substr(0, 15)] {
    pthread_setname_np(pthread_self(), name.c_str());
    impl_->id = std::this_thread::get_id();
    impl_->context.run();
    impl_->id = std::thread::id();
  });
}

IoThread::~IoThread() { stop(); }

void IoThread::post(std::function<void()> task) { (void)impl_->post(std::move(task)); }

void IoThread::run_and_wait(std::function<void()> task) {
  if (is_current()) return task();
  std::promise<void> done;
  const bool is_posted = impl_->post([&] {
    task();
    done.set_value();
  });
  if (is_posted) done.get_future().wait();
}

bool IoThread::is_current() const { return impl_->id == std::this_thread::get_id(); }

void IoThread::stop() {
  if (!impl_->thread.joinable()) return;
  TESSERA_CHECK(!is_current());
  {
    MutexLock lock(impl_->gate);
    impl_->is_stopped = true;
    asio::post(impl_->context, [this] { impl_->context.stop(); });
  }
  impl_->thread.join();
}

namespace {

// The callback lives in shared state; a cancelled timer clears it, so that a completion that is
// already queued finds nothing to call.
struct TimerState {
  explicit TimerState(asio::io_context& context) : timer(context) {}
  asio::steady_timer timer;
  std::function<void()> callback;
  std::chrono::milliseconds interval{0};  // 0: once
  std::uint64_t generation = 0;

  static void wait(const std::shared_ptr<TimerState>& self) {
    self->timer.async_wait([self, generation = self->generation](const asio::error_code& error) {
      if (error || generation != self->generation) return;
      const auto callback = self->callback;
      if (self->interval.count() > 0) {
        self->timer.expires_after(self->interval);
        wait(self);
      } else {
        self->callback = nullptr;
      }
      callback();
    });
  }
};

class AsioTimer final : public TimerBackend {
 public:
  explicit AsioTimer(asio::io_context& context) : state_(std::make_shared<TimerState>(context)) {}
  ~AsioTimer() override { AsioTimer::cancel(); }

  void start(std::chrono::milliseconds delay, std::chrono::milliseconds interval,
             std::function<void()> callback) override {
    ++state_->generation;
    state_->callback = std::move(callback);
    state_->interval = interval;
    state_->timer.expires_after(delay);
    TimerState::wait(state_);
  }

  void cancel() override {
    ++state_->generation;
    state_->callback = nullptr;
    state_->timer.cancel();
  }

 private:
  std::shared_ptr<TimerState> state_;
};

}  // namespace

std::unique_ptr<TimerBackend> IoThread::make_timer() {
  return std::make_unique<AsioTimer>(impl_->context);
}

}  // namespace tessera::net
