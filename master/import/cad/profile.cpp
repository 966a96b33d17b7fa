// SPDX-License-Identifier: Apache-2.0
#include "master/import/cad/profile.h"

#include <GeomConvert.hxx>
#include <GeomConvert_ApproxCurve.hxx>
#include <GeomConvert_BSplineCurveToBezierCurve.hxx>
#include <Geom_BSplineCurve.hxx>
#include <Geom_BezierCurve.hxx>
#include <Geom_Circle.hxx>
#include <Geom_Ellipse.hxx>
#include <Geom_Line.hxx>
#include <Geom_TrimmedCurve.hxx>
#include <TColStd_Array1OfReal.hxx>
#include <algorithm>
#include <cmath>
#include <numbers>

namespace tessera::import::cad {
namespace {

Control3 control(const gp_Pnt& p, double weight) { return {p.X(), p.Y(), p.Z(), weight}; }

// An ellipse, or a circle, as arcs.
Profile arcs(const gp_Ax2& place, double major, double minor, double from, double to) {
  Profile profile;
  profile.axis = {angle_borders(from, to), true};
  const auto at = [&](double angle, double stretch) {
    const gp_XYZ offset = place.XDirection().XYZ() * (major * std::cos(angle) * stretch) +
                          place.YDirection().XYZ() * (minor * std::sin(angle) * stretch);
    return gp_Pnt(place.Location().XYZ() + offset);
  };
  for (std::size_t i = 0; i < profile.axis.cell_count(); ++i) {
    const double a = profile.axis.borders[i], b = profile.axis.borders[i + 1];
    const double weight = std::cos((b - a) / 2);
    profile.pieces.push_back(
        {control(at(a, 1), 1), control(at((a + b) / 2, 1 / weight), weight), control(at(b, 1), 1)});
  }
  return profile;
}

Result<Profile> spline_pieces(Handle(Geom_BSplineCurve) spline, double from, double to) {
  if (spline->IsPeriodic()) {
    spline
        ->SetNotPeriodic();  // one period; the caller's interval lies in it, or is longer by a hair
  }
  const double low = std::max(from, spline->FirstParameter());
  const double high = std::min(to, spline->LastParameter());
  if (!(high > low)) return Status::invalid_argument("its curve has no extent");
  GeomConvert_BSplineCurveToBezierCurve bezier(spline, low, high, 1e-9 * (high - low));
  Profile profile;
  TColStd_Array1OfReal knots(1, bezier.NbArcs() + 1);
  bezier.Knots(knots);
  for (int i = 1; i <= knots.Length(); ++i) profile.axis.borders.push_back(knots(i));
  for (int i = 1; i <= bezier.NbArcs(); ++i) {
    const Handle(Geom_BezierCurve) arc = bezier.Arc(i);
    std::vector<Control3> piece;
    for (int k = 1; k <= arc->NbPoles(); ++k)
      piece.push_back(control(arc->Pole(k), arc->Weight(k)));
    profile.pieces.push_back(std::move(piece));
  }
  return profile;
}

}  // namespace

std::vector<double> angle_borders(double from, double to) {
  const double quarters = (to - from) / (std::numbers::pi / 2);
  const int count = std::max(1, static_cast<int>(std::ceil(quarters - 1e-6)));
  std::vector<double> borders;
  for (int i = 0; i < count; ++i) borders.push_back(from + (to - from) * i / count);
  borders.push_back(to);
  return borders;
}

Result<Profile> make_profile(const Handle(Geom_Curve) & given, double from, double to) {
  Handle(Geom_Curve) curve = given;
  while (const auto trimmed = Handle(Geom_TrimmedCurve)::DownCast(curve))
    curve = trimmed->BasisCurve();
  if (const auto line = Handle(Geom_Line)::DownCast(curve)) {
    Profile profile;
    profile.axis.borders = {from, to};
    profile.pieces = {{control(line->Value(from), 1), control(line->Value(to), 1)}};
    return profile;
  }
  if (const auto circle = Handle(Geom_Circle)::DownCast(curve))
    return arcs(circle->Position(), circle->Radius(), circle->Radius(), from, to);
  if (const auto ellipse = Handle(Geom_Ellipse)::DownCast(curve))
    return arcs(ellipse->Position(), ellipse->MajorRadius(), ellipse->MinorRadius(), from, to);
  if (const auto spline = Handle(Geom_BSplineCurve)::DownCast(curve))
    return spline_pieces(Handle(Geom_BSplineCurve)::DownCast(spline->Copy()), from, to);
  if (const auto bezier = Handle(Geom_BezierCurve)::DownCast(curve))
    return spline_pieces(GeomConvert::CurveToBSplineCurve(bezier), from, to);
  const Handle(Geom_TrimmedCurve) part = new Geom_TrimmedCurve(curve, from, to);
  const double size = part->StartPoint().Distance(part->EndPoint()) +
                      part->StartPoint().Distance(part->Value((from + to) / 2));
  GeomConvert_ApproxCurve approximated(part, 1e-7 * size, GeomAbs_C1, 100, 8);
  if (!approximated.HasResult()) return Status::invalid_argument("its curve cannot be followed");
  auto profile = spline_pieces(approximated.Curve(), from, to);
  if (profile.is_ok()) profile->approximation = approximated.MaxError();
  return profile;
}

}  // namespace tessera::import::cad
