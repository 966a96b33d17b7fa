// SPDX-License-Identifier: Apache-2.0
// Reads a STEP or IGES file as a scene of freeform surfaces: one for each part, and an instance for
// each place where it stands. Lengths are in the file's unit; +z is up.
//
// Threads. Functions of one thread. Errors: one line naming the file.
#pragma once

#include <string>
#include <vector>

#include "common/scene_io/scene_reader.h"
#include "master/import/cad/part_surface.h"

namespace tessera::import::cad {

// `reports`, where it is not null, gets what is known of each part, in the order of the surfaces.
Result<ReadScene> read_cad(const std::string& path, std::vector<PartReport>* reports = nullptr);

}  // namespace tessera::import::cad
