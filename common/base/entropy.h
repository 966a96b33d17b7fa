// SPDX-License-Identifier: Apache-2.0
// Random numbers that no peer can guess: session ids, tokens, seeds of back-off. They come from the
// system, unless a simulation has put its own source in, so that one seed is one run
// (tests/sim/README.md).
//
// Threads. Any; a source is set while nothing else runs.
#pragma once

#include <cstdint>

namespace tessera {

// 64 bits, never 0 (which means "none" for sessions and tokens).
std::uint64_t entropy();

using EntropySource = std::uint64_t (*)();
// Null: the system's own.
void set_entropy_source(EntropySource source);

}  // namespace tessera
