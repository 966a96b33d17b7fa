// SPDX-License-Identifier: Apache-2.0
// Name of this build, for --version, logs and the handshake. Peers compare protocol versions and
// not this name; it tells a person which builds met.
#pragma once

namespace tessera {

// The tag and the commit: "1.2.3", "1.2.3+4.gabc1234"; rules in deploy/cmake/version.cmake.
extern const char* const kBuildId;

}  // namespace tessera
