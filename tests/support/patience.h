// SPDX-License-Identifier: Apache-2.0
// How long a test waits for what must come before it says that it does not, so that nothing hangs
// for ever. No test judges speed by it: what takes milliseconds on a machine at rest takes seconds
// where other programs have the processors, and minutes under a sanitizer.
//
// Threads. A constant.
#pragma once

#include <chrono>

namespace tessera::test {

inline constexpr std::chrono::seconds kPatience{300};

}  // namespace tessera::test
