// SPDX-License-Identifier: Apache-2.0
// What the programs of surfaces cost in a frame lit by VPLs, see gi_suite.h.
//
// Threads. One.
#pragma once

#include <string>

#include "common/frame/frame_settings.h"
#include "common/scene/scene.h"
#include "tests/bench/core_suite.h"

namespace tessera::bench {

// The scene with each program on all that it has, to the scene itself. Prints a table. Returns: JSON.
std::string measure_surfaces(const Scene& scene, const FrameSettings& settings,
                             const CoreSuiteOptions& options);

}  // namespace tessera::bench
