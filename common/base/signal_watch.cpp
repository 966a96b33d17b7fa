#include "common/base/signal_watch.h"

#include <unistd.h>
#include <csignal>
#include <thread>

#include "common/base/clock.h"
#include "common/base/mutex.h"

namespace tessera {
namespace {

// A key pressed twice, or a terminal and a script that both send it, mean it once.
constexpr std::chrono::milliseconds kSameRequest{500};

// One per process, never destroyed: the watching thread outlives main's locals.
struct State {
  Mutex mutex;
  CondVar changed;
  bool is_signalled TESSERA_GUARDED_BY(mutex) = false;
};

State& state() {
  static State* const instance = new State;
  return *instance;
}

sigset_t watched_signals() {
  sigset_t set;
  sigemptyset(&set);
  sigaddset(&set, SIGINT);
  sigaddset(&set, SIGTERM);
  return set;
}

}  // namespace

SignalWatch::SignalWatch() {
  const sigset_t set = watched_signals();
  pthread_sigmask(SIG_BLOCK, &set, nullptr);
  std::signal(SIGPIPE, SIG_IGN);
  state();
  std::thread([set] {
    TimePoint first{};
    while (true) {
      int signal = 0;
      sigwait(&set, &signal);
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

}  // namespace tessera
