// SPDX-License-Identifier: Apache-2.0
// Error against time, see gi_suite.h.
//
// Threads. One; the reference is rendered on all.
#pragma once

#include <string>

#include "common/frame/frame_settings.h"
#include "slave/core/scene/prepared_scene.h"
#include "tests/bench/core_suite.h"

namespace tessera::bench {

// Prints tables. Returns: JSON.
std::string measure_error(const core::PreparedScene& scene, const FrameSettings& settings,
                          const CoreSuiteOptions& options);

}  // namespace tessera::bench
