// SPDX-License-Identifier: Apache-2.0
// The suite "gi": instant global illumination, its speed and its error.
//
// Error: CPU-seconds of one core against RMSE, relMSE and FLIP, of settings of igi and of path, to a
// path-traced reference; the slopes; what the other takes for as good a picture, or makes of as much
// time.
// Speed: where a frame's time goes; shadow rays in the renderer beside the same rays in the core and
// in Embree; what samples, interleaving and borders cost; tables 9.1 and 9.2 of the thesis; what
// procedural surfaces cost (figure 9.3).
//
// Threads. One, but for the reference.
#pragma once

#include <string>
#include <vector>

#include "common/base/status.h"
#include "tests/bench/core_suite.h"

namespace tessera::bench {

std::vector<std::string> gi_scene_names();

// Of the options scenes, only (error or speed), isa, repeats and is_quick. Appends JSON, one object a scene, to `json`.
Status run_gi_suite(const CoreSuiteOptions& options, std::vector<std::string>& json);

}  // namespace tessera::bench
