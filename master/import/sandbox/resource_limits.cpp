// SPDX-License-Identifier: Apache-2.0
#include <sched.h>
#include <sys/prctl.h>
#include <sys/resource.h>

#include <cerrno>
#include <csignal>

#include "master/import/sandbox/sandbox.h"

namespace tessera::import {
namespace {

constexpr rlim_t kErrorFileBytesMax = 1 << 20;
constexpr rlim_t kDescriptorsMax = 256;

void limit(int resource, rlim_t value) {
  const rlimit both{value, value};
  setrlimit(static_cast<__rlimit_resource>(resource), &both);
}

}  // namespace

void limit_resources(std::uint64_t memory_bytes, std::uint64_t cpu_seconds) {
#if !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)
  limit(RLIMIT_AS, memory_bytes);
#else
  (void)memory_bytes;  // sanitizers reserve terabytes of address space
#endif
  // One second of grace, so that the kernel's word is "CPU time limit" and not "killed".
  const rlimit cpu{cpu_seconds, cpu_seconds + 1};
  setrlimit(RLIMIT_CPU, &cpu);
  // No file is written to but by messages on standard error, where that is a file.
  limit(RLIMIT_FSIZE, kErrorFileBytesMax);
  std::signal(SIGXFSZ, SIG_IGN);
  limit(RLIMIT_NOFILE, kDescriptorsMax);
  limit(RLIMIT_CORE, 0);
  prctl(PR_SET_PDEATHSIG, SIGKILL, 0, 0, 0);
  // Needs rights that a person seldom has; what has none opens no socket by the table of calls.
  if (unshare(CLONE_NEWNET) != 0) errno = 0;
}

}  // namespace tessera::import
