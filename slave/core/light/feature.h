// SPDX-License-Identifier: Apache-2.0
// Whether a scene has a feature that hot code tests for. A core may be built without the code of
// all such features, to measure what the tests cost where a scene does not have them
// (tests/bench/feature_cost/core_cost.sh); in that build the answer is always no.
// Threads. Plain values.
#pragma once

namespace tessera::core {

#ifdef TESSERA_PLAIN_CORE
struct Feature {
  constexpr operator bool() const { return false; }
  constexpr Feature& operator=(bool) { return *this; }
  constexpr void operator|=(bool) const {}
};
#else
using Feature = bool;
#endif

}  // namespace tessera::core
