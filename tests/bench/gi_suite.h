// SPDX-License-Identifier: Apache-2.0
// The suite "gi": instant global illumination, its speed and its error.
//
// Error: for settings of igi and of path, CPU-seconds of one core against RMSE, relMSE and FLIP to
// a path-traced reference; the slopes of these series; the time in which path gets as good a
// picture as igi, and the error that path has in as much time.
// Speed: where a frame's time goes; shadow rays in the renderer beside the same rays in the core
// and in Embree; what samples, interleaving and borders cost; tables 9.1 and 9.2 of the thesis;
// what procedural surfaces cost (figure 9.3).
//
// Threads. One; the reference is rendered on all.
#pragma once

#include <string>
#include <vector>

#include "common/base/status.h"
#include "tests/bench/core_suite.h"

namespace tessera::bench {

std::vector<std::string> gi_scene_names();

// Uses the options scenes, only (error or speed), isa, repeats and is_quick. Appends JSON, one
// object a scene, to `json`.
Status run_gi_suite(const CoreSuiteOptions& options, std::vector<std::string>& json);

}  // namespace tessera::bench
