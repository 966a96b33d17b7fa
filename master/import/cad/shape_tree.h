// SPDX-License-Identifier: Apache-2.0
// What both formats share: circles of references are found, and a tree of shapes becomes parts and
// their places. Threads. Functions of one thread.
#pragma once

#include <Interface_InterfaceModel.hxx>
#include <TopoDS_Shape.hxx>
#include <initializer_list>
#include <string>

#include "common/base/status.h"
#include "master/import/cad/document.h"

namespace tessera::import::cad {

// Returns: an error where a file does not have one of the marks near its end.
Status check_end(const std::string& path, std::initializer_list<const char*> end_marks);

// Whether entities of a file refer to each other in a circle, or deeper than 10,000 of them.
Status check_circles(const std::string& path, const Handle(Interface_InterfaceModel) & model);

// What is wrong with the first entity that could not be read whole; nothing where all could. Such
// files open as a rule; where Open CASCADE crashes on one, this is why.
std::string first_damage(const Handle(Interface_InterfaceModel) & model);

// Adds the parts of a tree of shapes, and where they stand.
void add_parts(const TopoDS_Shape& shape, Document& document);

// Says what there is in a file without faces.
Status no_surfaces(const std::string& path, const TopoDS_Shape& shape);

}  // namespace tessera::import::cad
