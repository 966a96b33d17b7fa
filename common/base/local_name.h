// SPDX-License-Identifier: Apache-2.0
// How slaves inside a master's process are called: "local-1". No certificate has such a name, so
// that each has its own in the status and in logs.
#pragma once

#include <string_view>

namespace tessera {

inline constexpr std::string_view kLocalNamePrefix = "local-";

}  // namespace tessera
