// SPDX-License-Identifier: Apache-2.0
// The loops of a face, shared out among the patches of its grid: each patch gets closed loops in
// its own square.
//
// Threads. Functions of one thread.
#pragma once

#include <vector>

#include "common/base/status.h"
#include "master/import/cad/curve2.h"
#include "master/import/cad/face_surface.h"

namespace tessera::import::cad {

// A part of an edge that lies on the border of a patch, where it trims nothing.
struct BorderCurve {
  std::size_t cell = 0;
  Curve2 curve;  // in the square of the patch
};

struct CellTrims {
  bool is_kept = false;        // some of the patch lies in the face
  bool keeps_outside = false;  // the loops are holes of a patch that is whole otherwise
  std::vector<std::vector<Curve2>> loops;
};

// Where a curve of the face is farthest beyond the end of the grid. There is no surface, so the
// face ends at the border instead.
struct Overrun {
  int edge = -1;
  std::size_t cell = 0;
  Point2 place, border;  // in the square of the patch, which the first one is outside of
};

struct FaceTrims {
  std::vector<CellTrims> cells;  // cell (i, j) is number v.cell_count() i + j
  std::vector<BorderCurve> borders;
  std::vector<Overrun> overruns;
  int open_count = 0;  // ends of curves that met nothing, so that a line had to close them
};

// Pieces of curves between borders of patches: some hundred times what real faces have.
inline constexpr std::size_t kFacePiecesMax = 100'000;

// Returns: an error where the loops have more pieces than that.
Result<FaceTrims> share_out(std::vector<std::vector<Curve2>> loops, const Axis& u, const Axis& v);

}  // namespace tessera::import::cad
