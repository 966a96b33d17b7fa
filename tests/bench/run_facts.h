// SPDX-License-Identifier: Apache-2.0
// What a result needs to be read later: which program ran where, when and how. Documents show it
// below each table (tests/bench/tables.py).
#pragma once

#include <string>

namespace tessera::bench {

// Returns: a JSON object with "commit" (the build's version), "processor" (its model and how many
// of them the process may use), "compiler", "date" (UTC, ISO 8601) and "command" (the program's
// name and arguments).
std::string run_facts(int argc, const char* const* argv);

}  // namespace tessera::bench
