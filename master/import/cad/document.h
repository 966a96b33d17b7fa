// SPDX-License-Identifier: Apache-2.0
// A STEP or IGES file as parts and where they stand, in the file's own unit.
//
// A part is a solid, or the loose faces of one assembly; what stands in several places is one part.
// Threads. Functions of one thread. Errors: one line naming the file.
#pragma once

#include <Quantity_Color.hxx>
#include <TopoDS_Shape.hxx>
#include <gp_Trsf.hxx>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "common/base/status.h"

class TopoDS_TShape;

namespace tessera::import::cad {

struct Part {
  TopoDS_Shape shape;
  std::string name;  // of the product or of the solid; empty where the file has none
};

struct Placement {
  std::size_t part = 0;
  gp_Trsf part_to_file;
};

struct Document {
  std::vector<Part> parts;
  std::vector<Placement> placements;
  std::map<const TopoDS_TShape*, Quantity_Color> colors;  // of solids, shells and faces
  std::string unit;                                       // its name, as "MM"
  double sewing_tolerance = 0;  // loose faces were sewn within this; 0: none was loose
  std::size_t sewn_faces = 0, sewn_edges = 0;
  std::vector<std::string> warnings;

  std::optional<Quantity_Color> color_of(const TopoDS_Shape& shape) const;
};

// Returns: an error for a file that is cut off, damaged, goes round in a circle or has no faces.
Result<Document> read_step(const std::string& path);
Result<Document> read_iges(const std::string& path);

}  // namespace tessera::import::cad
