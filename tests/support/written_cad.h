// SPDX-License-Identifier: Apache-2.0
// STEP and IGES files that tests write by Open CASCADE: assemblies, names and colours included.
//
// Threads. One at a time: the writer's settings are the process's.
#pragma once

#include <Quantity_Color.hxx>
#include <TopoDS_Compound.hxx>
#include <TopoDS_Shape.hxx>
#include <initializer_list>
#include <string>
#include <utility>
#include <vector>

namespace tessera::test {

struct StepContent {
  TopoDS_Shape shape;  // a compound is an assembly of what it holds
  std::vector<std::pair<TopoDS_Shape, Quantity_Color>> colors;  // of solids and faces of `shape`
  // What the writer calls a product, in the order of the file, becomes the name here. Names that
  // are left over name nothing.
  std::vector<std::string> product_names;
};

TopoDS_Compound assembly(std::initializer_list<TopoDS_Shape> parts);
TopLoc_Location moved(double x, double y, double z);
TopoDS_Shape face_of(const TopoDS_Shape& shape, int number);
// A board with two pairs of pegs on it, one turned; pegs are red, and blue on top.
StepContent tray();

// The text of the file. Returns: an empty text where Open CASCADE gives up.
std::string step_text(const StepContent& content);
// Loose faces without neighbours, as IGES has them. `resolution`: what the file says its own is.
std::string iges_text(const std::vector<TopoDS_Shape>& faces, double resolution);

}  // namespace tessera::test
