// SPDX-License-Identifier: Apache-2.0
// Cost of surface programs in a frame lit by VPLs, see gi_suite.h.
//
// Threads. One.
#pragma once

#include <string>

#include "common/frame/frame_settings.h"
#include "common/scene/scene.h"
#include "tests/bench/core_suite.h"

namespace tessera::bench {

// Compares the time of the scene with each program on all its materials to that of the scene
// itself. Prints a table. Returns: JSON.
std::string measure_surfaces(const Scene& scene, const FrameSettings& settings,
                             const CoreSuiteOptions& options);

}  // namespace tessera::bench
