// SPDX-License-Identifier: Apache-2.0
// A field of copies of CAD files, so that a scene has as many trimmed patches as one wants. What it
// is made of is said by a file with a word and a value a line:
//
//   copies N           of each file
//   arrange flat       each copy has patches of its own
//   arrange instances  each file's surfaces are there once
//   file PATH          each file
//
// Each copy has a diagonal of 1, a cell of 1 x 1 on the ground, and is turned by quarters.
//
// Threads. Pure functions.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "common/base/status.h"
#include "common/scene/scene.h"

namespace tessera::bench {

struct FieldPlan {
  std::uint64_t copies = 1;
  bool is_flat = true;
  std::vector<std::string> files;
};

Result<FieldPlan> read_plan(const std::string& path);
// Returns: a scene that is valid.
Result<Scene> make_field(const FieldPlan& plan);

// Of all instances.
struct FieldCounts {
  std::uint64_t patches = 0, patches_with_loops = 0, segments = 0, loops = 0;
};
FieldCounts counts_of(const Scene& field);

}  // namespace tessera::bench
