// SIGINT and SIGTERM as a flag that loops look at. The first signal asks to end in order; one that
// comes more than half a second later ends the process at once with exit code 130.
//
// Threads. Construct once, at the start of main before any other thread, so that every thread
// inherits the blocked mask. is_signalled() and wait() may be called by any thread.
#pragma once

#include <chrono>

namespace tessera {

class SignalWatch {
 public:
  SignalWatch();
  SignalWatch(const SignalWatch&) = delete;
  SignalWatch& operator=(const SignalWatch&) = delete;

  bool is_signalled() const;
  // Sleeps until a signal came or `timeout` passed. Returns: is_signalled().
  bool wait(std::chrono::milliseconds timeout) const;
};

}  // namespace tessera
