// SPDX-License-Identifier: Apache-2.0
// Shared objects of the product that a program loads when it first needs what they link.
// Threads. Any; what is loaded stays.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "common/base/status.h"

namespace tessera {

// The two paths where a plug-in is looked for, the first one first.
std::vector<std::string> plugin_places(const std::string& file_name);

// A loaded library: its functions, as many and in the order as they were asked for.
// Looks beside the executable and in ../lib/tessera. Shape: names and functions [count].
// Returns: kNotFound where there is no such file, saying where it was looked for; kUnavailable,
// saying why it cannot be loaded, or that it is of another build and lacks a function.
Status load_plugin(const std::string& file_name, std::span<const char* const> names,
                   std::span<void*> functions);

}  // namespace tessera
