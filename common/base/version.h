// What this build calls itself; for --version, logs and the handshake.
#pragma once

namespace tessera {

inline constexpr const char* kBuildId = "0.1.0";

}  // namespace tessera
