// SPDX-License-Identifier: Apache-2.0
// What this build calls itself; for --version, logs and the handshake.
// Peers compare protocol versions, not this: it tells a person which builds met.
#pragma once

namespace tessera {

inline constexpr const char* kBuildId = "0.1.0";

}  // namespace tessera
