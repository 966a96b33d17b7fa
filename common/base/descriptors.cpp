// SPDX-License-Identifier: Apache-2.0
#include "common/base/descriptors.h"

#include <sys/resource.h>

namespace tessera {
namespace {

constexpr rlim_t kLeast = 20;  // _POSIX_OPEN_MAX
// Beyond all that this system opens; programs that close every number they may have stay fast.
constexpr rlim_t kMost = 65536;

}  // namespace

int descriptor_limit() {
  rlimit limits{};
  if (::getrlimit(RLIMIT_NOFILE, &limits) != 0) return static_cast<int>(kLeast);
  return static_cast<int>(std::clamp(limits.rlim_cur, kLeast, rlim_t{1} << 30));
}

int raise_descriptor_limit() {
  rlimit limits{};
  if (::getrlimit(RLIMIT_NOFILE, &limits) != 0) return descriptor_limit();
  const rlim_t wanted = std::min(limits.rlim_max, kMost);
  if (limits.rlim_cur < wanted) {
    limits.rlim_cur = wanted;
    (void)::setrlimit(RLIMIT_NOFILE, &limits);  // a refusal leaves what there was
  }
  return descriptor_limit();
}

}  // namespace tessera
