// SPDX-License-Identifier: Apache-2.0
// Writes CAD files of a few faces into a folder, for tests that damage them: an assembly of planes
// (tray.step), trimmed B-splines in solids (rods.step) and without neighbours (rods.igs).
#include <BRepBuilderAPI_NurbsConvert.hxx>
#include <BRepPrimAPI_MakeCylinder.hxx>
#include <BRepPrimAPI_MakeTorus.hxx>
#include <Standard_Failure.hxx>
#include <TopExp_Explorer.hxx>

#include <cstdio>
#include <fstream>
#include <string>
#include <vector>

#include "tests/support/written_cad.h"

namespace {

bool write(const std::string& path, const std::string& text) {
  std::ofstream(path, std::ios::binary) << text;
  return !text.empty();
}

bool write_all(const std::string& folder) {
  using namespace tessera::test;
  const TopoDS_Shape rod =
      BRepBuilderAPI_NurbsConvert(BRepPrimAPI_MakeCylinder(5, 20, 4).Shape());  // 4 radians of it
  const TopoDS_Shape ring = BRepPrimAPI_MakeTorus(12, 3, 2.5).Shape();
  StepContent rods{assembly({rod, ring.Located(moved(0, 0, 30))}), {}, {"rods", "rod", "ring"}};
  rods.colors.emplace_back(rod, Quantity_Color(0.2, 0.7, 0.3, Quantity_TOC_sRGB));
  std::vector<TopoDS_Shape> faces;
  for (const TopoDS_Shape& shape : {rod, ring})
    for (TopExp_Explorer face(shape, TopAbs_FACE); face.More(); face.Next())
      faces.push_back(face.Current());
  return write(folder + "/tray.step", step_text(tray())) &&
         write(folder + "/rods.step", step_text(rods)) &&
         write(folder + "/rods.igs", iges_text(faces, 1e-4));
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 2) {
    std::fprintf(stderr, "usage: make_cad_files FOLDER\n");
    return 2;
  }
  try {
    if (write_all(argv[1])) return 0;
    std::fprintf(stderr, "make_cad_files: Open CASCADE writes no file\n");
  } catch (const Standard_Failure& failure) {
    std::fprintf(stderr, "make_cad_files: %s\n", failure.GetMessageString());
  }
  return 1;
}
