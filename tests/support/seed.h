// SPDX-License-Identifier: Apache-2.0
// The seeds of tests with random choices. TESSERA_SEED=N in the environment draws others: a failure
// says which N it was, and that N draws the same again. A seed that found a fault becomes a case.
//
// Threads. The test's.
#pragma once

#include <gtest/gtest.h>

#include <cstdint>
#include <cstdlib>
#include <iostream>
#include <random>
#include <string>

namespace tessera::test {

// Prints at the first failure which TESSERA_SEED repeats it.
class SeedTeller : public testing::EmptyTestEventListener {
 public:
  // Requires: `given`, the variable's value, lives as long as the process.
  static void tell_at_failure(const char* given) {
    static SeedTeller* const teller = [] {
      auto* made = new SeedTeller;  // the test program's, which deletes it
      testing::UnitTest::GetInstance()->listeners().Append(made);
      return made;
    }();
    teller->given_ = given;
  }

  void OnTestPartResult(const testing::TestPartResult& result) override {
    if (!result.failed() || is_told_) return;
    std::cout << "again with TESSERA_SEED=" << given_ << std::endl;
    is_told_ = true;
  }

 private:
  const char* given_ = "";
  bool is_told_ = false;
};

// usual: the test's own seed, another one for each stream of choices. Returns: `usual`, or with
// TESSERA_SEED=N a seed of N and `usual`; N = 0 gives `usual`.
inline std::uint32_t seed(std::uint32_t usual) {
  const char* const given = std::getenv("TESSERA_SEED");
  if (given == nullptr) return usual;
  SeedTeller::tell_at_failure(given);
  return usual + 0x9E3779B9u * static_cast<std::uint32_t>(std::strtoul(given, nullptr, 10));
}

// Returns: TESSERA_SEED, else another seed in every run.
inline unsigned seed() {
  const char* const given = std::getenv("TESSERA_SEED");
  return given != nullptr ? static_cast<unsigned>(std::strtoul(given, nullptr, 10))
                          : std::random_device{}();
}

}  // namespace tessera::test

// Names the seed of the scope in every failure.
#define TESSERA_TRACE_SEED(seed) SCOPED_TRACE("TESSERA_SEED=" + std::to_string(seed))
