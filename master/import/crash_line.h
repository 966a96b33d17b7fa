// SPDX-License-Identifier: Apache-2.0
// What a person sees of a library that crashes on a file: one line on standard error that names the
// file, and exit code 1, in the place of a signal. Too much processor time is told likewise.
//
// Each program and plug-in that links this has its own; the one made last speaks. What the handler
// writes is put together beforehand, so that it calls write() and _exit() alone.
//
// Threads. One object at a time, in the thread that reads; a crash may come in any thread. Under
// sanitizers, which tell of crashes themselves, it does nothing.
#pragma once

#include <signal.h>

#include <array>
#include <string>

namespace tessera::import {

class CrashLine {
 public:
  // The line: "tessera-import: PATH: READER crashed (segmentation fault); ..." The path is cut
  // where it is longer than 2,000 bytes.
  CrashLine(const std::string& path, const std::string& reader);
  ~CrashLine();
  CrashLine(const CrashLine&) = delete;
  CrashLine& operator=(const CrashLine&) = delete;

  // What the line ends with from now on, instead of "the file is probably damaged". Without an
  // object it does nothing.
  static void note(const std::string& text);

  static constexpr std::array kSignals = {SIGSEGV, SIGBUS, SIGFPE, SIGILL, SIGABRT, SIGXCPU};

 private:
  std::array<struct sigaction, kSignals.size()> before_;
  stack_t stack_before_;
};

}  // namespace tessera::import
