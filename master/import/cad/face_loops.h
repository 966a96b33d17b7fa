// SPDX-License-Identifier: Apache-2.0
// The loops of a face in its own parameters, from the curves that the file has there, or from the
// edges in space, projected, where it has none.
//
// Units. Parameters of the face. Threads. Plain values. Errors: one line, without the file.
#pragma once

#include <TopTools_IndexedMapOfShape.hxx>
#include <TopoDS_Face.hxx>
#include <array>
#include <vector>

#include "common/base/status.h"
#include "master/import/cad/curve2.h"

namespace tessera::import::cad {

struct FaceLoops {
  std::vector<std::vector<Curve2>> loops;  // each is closed, to the bit
  std::array<double, 4> bounds{};          // u low, u high, v low, v high
  int projected_count = 0;                 // edges that had no curve in parameters
  double projected_error = 0;              // the most that one of these is off, lengths of the file
};

// Curves name their edges by the numbers that these have in `edges`, less 1.
Result<FaceLoops> face_loops(const TopoDS_Face& face, const TopTools_IndexedMapOfShape& edges);

}  // namespace tessera::import::cad
