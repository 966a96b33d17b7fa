// SPDX-License-Identifier: Apache-2.0
// The instruction sets of this CPU, as Tessera names them; Highway finds them out.
// Threads. Any; the answer never changes while a process lives.
#pragma once

#include "common/base/isa.h"

namespace tessera::core {

// Always holds kScalar.
IsaMask cpu_isas();

}  // namespace tessera::core
