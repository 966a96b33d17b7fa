// SPDX-License-Identifier: Apache-2.0
// The faces of one part as a PatchSurface, and how far its faces are apart where they meet.
//
// Units. Lengths of the file. Threads. Functions of one thread.
#pragma once

#include <TopoDS_Shape.hxx>
#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "common/scene/patch_surface.h"
#include "master/import/cad/curve2.h"

class TopoDS_Face;

namespace tessera::import::cad {

struct PartFace {
  std::string kind;             // of its surface: "plane", "B-spline", ...
  std::size_t first_patch = 0;  // its patches come one behind the other
  std::size_t patch_count = 0;  // 0: the face was left out
};

struct PartReport {
  std::vector<PartFace> faces;        // in the order of the part
  std::vector<std::string> lost;      // a line for each face that was left out
  std::vector<std::string> warnings;  // a line for each kind of what is not exact
  std::size_t shared_edges = 0, open_edges = 0;
  double gap_max = 0;  // the most that two faces are apart at an edge
};

struct PartSurface {
  PatchSurface surface;  // trim_widths are set
  PartReport report;
};

// The number of a face's material.
using FaceMaterial = std::function<std::uint32_t(const TopoDS_Face&)>;

// Normals point out of the part where its faces do. Numbers are rounded once, to single precision.
PartSurface part_surface(const TopoDS_Shape& part, const FaceMaterial& material);

}  // namespace tessera::import::cad
