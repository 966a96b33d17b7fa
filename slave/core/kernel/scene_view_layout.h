// The scene as the kernels see it: raw pointers into arrays that PreparedScene owns and never
// changes.
#pragma once

#include <stdint.h>

#include "slave/core/accel/kd_layout.h"

namespace tessera::core {

struct SceneView {
  const KdNode* nodes;    // root first
  const uint32_t* refs;   // triangle numbers, ascending within a leaf
  const float* vertices;  // [triangle_count][3 vertices][x, y, z], world space
  float lower[3];         // closed box of the tree; lower > upper for an empty scene
  float upper[3];
};

}  // namespace tessera::core
