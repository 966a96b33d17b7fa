// SPDX-License-Identifier: Apache-2.0
#include "master/import/cad/face_loops.h"

#include <BRep_Tool.hxx>
#include <Geom2dConvert.hxx>
#include <Geom2dConvert_BSplineCurveToBezierCurve.hxx>
#include <Geom2d_BSplineCurve.hxx>
#include <Geom2d_BezierCurve.hxx>
#include <Geom2d_Line.hxx>
#include <Geom2d_TrimmedCurve.hxx>
#include <GeomAdaptor_Surface.hxx>
#include <ShapeFix_Edge.hxx>
#include <Standard_Failure.hxx>
#include <TopExp_Explorer.hxx>
#include <TopoDS.hxx>
#include <TopoDS_Edge.hxx>
#include <TopoDS_Iterator.hxx>
#include <TopoDS_Wire.hxx>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "common/scene/patch_surface.h"

namespace tessera::import::cad {
namespace {

constexpr int kBoundDepthMax = 20;  // of halvings until a curve's hull is its extent
// Ends nearer than this, in extents of the face, are one place: files have single precision or
// tolerances of 1e-5 of a part there. What is farther apart is joined by a line.
constexpr double kJoin = 1e-4;

constexpr double kRounding = 1e-10;  // of coordinates: an extent below this is what roundings leave
constexpr double kSameEnd = 1e-6;    // of a curve's extent: ends that conversion has kept
constexpr double kFitShare = 1e-9;   // of a curve's extent: below single precision's rounding

using Strand = std::vector<Curve2>;  // the curves of one edge, one behind the other

struct Box {
  double low[2] = {std::numeric_limits<double>::infinity(),
                   std::numeric_limits<double>::infinity()};
  double high[2] = {-std::numeric_limits<double>::infinity(),
                    -std::numeric_limits<double>::infinity()};
  void add(double u, double v) {
    low[0] = std::min(low[0], u), high[0] = std::max(high[0], u);
    low[1] = std::min(low[1], v), high[1] = std::max(high[1], v);
  }
  bool holds(double u, double v) const {
    return u >= low[0] && u <= high[0] && v >= low[1] && v <= high[1];
  }
};

void add_extent(const Curve2& curve, int depth, Box& box) {
  box.add(curve.first().u, curve.first().v);
  box.add(curve.last().u, curve.last().v);
  const bool is_inside =
      std::ranges::all_of(curve.points, [&](const Control2& p) { return box.holds(p.u, p.v); });
  if (is_inside) return;
  if (depth == kBoundDepthMax) {
    for (const Control2& p : curve.points) box.add(p.u, p.v);
    return;
  }
  const auto [left, right] = split(curve, 0.5);
  add_extent(left, depth + 1, box);
  add_extent(right, depth + 1, box);
}

double extent_of(const Handle(Geom2d_Curve) & curve, double from, double to) {
  Box box;
  for (int i = 0; i <= 8; ++i) {
    const gp_Pnt2d p = curve->Value(from + (to - from) * i / 8);
    box.add(p.X(), p.Y());
  }
  return std::hypot(box.high[0] - box.low[0], box.high[1] - box.low[1]);
}

// The curve as Open CASCADE converts it; nothing where its degree is too high, or where Open
// CASCADE gives up, as it does on weights that its own cuts make too small.
Strand converted(const Handle(Geom2d_TrimmedCurve) & part, int edge) {
  Strand strand;
  try {
    const Handle(Geom2d_BSplineCurve) spline = Geom2dConvert::CurveToBSplineCurve(part);
    if (spline->Degree() > kPatchDegreesMax) return {};
    Geom2dConvert_BSplineCurveToBezierCurve bezier(spline);
    for (int i = 1; i <= bezier.NbArcs(); ++i) {
      const Handle(Geom2d_BezierCurve) arc = bezier.Arc(i);
      Curve2 c;
      c.edge = edge;
      for (int k = 1; k <= arc->NbPoles(); ++k)
        c.points.push_back({arc->Pole(k).X(), arc->Pole(k).Y(), arc->Weight(k)});
      strand.push_back(std::move(c));
    }
  } catch (const Standard_Failure&) {
    return {};
  }
  return strand;
}

// The curve of an edge in parameters as Bezier curves, in the curve's own direction.
Strand strand_of(Handle(Geom2d_Curve) curve, double from, double to, int edge) {
  while (const auto trimmed = Handle(Geom2d_TrimmedCurve)::DownCast(curve))
    curve = trimmed->BasisCurve();
  const auto end = [&](double t) {
    const gp_Pnt2d p = curve->Value(t);
    return Control2{p.X(), p.Y(), 1};
  };
  if (curve->IsKind(STANDARD_TYPE(Geom2d_Line))) return {{{end(from), end(to)}, edge}};
  const Handle(Geom2d_TrimmedCurve) part = new Geom2d_TrimmedCurve(curve, from, to);
  Strand strand = converted(part, edge);
  // Open CASCADE 7.6 makes other curves of some that lie across the seam of a period.
  const double size = extent_of(part, from, to);
  const auto is_at = [&](Point2 p, double t) {
    return gp_Pnt2d(p.u, p.v).Distance(curve->Value(t)) <= kSameEnd * size;
  };
  if (strand.empty() || !is_at(strand.front().first(), from) || !is_at(strand.back().last(), to)) {
    strand = fit(
        [&](double t) {
          const gp_Pnt2d p = curve->Value(from + (to - from) * t);
          return Point2{p.X(), p.Y()};
        },
        kFitShare * size);
    for (Curve2& c : strand) c.edge = edge;
  }
  return strand;
}

void reverse(Strand& strand) {
  std::reverse(strand.begin(), strand.end());
  for (Curve2& curve : strand) curve = reversed(std::move(curve));
}

// Puts the strands of a wire one behind the other: as they come where these meet, else the nearest.
void order(std::vector<Strand>& strands, double width, double height) {
  for (std::size_t i = 0; i + 1 < strands.size(); ++i) {
    const Point2 end = strands[i].back().last();
    const auto away = [&](const Strand& s) {
      return std::hypot((s.front().first().u - end.u) / width,
                        (s.front().first().v - end.v) / height);
    };
    if (away(strands[i + 1]) <= kJoin) continue;
    const auto nearest =
        std::min_element(strands.begin() + static_cast<std::ptrdiff_t>(i) + 1, strands.end(),
                         [&](const Strand& a, const Strand& b) { return away(a) < away(b); });
    std::iter_swap(strands.begin() + static_cast<std::ptrdiff_t>(i) + 1, nearest);
  }
}

bool is_straight_along(const Curve2& curve, double Control2::*coordinate) {
  return std::ranges::all_of(curve.points, [&](const Control2& p) {
    return p.*coordinate == curve.points.front().*coordinate;
  });
}

// Gives the end of one curve and the beginning of the next one the same place.
void join(Curve2& before, Curve2& behind) {
  for (double Control2::*x : {&Control2::u, &Control2::v}) {
    double &a = before.points.back().*x, &b = behind.points.front().*x;
    // What runs along a parameter goes on to do so.
    const bool a_stays = is_straight_along(before, x), b_stays = is_straight_along(behind, x);
    if (a_stays && b_stays) {
      const double c = a;
      for (Control2& p : behind.points) p.*x = c;
    } else {
      a = b = a_stays ? a : b_stays ? b : (a + b) / 2;
    }
  }
}

std::vector<Curve2> closed(std::vector<Strand>& strands, double width, double height) {
  std::vector<Curve2> loop;
  for (Strand& strand : strands)
    for (Curve2& curve : strand) loop.push_back(std::move(curve));
  for (std::size_t i = 0; i < loop.size(); ++i) {
    const std::size_t next = (i + 1) % loop.size();
    const Point2 a = loop[i].last(), b = loop[next].first();
    if (std::fabs(a.u - b.u) <= kJoin * width && std::fabs(a.v - b.v) <= kJoin * height) {
      join(loop[i], loop[next]);
    }
  }
  // A curve that was moved as a whole leaves the one behind it; lines close what is left open.
  std::vector<Curve2> whole;
  for (std::size_t i = 0; i < loop.size(); ++i) {
    whole.push_back(loop[i]);
    const Point2 a = loop[i].last(), b = loop[(i + 1) % loop.size()].first();
    if (a != b) whole.push_back({{{a.u, a.v, 1}, {b.u, b.v, 1}}, -1});
  }
  return whole;
}

// Angles end where others begin; a sphere's height ends at its poles.
void widen(const TopoDS_Face& face, const Box& ends, Box& box) {
  const GeomAdaptor_Surface surface(BRep_Tool::Surface(face));
  // Where a curve only touches the border of the patch, the patch is made a bit larger.
  for (const int i : {0, 1}) {
    const double extent = box.high[i] - box.low[i];
    if (ends.low[i] - box.low[i] > 1e-7 * extent) box.low[i] -= extent / 128;
    if (box.high[i] - ends.high[i] > 1e-7 * extent) box.high[i] += extent / 128;
  }
  if (surface.GetType() == GeomAbs_Sphere) {
    box.low[1] = std::max(box.low[1], -std::numbers::pi / 2);
    box.high[1] = std::min(box.high[1], std::numbers::pi / 2);
  }
}

// How far the curve in parameters and the one in space are apart.
double error_of(const TopoDS_Edge& edge, const TopoDS_Face& face, const Handle(Geom2d_Curve) & flat,
                double from, double to) {
  double first, last, worst = 0;
  const Handle(Geom_Curve) curve = BRep_Tool::Curve(edge, first, last);
  const Handle(Geom_Surface) surface = BRep_Tool::Surface(face);
  if (curve.IsNull()) return 0;
  for (int i = 0; i <= 32; ++i) {
    const gp_Pnt2d p = flat->Value(from + (to - from) * i / 32);
    worst = std::max(
        worst,
        surface->Value(p.X(), p.Y()).Distance(curve->Value(first + (last - first) * i / 32)));
  }
  return worst;
}

}  // namespace

Result<FaceLoops> face_loops(const TopoDS_Face& given, const TopTools_IndexedMapOfShape& edges) {
  const TopoDS_Face face = TopoDS::Face(given.Oriented(TopAbs_FORWARD));
  FaceLoops made;
  std::vector<std::vector<Strand>> wires;
  for (TopoDS_Iterator wire(face); wire.More(); wire.Next()) {
    if (wire.Value().ShapeType() != TopAbs_WIRE) continue;
    std::vector<Strand> strands;
    for (TopoDS_Iterator part(wire.Value()); part.More(); part.Next()) {
      const TopoDS_Edge edge = TopoDS::Edge(part.Value());
      if (edge.Orientation() != TopAbs_FORWARD && edge.Orientation() != TopAbs_REVERSED) continue;
      double from, to;
      Handle(Geom2d_Curve) flat = BRep_Tool::CurveOnSurface(edge, face, from, to);
      if (flat.IsNull()) {
        ShapeFix_Edge().FixAddPCurve(edge, face, false);
        flat = BRep_Tool::CurveOnSurface(edge, face, from, to);
        if (flat.IsNull()) return Status::invalid_argument("an edge that cannot be projected");
        ++made.projected_count;
        made.projected_error = std::max(made.projected_error, error_of(edge, face, flat, from, to));
      }
      Strand strand = strand_of(flat, from, to, edges.FindIndex(edge) - 1);
      if (edge.Orientation() == TopAbs_REVERSED) reverse(strand);
      if (!strand.empty()) strands.push_back(std::move(strand));
    }
    if (!strands.empty()) wires.push_back(std::move(strands));
  }
  Box box, ends;
  for (const auto& wire : wires) {
    for (const Strand& strand : wire) {
      for (const Curve2& curve : strand) {
        add_extent(curve, 0, box);
        ends.add(curve.first().u, curve.first().v);
      }
    }
  }
  if (wires.empty()) {
    const Handle(Geom_Surface) surface = BRep_Tool::Surface(face);
    surface->Bounds(made.bounds[0], made.bounds[1], made.bounds[2], made.bounds[3]);
    if (std::ranges::any_of(made.bounds, [](double x) { return !(std::fabs(x) < 1e50); }))
      return Status::invalid_argument("an endless face");
    return made;
  }
  const double width = box.high[0] - box.low[0], height = box.high[1] - box.low[1];
  const auto is_extent = [](double low, double high) {
    return high - low > kRounding * std::max(std::fabs(low), std::fabs(high));
  };
  if (!is_extent(box.low[0], box.high[0]) || !is_extent(box.low[1], box.high[1]))
    return Status::invalid_argument("a face without extent");
  for (auto& wire : wires) {
    order(wire, width, height);
    made.loops.push_back(closed(wire, width, height));
  }
  widen(face, ends, box);
  made.bounds = {box.low[0], box.high[0], box.low[1], box.high[1]};
  return made;
}

}  // namespace tessera::import::cad
