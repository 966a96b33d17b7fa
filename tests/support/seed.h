// SPDX-License-Identifier: Apache-2.0
// The seed of a test with random choices: TESSERA_SEED, else another one in every run. It is
// printed when the test fails, so that the failure can be had again.
//
// Threads. The test's.
#pragma once

#include <gtest/gtest.h>

#include <cstdlib>
#include <random>
#include <string>

namespace tessera::test {

inline unsigned seed() {
  const char* const given = std::getenv("TESSERA_SEED");
  return given != nullptr ? static_cast<unsigned>(std::strtoul(given, nullptr, 10))
                          : std::random_device{}();
}

}  // namespace tessera::test

// Names the seed of the scope in every failure.
#define TESSERA_TRACE_SEED(seed) SCOPED_TRACE("TESSERA_SEED=" + std::to_string(seed))
