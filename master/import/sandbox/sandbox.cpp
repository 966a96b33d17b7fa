// SPDX-License-Identifier: Apache-2.0
#include "master/import/sandbox/sandbox.h"

#include <sys/prctl.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <cerrno>
#include <cstdlib>
#include <cstring>

namespace tessera::import {
namespace {

#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
constexpr bool kIsSanitized = true;
#else
constexpr bool kIsSanitized = false;
#endif

constexpr unsigned kFirstOther = 3;  // behind standard input, output and error

}  // namespace

std::string enter_sandbox(const SandboxOptions& options) {
  limit_resources(options.memory_bytes, options.cpu_seconds);
  if (prctl(PR_SET_NO_NEW_PRIVS, 1, 0, 0, 0) != 0)
    return std::string("no no_new_privs: ") + std::strerror(errno);
  if (kIsSanitized) {
    if (options.load) options.load();
    return {};
  }
  syscall(SYS_close_range, kFirstOther, ~0U, 0U);  // older kernels lack it: the caller opened none
  clearenv();
  std::string missing;
  if (options.load) {
    // Landlock binds the thread that enters it and those that come of it: what libraries start as
    // they are loaded is bound by this first, wider ring.
    std::vector<std::string> wider = options.readable;
    wider.insert(wider.end(), options.readable_for_load.begin(), options.readable_for_load.end());
    missing = limit_files(wider);
    options.load();
  }
  if (missing.empty()) missing = limit_files(options.readable);
  if (const std::string calls = limit_system_calls(); !calls.empty())
    missing += (missing.empty() ? "" : ", ") + calls;
  return missing;
}

}  // namespace tessera::import
