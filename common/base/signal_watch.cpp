// SPDX-License-Identifier: Apache-2.0
#include "common/base/signal_watch.h"

#include <unistd.h>
#include <atomic>
#include <csignal>
#include <thread>

#include "common/base/clock.h"
#include "common/base/mutex.h"

namespace tessera {
namespace {

// Signals within this time are one request: a key pressed twice, or a terminal and a script that
// both send the signal.
constexpr std::chrono::milliseconds kSameRequest{500};

// One per process, never destroyed: the watching thread outlives main's locals.
struct State {
  Mutex mutex;
  CondVar changed;
  bool is_signalled TESSERA_GUARDED_BY(mutex) = false;
  std::atomic<std::uint64_t> hangups{0};
};

State& state() {
  static State* const instance = new State;
  return *instance;
}

sigset_t watched_signals(bool watches_hangup) {
  sigset_t set;
  sigemptyset(&set);
  sigaddset(&set, SIGINT);
  sigaddset(&set, SIGTERM);
  if (watches_hangup) sigaddset(&set, SIGHUP);
  return set;
}

}  // namespace

SignalWatch::SignalWatch(bool watches_hangup) {
  const sigset_t set = watched_signals(watches_hangup);
  pthread_sigmask(SIG_BLOCK, &set, nullptr);
  std::signal(SIGPIPE, SIG_IGN);
  state();
  std::thread([set] {
    TimePoint first{};
    while (true) {
      int signal = 0;
      sigwait(&set, &signal);
      if (signal == SIGHUP) {
        ++state().hangups;
        continue;
      }
      const TimePoint now = Clock::now();
      if (first == TimePoint{}) first = now;
      if (now - first > kSameRequest) _exit(130);
      {
        MutexLock lock(state().mutex);
        state().is_signalled = true;
      }
      state().changed.notify_all();
    }
  }).detach();
}

bool SignalWatch::is_signalled() const {
  MutexLock lock(state().mutex);
  return state().is_signalled;
}

bool SignalWatch::wait(std::chrono::milliseconds timeout) const {
  const TimePoint deadline = Clock::now() + timeout;
  MutexLock lock(state().mutex);
  while (!state().is_signalled) {
    if (!state().changed.wait_until(state().mutex, deadline)) break;
  }
  return state().is_signalled;
}

std::uint64_t hangup_count() { return state().hangups; }

}  // namespace tessera
