// SPDX-License-Identifier: Apache-2.0
// The suite "core": rays per CPU-second of every way to trace them, and of Embree where the build
// has it, all on the same rays in the same run, interleaved. It also counts where the answers
// differ.
//
// Threads. One.
#pragma once

#include <string>
#include <vector>

#include "common/base/isa.h"
#include "common/base/status.h"

namespace tessera::bench {

struct CoreSuiteOptions {
  std::vector<std::string> scenes;
  Isa isa = Isa::kScalar;
  std::vector<std::string> kinds;  // of rays; empty: all
  std::string only;                // contenders whose name holds this; the first always runs
  int size_px = 1024;              // a multiple of 32
  bool with_all_peers = false;     // Embree's build "high" and its robust flag, too
  bool with_methods = false;       // patch: the methods for patches, and no triangles
  bool with_sizes = false;         // fans of 8 to 128 rays; builds of a part of a scene
  bool keeps_memory = false;       // builds in memory that the process has touched before
  int repeats = 5;
  bool is_quick = false;
};

// Appends JSON, one object a scene, to `json`.
Status run_core_suite(const CoreSuiteOptions& options, std::vector<std::string>& json);

}  // namespace tessera::bench
