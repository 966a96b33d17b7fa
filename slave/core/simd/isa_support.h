// SPDX-License-Identifier: Apache-2.0
// Which instruction sets the CPU at hand has, in Tessera's words; Highway knows how to ask it.
// Threads. Any; the answer never changes while a process lives.
#pragma once

#include "common/base/isa.h"

namespace tessera::core {

// Always holds kScalar.
IsaMask cpu_isas();

}  // namespace tessera::core
