// SPDX-License-Identifier: Apache-2.0
// Property: no ray from inside of a closed solid of a CAD file leaves it where faces meet.
// TESSERA_LONG=1 casts 10^6 rays a file.
#include <gtest/gtest.h>
#include <BRepBndLib.hxx>
#include <BRep_Tool.hxx>
#include <Bnd_Box.hxx>
#include <GeomLProp_SLProps.hxx>
#include <TopExp.hxx>
#include <TopExp_Explorer.hxx>
#include <TopTools_IndexedMapOfShape.hxx>
#include <TopoDS.hxx>
#include <TopoDS_Edge.hxx>
#include <TopoDS_Face.hxx>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <iomanip>
#include <iostream>
#include <optional>

#include "master/import/cad/document.h"
#include "master/import/cad/messages.h"
#include "master/import/cad/reader.h"
#include "tests/support/closed_solid.h"

namespace tessera::import::cad {
namespace {

std::string folder() {
  const char* given = std::getenv("TESSERA_CAD_FILES");
  return given != nullptr ? given : TESSERA_CAD_FILES;
}

// A face along an edge.
struct EdgeSide {
  TopoDS_Edge edge;  // as the face has it
  TopoDS_Face face;
  Handle(Geom2d_Curve) curve;
  Handle(Geom_Surface) surface;
  double from = 0, to = 0;

  EdgeSide(const TopoDS_Edge& of, const TopoDS_Face& on) : edge(of), face(on) {
    curve = BRep_Tool::CurveOnSurface(edge, face, from, to);
    surface = BRep_Tool::Surface(face);
  }
  bool is_any() const { return !curve.IsNull() && !surface.IsNull(); }

  // Returns: false where it has no normal.
  bool place(double share, Vec3d& on, Vec3d& normal) const {
    const gp_Pnt2d p = curve->Value(from + share * (to - from));
    GeomLProp_SLProps at(surface, p.X(), p.Y(), 1, 1e-9);
    on = {at.Value().X(), at.Value().Y(), at.Value().Z()};
    if (!at.IsNormalDefined()) return false;
    const double sign = face.Orientation() == TopAbs_REVERSED ? -1 : 1;
    normal = {sign * at.Normal().X(), sign * at.Normal().Y(), sign * at.Normal().Z()};
    return true;
  }
};

struct SharedEdge {
  EdgeSide sides[2];
};

// The edges of a part between two faces, or of the seam of one. Returns: nothing where the part is
// open.
std::optional<std::vector<SharedEdge>> shared_edges(const TopoDS_Shape& part) {
  TopTools_IndexedMapOfShape numbers;
  TopExp::MapShapes(part, TopAbs_EDGE, numbers);
  std::vector<std::vector<EdgeSide>> sides(static_cast<std::size_t>(numbers.Extent()));
  for (TopExp_Explorer face(part, TopAbs_FACE); face.More(); face.Next()) {
    for (TopExp_Explorer edge(face.Current(), TopAbs_EDGE); edge.More(); edge.Next()) {
      const TopoDS_Edge of = TopoDS::Edge(edge.Current());
      if (BRep_Tool::Degenerated(of)) continue;
      if (of.Orientation() != TopAbs_FORWARD && of.Orientation() != TopAbs_REVERSED) continue;
      sides[static_cast<std::size_t>(numbers.FindIndex(of) - 1)].emplace_back(
          of, TopoDS::Face(face.Current()));
    }
  }
  std::vector<SharedEdge> edges;
  for (const auto& of : sides) {
    if (of.empty()) continue;
    if (of.size() != 2) return std::nullopt;
    if (of[0].is_any() && of[1].is_any()) edges.push_back({{of[0], of[1]}});
  }
  return edges;
}

double size_of(const TopoDS_Shape& part) {
  Bnd_Box box;
  BRepBndLib::Add(part, box);
  return std::sqrt(box.SquareExtent());
}

struct CadFile {
  const char* name;
  std::size_t closed;  // of its parts
};

class ClosedSolids : public testing::TestWithParam<CadFile> {};

TEST_P(ClosedSolids, HaveNoLeaksWhereFacesMeet) {
  const std::string path = folder() + "/" + GetParam().name;
  if (!std::filesystem::exists(path)) GTEST_SKIP() << path << " is not here";
  std::vector<PartReport> reports;
  const auto read = read_cad(path, &reports);
  ASSERT_TRUE(read.is_ok()) << read.status().message();
  Result<Document> document = Status::not_found("");
  {
    Messages messages;
    document = path.find(".iges") != path.npos ? read_iges(path) : read_step(path);
  }
  ASSERT_TRUE(document.is_ok());
  const std::size_t count = std::getenv("TESSERA_LONG") == nullptr ? 100'000 : 1'000'000;
  test::Choices choices(1912);
  std::size_t rays = 0, leaks = 0, held = 0, passed = 0, outside = 0, closed = 0;
  double gap = 0;
  for (std::size_t i = 0; i < document->parts.size(); ++i) {
    const auto edges = shared_edges(document->parts[i].shape);
    if (!edges || edges->empty()) {
      EXPECT_GT(reports[i].open_edges, 0u);
      continue;
    }
    ++closed;
    const double size = size_of(document->parts[i].shape);
    gap = std::max(gap, reports[i].gap_max / size);
    // Widths are gaps, and what single precision is off by.
    const test::ClosedSolid solid(*read->scene.surfaces[i], size,
                                  4 * (reports[i].gap_max + 0x1p-20 * size));
    const auto place = [&] {
      test::EdgePlace made;
      bool is_any = false;
      while (!is_any) {
        const SharedEdge& edge = (*edges)[choices.below(static_cast<unsigned>(edges->size()))];
        const double share = double{choices.share()};
        is_any = edge.sides[0].place(share, made.on[0], made.normal[0]) &&
                 edge.sides[1].place(share, made.on[1], made.normal[1]);
      }
      return made;
    };
    const test::LeakCounts counts = solid.cast(place, count / document->parts.size(), choices);
    rays += counts.rays, leaks += counts.leaks, held += counts.held;
    passed += counts.passed, outside += counts.outside;
    for (const core::CastRay& ray : counts.leaked)
      ADD_FAILURE() << std::setprecision(9) << "part " << i << ", a ray from " << ray.origin.x
                    << " " << ray.origin.y << " " << ray.origin.z << " along " << ray.direction.x
                    << " " << ray.direction.y << " " << ray.direction.z << ", past t " << ray.t_min;
  }
  std::cout << GetParam().name << ": " << closed << " closed parts, " << rays << " rays, " << leaks
            << " leaks; " << held << " held by borders alone, " << passed << " hits passed, "
            << outside << " places outside; largest gap " << gap << " of the size\n";
  EXPECT_EQ(closed, GetParam().closed);
  EXPECT_EQ(leaks, 0u);
  EXPECT_LE(held, 2 + rays / 100'000);
}

INSTANTIATE_TEST_SUITE_P(All, ClosedSolids,
                         testing::Values(CadFile{"linkrods.step", 1}, CadFile{"as1-oc-214.stp", 5},
                                         CadFile{"car-wheel-assembly.step", 43},
                                         CadFile{"Bottom.step", 1}, CadFile{"Bottom_nurbs.step", 1},
                                         CadFile{"Bottom_nurbs.iges", 1},
                                         CadFile{"bearing.iges", 0}),
                         [](const auto& info) {
                           std::string name = info.param.name;
                           for (char& c : name)
                             if (std::isalnum(static_cast<unsigned char>(c)) == 0) c = '_';
                           return name;
                         });

}  // namespace
}  // namespace tessera::import::cad
