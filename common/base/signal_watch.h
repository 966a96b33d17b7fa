// SPDX-License-Identifier: Apache-2.0
// SIGINT and SIGTERM as a flag that loops look at. The first signal asks to end in order; one that
// comes more than half a second later ends the process at once with exit code 130. SIGHUP, where it
// is watched, means "read your files again"; hangup_count() counts it for code that has files.
//
// Threads. Construct once, at the start of main before any other thread, so that every thread
// inherits the blocked mask. is_signalled(), wait() and hangup_count() may be called by any thread.
#pragma once

#include <chrono>
#include <cstdint>

namespace tessera {

class SignalWatch {
 public:
  // Without `watches_hangup` SIGHUP ends the process as always, such as when its terminal is
  // closed.
  explicit SignalWatch(bool watches_hangup = false);
  SignalWatch(const SignalWatch&) = delete;
  SignalWatch& operator=(const SignalWatch&) = delete;

  bool is_signalled() const;
  // Sleeps until a signal came or `timeout` passed. Returns: is_signalled().
  bool wait(std::chrono::milliseconds timeout) const;
};

// Number of SIGHUPs so far; 0 for ever in a process that does not watch them.
std::uint64_t hangup_count();

}  // namespace tessera
