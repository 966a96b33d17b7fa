// SPDX-License-Identifier: Apache-2.0
#include "master/import/cad/face_surface.h"

#include <BRep_Tool.hxx>
#include <GeomConvert.hxx>
#include <GeomConvert_ApproxSurface.hxx>
#include <GeomConvert_BSplineSurfaceToBezierSurface.hxx>
#include <Geom_BSplineSurface.hxx>
#include <Geom_BezierSurface.hxx>
#include <Geom_Circle.hxx>
#include <Geom_ConicalSurface.hxx>
#include <Geom_CylindricalSurface.hxx>
#include <Geom_Line.hxx>
#include <Geom_Plane.hxx>
#include <Geom_RectangularTrimmedSurface.hxx>
#include <Geom_SphericalSurface.hxx>
#include <Geom_SurfaceOfLinearExtrusion.hxx>
#include <Geom_SurfaceOfRevolution.hxx>
#include <Geom_ToroidalSurface.hxx>
#include <TColStd_Array1OfReal.hxx>
#include <TopoDS_Face.hxx>
#include <algorithm>
#include <cmath>

#include "common/scene/patch_surface.h"
#include "master/import/cad/profile.h"

namespace tessera::import::cad {
namespace {

bool is_any_weight(const std::vector<Control3>& points) {
  return std::ranges::any_of(points, [](const Control3& p) { return p.weight != 1; });
}

// Moves a curve along a vector: u is the curve's parameter, v the way.
FaceSurface extruded(const Profile& profile, const gp_XYZ& along, double from, double to) {
  FaceSurface surface;
  surface.u = profile.axis;
  surface.v.borders = {from, to};
  surface.approximation = profile.approximation;
  for (const auto& piece : profile.pieces) {
    BezierPatch patch{static_cast<int>(piece.size()) - 1, 1, is_any_weight(piece), {}};
    for (const Control3& p : piece) {
      for (const double way : {from, to}) {
        patch.points.push_back(
            {p.x + way * along.X(), p.y + way * along.Y(), p.z + way * along.Z(), p.weight});
      }
    }
    surface.patches.push_back(std::move(patch));
  }
  return surface;
}

// Turns a curve about an axis: u is the angle, v the curve's parameter. `turn`: 1, or -1 where the
// surface's frame is left-handed.
FaceSurface revolved(const Profile& profile, const gp_Ax1& axis, double turn, double from,
                     double to) {
  FaceSurface surface;
  surface.u = {angle_borders(from, to), true};
  surface.v = profile.axis;
  surface.approximation = profile.approximation;
  const gp_XYZ origin = axis.Location().XYZ(), z = axis.Direction().XYZ();
  for (std::size_t i = 0; i < surface.u.cell_count(); ++i) {
    const double a = surface.u.borders[i], b = surface.u.borders[i + 1];
    const double weight = std::cos((b - a) / 2), middle = (a + b) / 2;
    const double rows[3][3] = {{std::cos(a), std::sin(a), 1},
                               {std::cos(middle) / weight, std::sin(middle) / weight, weight},
                               {std::cos(b), std::sin(b), 1}};
    for (const auto& piece : profile.pieces) {
      BezierPatch patch{2, static_cast<int>(piece.size()) - 1, true, {}};
      for (const auto& [cosine, sine, w] : rows) {
        for (const Control3& p : piece) {
          const gp_XYZ offset = gp_XYZ(p.x, p.y, p.z) - origin;
          const gp_XYZ up = z * offset.Dot(z), out = offset - up;
          const gp_XYZ q = origin + up + out * cosine + z.Crossed(out) * (sine * turn);
          patch.points.push_back({q.X(), q.Y(), q.Z(), p.weight * w});
        }
      }
      surface.patches.push_back(std::move(patch));
    }
  }
  return surface;
}

FaceSurface plane(const Geom_Plane& given, const std::array<double, 4>& b) {
  FaceSurface surface;
  surface.u.borders = {b[0], b[1]};
  surface.v.borders = {b[2], b[3]};
  BezierPatch patch;
  for (const double u : {b[0], b[1]}) {
    for (const double v : {b[2], b[3]}) {
      const gp_Pnt p = given.Value(u, v);
      patch.points.push_back({p.X(), p.Y(), p.Z(), 1});
    }
  }
  surface.patches.push_back(patch);
  return surface;
}

void shift(Axis& axis, double first) {
  const double by = first - axis.borders.front();
  for (double& border : axis.borders) border += by;
}

Result<FaceSurface> spline(Handle(Geom_BSplineSurface) given, const std::array<double, 4>& b) {
  if (given->UDegree() > kPatchDegreesMax || given->VDegree() > kPatchDegreesMax)
    return Status::invalid_argument("a B-spline of degree above 15");
  const Handle(Geom_BSplineSurface) s = Handle(Geom_BSplineSurface)::DownCast(given->Copy());
  // A face may lie across the seam: a period that begins where the face does has no seam in it.
  if (s->IsUPeriodic() || s->IsVPeriodic()) {
    double u0, u1, v0, v1;
    s->Bounds(u0, u1, v0, v1);
    const double u_from = s->IsUPeriodic() ? b[0] : u0, v_from = s->IsVPeriodic() ? b[2] : v0;
    const double u_to = s->IsUPeriodic() ? std::min(b[1], b[0] + (u1 - u0)) : u1;
    const double v_to = s->IsVPeriodic() ? std::min(b[3], b[2] + (v1 - v0)) : v1;
    s->Segment(u_from, u_to, v_from, v_to);
    if (s->IsUPeriodic()) s->SetUNotPeriodic();
    if (s->IsVPeriodic()) s->SetVNotPeriodic();
  }
  GeomConvert_BSplineSurfaceToBezierSurface bezier(s);
  FaceSurface surface;
  TColStd_Array1OfReal u_knots(1, bezier.NbUPatches() + 1), v_knots(1, bezier.NbVPatches() + 1);
  bezier.UKnots(u_knots);
  bezier.VKnots(v_knots);
  for (int i = 1; i <= u_knots.Length(); ++i) surface.u.borders.push_back(u_knots(i));
  for (int i = 1; i <= v_knots.Length(); ++i) surface.v.borders.push_back(v_knots(i));
  // The period that was cut out may be another one than the face's.
  if (given->IsUPeriodic()) shift(surface.u, b[0]);
  if (given->IsVPeriodic()) shift(surface.v, b[2]);
  for (int i = 1; i <= bezier.NbUPatches(); ++i) {
    for (int j = 1; j <= bezier.NbVPatches(); ++j) {
      const Handle(Geom_BezierSurface) part = bezier.Patch(i, j);
      BezierPatch patch{part->UDegree(), part->VDegree(), false, {}};
      for (int k = 1; k <= part->NbUPoles(); ++k) {
        for (int l = 1; l <= part->NbVPoles(); ++l) {
          const gp_Pnt p = part->Pole(k, l);
          patch.points.push_back({p.X(), p.Y(), p.Z(), part->Weight(k, l)});
        }
      }
      const double first = patch.points.front().weight;
      patch.is_rational = std::ranges::any_of(patch.points, [first](const Control3& p) {
        return std::fabs(p.weight - first) > 1e-12 * first;
      });
      surface.patches.push_back(std::move(patch));
    }
  }
  return surface;
}

Result<FaceSurface> swept(const Handle(Geom_Surface) & given, const std::array<double, 4>& b) {
  if (const auto e = Handle(Geom_SurfaceOfLinearExtrusion)::DownCast(given)) {
    const auto profile = make_profile(e->BasisCurve(), b[0], b[1]);
    if (!profile.is_ok()) return profile.status();
    return extruded(*profile, e->Direction().XYZ(), b[2], b[3]);
  }
  const auto r = Handle(Geom_SurfaceOfRevolution)::DownCast(given);
  const auto profile = make_profile(r->BasisCurve(), b[2], b[3]);
  if (!profile.is_ok()) return profile.status();
  return revolved(*profile, r->Axis(), 1, b[0], b[1]);
}

// The meridian of a cone, sphere or torus, which turns about the axis of its frame.
Result<FaceSurface> turned(const Handle(Geom_Curve) & meridian, const gp_Ax3& frame,
                           const std::array<double, 4>& b) {
  const auto profile = make_profile(meridian, b[2], b[3]);
  if (!profile.is_ok()) return profile.status();
  return revolved(*profile, frame.Axis(), frame.Direct() ? 1 : -1, b[0], b[1]);
}

Handle(Geom_Curve) meridian_circle(const gp_Ax3& frame, double away, double radius) {
  const gp_Pnt center(frame.Location().XYZ() + frame.XDirection().XYZ() * away);
  // The circle's own y is the frame's z.
  const gp_Dir normal = frame.XDirection().Crossed(frame.Direction());
  return new Geom_Circle(gp_Ax2(center, normal, frame.XDirection()), radius);
}

Result<FaceSurface> approximated(const Handle(Geom_Surface) & given,
                                 const std::array<double, 4>& b) {
  const Handle(Geom_Surface) part =
      new Geom_RectangularTrimmedSurface(given, b[0], b[1], b[2], b[3]);
  const double size = part->Value(b[0], b[2]).Distance(part->Value(b[1], b[3]));
  GeomConvert_ApproxSurface approximation(part, 1e-6 * size, GeomAbs_C1, GeomAbs_C1, 8, 8, 64, 1);
  if (!approximation.HasResult()) return Status::invalid_argument("a surface of no known kind");
  auto surface = spline(approximation.Surface(), b);
  if (surface.is_ok()) surface->approximation = approximation.MaxError();
  return surface;
}

Result<FaceSurface> of_kind(const Handle(Geom_Surface) & s, const std::array<double, 4>& b,
                            std::string& kind) {
  if (const auto p = Handle(Geom_Plane)::DownCast(s)) return kind = "plane", plane(*p, b);
  if (const auto c = Handle(Geom_CylindricalSurface)::DownCast(s)) {
    kind = "cylinder";
    const gp_Ax3 f = c->Position();
    const gp_XYZ foot = f.Location().XYZ() + f.XDirection().XYZ() * c->Radius();
    Profile line;
    line.axis.borders = {b[2], b[3]};
    for (const double way : {b[2], b[3]}) {
      const gp_XYZ p = foot + f.Direction().XYZ() * way;
      if (line.pieces.empty()) line.pieces.emplace_back();
      line.pieces[0].push_back({p.X(), p.Y(), p.Z(), 1});
    }
    return revolved(line, f.Axis(), f.Direct() ? 1 : -1, b[0], b[1]);
  }
  if (const auto c = Handle(Geom_ConicalSurface)::DownCast(s)) {
    kind = "cone";
    const gp_Ax3 f = c->Position();
    const gp_XYZ foot = f.Location().XYZ() + f.XDirection().XYZ() * c->RefRadius();
    const gp_XYZ way = f.XDirection().XYZ() * std::sin(c->SemiAngle()) +
                       f.Direction().XYZ() * std::cos(c->SemiAngle());
    return turned(new Geom_Line(gp_Pnt(foot), gp_Dir(way)), f, b);
  }
  if (const auto c = Handle(Geom_SphericalSurface)::DownCast(s)) {
    kind = "sphere";
    return turned(meridian_circle(c->Position(), 0, c->Radius()), c->Position(), b);
  }
  if (const auto c = Handle(Geom_ToroidalSurface)::DownCast(s)) {
    kind = "torus";
    return turned(meridian_circle(c->Position(), c->MajorRadius(), c->MinorRadius()), c->Position(),
                  b);
  }
  if (const auto c = Handle(Geom_BSplineSurface)::DownCast(s))
    return kind = "B-spline", spline(c, b);
  if (const auto c = Handle(Geom_BezierSurface)::DownCast(s))
    return kind = "Bezier", spline(GeomConvert::SurfaceToBSplineSurface(c), b);
  if (s->IsKind(STANDARD_TYPE(Geom_SurfaceOfLinearExtrusion)))
    return kind = "extrusion", swept(s, b);
  if (s->IsKind(STANDARD_TYPE(Geom_SurfaceOfRevolution))) return kind = "revolution", swept(s, b);
  return kind = "approximated", approximated(s, b);
}

// De Casteljau's steps over `count` homogeneous points, each `stride` behind the last one. The
// first one becomes the place at `t`.
void fold(Control3* points, std::size_t count, std::size_t stride, double t) {
  for (std::size_t left = count - 1; left > 0; --left) {
    for (std::size_t i = 0; i < left; ++i) {
      Control3& a = points[i * stride];
      const Control3& b = points[(i + 1) * stride];
      a = {a.x + t * (b.x - a.x), a.y + t * (b.y - a.y), a.z + t * (b.z - a.z),
           a.weight + t * (b.weight - a.weight)};
    }
  }
}

}  // namespace

Control3 BezierPatch::at(double u, double v) const {
  std::vector<Control3> p = points;
  for (Control3& c : p) c = {c.x * c.weight, c.y * c.weight, c.z * c.weight, c.weight};
  const auto rows = static_cast<std::size_t>(degree_u) + 1;
  const auto columns = static_cast<std::size_t>(degree_v) + 1;
  for (std::size_t j = 0; j < columns; ++j) fold(p.data() + j, rows, columns, u);
  fold(p.data(), columns, 1, v);
  return {p[0].x / p[0].weight, p[0].y / p[0].weight, p[0].z / p[0].weight, 1};
}

Result<FaceSurface> face_surface(const TopoDS_Face& face, const std::array<double, 4>& bounds) {
  Handle(Geom_Surface) surface = BRep_Tool::Surface(face);
  if (surface.IsNull()) return Status::invalid_argument("a face without surface");
  while (const auto trimmed = Handle(Geom_RectangularTrimmedSurface)::DownCast(surface))
    surface = trimmed->BasisSurface();
  std::string kind;
  auto made = of_kind(surface, bounds, kind);
  if (made.is_ok()) made->kind = kind;
  return made;
}

}  // namespace tessera::import::cad
