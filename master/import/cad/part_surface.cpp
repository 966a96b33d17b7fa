// SPDX-License-Identifier: Apache-2.0
#include "master/import/cad/part_surface.h"

#include <BRep_Tool.hxx>
#include <Standard_Failure.hxx>
#include <TopExp.hxx>
#include <TopExp_Explorer.hxx>
#include <TopTools_IndexedDataMapOfShapeListOfShape.hxx>
#include <TopTools_IndexedMapOfShape.hxx>
#include <TopoDS.hxx>
#include <TopoDS_Face.hxx>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <set>

#include "master/import/cad/cell_trims.h"
#include "master/import/cad/edge_gaps.h"
#include "master/import/cad/face_loops.h"
#include "master/import/cad/face_surface.h"

namespace tessera::import::cad {
namespace {

std::string number_text(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%.3g", value);
  return text;
}

struct Inexact {
  int face_count = 0, edge_count = 0, open_count = 0, overrun_count = 0;
  double face_error = 0, edge_error = 0, overrun_error = 0;
};

class PartWriter {
 public:
  PartWriter(const TopoDS_Shape& part, const FaceMaterial& material) : material_(material) {
    TopExp::MapShapes(part, TopAbs_EDGE, edges_);
    TopTools_IndexedDataMapOfShapeListOfShape faces;
    TopExp::MapShapesAndAncestors(part, TopAbs_EDGE, TopAbs_FACE, faces);
    for (int i = 1; i <= edges_.Extent(); ++i)
      is_shared_.push_back(is_of_several(faces.FindFromKey(edges_(i))));
  }

  void add(const TopoDS_Face& face) {
    PartFace entry;
    entry.first_patch = surface_.patches.size();
    std::string reason = "no part of its surface lies in it";
    try {
      const Status status = try_add(face, entry.kind);
      if (!status.is_ok()) reason = status.message();
    } catch (const Standard_Failure& failure) {
      reason = failure.GetMessageString();
    }
    entry.patch_count = surface_.patches.size() - entry.first_patch;
    if (entry.patch_count == 0)
      report_.lost.push_back("face " + std::to_string(report_.faces.size() + 1) + " (" +
                             (entry.kind.empty() ? "no surface" : entry.kind) +
                             ") is left out: " + reason);
    report_.faces.push_back(std::move(entry));
  }

  PartSurface finish() {
    const EdgeGaps gaps = measure_gaps(surface_, uses_, static_cast<std::size_t>(edges_.Extent()));
    surface_.trim_widths.assign(surface_.degrees.size(), 0);
    for (const EdgeUse& use : uses_) {
      surface_.trim_widths[use.segment] =
          static_cast<float>(gaps.widths[static_cast<std::size_t>(use.edge)]);
    }
    if (surface_.degrees.empty()) surface_.loop_counts.clear();
    report_.shared_edges = gaps.shared;
    report_.open_edges = gaps.open;
    report_.gap_max = gaps.largest;
    if (inexact_.face_count > 0)
      warn(inexact_.face_count,
           "faces are of surfaces that no rational patch has: approximated, by ",
           inexact_.face_error);
    if (inexact_.edge_count > 0)
      warn(inexact_.edge_count, "edges had no curve on their surface: projected, off by ",
           inexact_.edge_error);
    if (inexact_.overrun_count > 0)
      warn(inexact_.overrun_count,
           "edges run beyond the end of their surface, whose border they follow instead, by ",
           inexact_.overrun_error);
    if (inexact_.open_count > 0)
      warn(inexact_.open_count, "loops did not close and were closed by a line", 0);
    return {std::move(surface_), std::move(report_)};
  }

 private:
  void warn(int count, const char* what, double error) {
    report_.warnings.push_back(std::to_string(count) + " " + what +
                               (error > 0 ? number_text(error) + " at most" : ""));
  }

  Status try_add(const TopoDS_Face& face, std::string& kind) {
    const auto loops = face_loops(face, edges_);
    if (!loops.is_ok()) return loops.status();
    const auto surface = face_surface(face, loops->bounds);
    if (!surface.is_ok()) return surface.status();
    kind = surface->kind;
    const auto shared_out = share_out(loops->loops, surface->u, surface->v);
    if (!shared_out.is_ok()) return shared_out.status();
    const FaceTrims& trims = *shared_out;
    if (surface->approximation > 0) {
      ++inexact_.face_count;
      inexact_.face_error = std::max(inexact_.face_error, surface->approximation);
    }
    inexact_.edge_count += loops->projected_count;
    inexact_.edge_error = std::max(inexact_.edge_error, loops->projected_error);
    inexact_.open_count += trims.open_count;
    add_overruns(*surface, trims);
    const bool is_reversed = face.Orientation() == TopAbs_REVERSED;
    const std::uint32_t material = material_(face);
    std::vector<std::vector<Curve2>> shared(trims.cells.size());
    for (const BorderCurve& border : trims.borders) {
      if (is_shared_[static_cast<std::size_t>(border.curve.edge)])
        shared[border.cell].push_back(border.curve);
    }
    for (std::size_t cell = 0; cell < trims.cells.size(); ++cell) {
      if (!trims.cells[cell].is_kept) continue;
      if (add_patch(surface->patches[cell], trims.cells[cell], shared[cell], is_reversed))
        surface_.materials.push_back(material);
    }
    return Status::ok();
  }

  void add_overruns(const FaceSurface& surface, const FaceTrims& trims) {
    std::set<int> edges;
    for (const Overrun& overrun : trims.overruns) {
      const BezierPatch& patch = surface.patches[overrun.cell];
      const Control3 a = patch.at(overrun.place.u, overrun.place.v);
      const Control3 b = patch.at(overrun.border.u, overrun.border.v);
      const double error = std::hypot(a.x - b.x, a.y - b.y, a.z - b.z);
      // What single precision would not tell is no error of this.
      if (error <= 0x1p-24 * std::hypot(b.x, b.y, b.z)) continue;
      inexact_.overrun_error = std::max(inexact_.overrun_error, error);
      edges.insert(overrun.edge);
    }
    inexact_.overrun_count += static_cast<int>(edges.size());
  }

  static bool is_of_several(const TopTools_ListOfShape& faces) {
    for (const TopoDS_Shape& face : faces)
      if (!face.IsSame(faces.First())) return true;
    return false;
  }

  int face_number() const { return static_cast<int>(report_.faces.size()); }

  static Curve2 mirrored(Curve2 curve) {
    for (Control2& p : curve.points) p.u = 1 - p.u;
    return curve;
  }

  static TrimPoint trim_point(const Control2& p) {
    return {static_cast<float>(p.u), static_cast<float>(p.v), static_cast<float>(p.weight)};
  }

  // Adds a patch with its loops. An edge along the patch's border trims nothing, but has a width:
  // it becomes a loop of its own, along the border and back.
  // Returns: whether anything of the patch is left in single precision.
  bool add_patch(const BezierPatch& patch, const CellTrims& trims,
                 const std::vector<Curve2>& along_border, bool is_reversed) {
    PatchForm form;
    form.degree_u = static_cast<std::uint8_t>(patch.degree_u);
    form.degree_v = static_cast<std::uint8_t>(patch.degree_v);
    form.is_rational = patch.is_rational ? 1 : 0;
    form.keeps_outside = trims.keeps_outside && !trims.loops.empty() ? 1 : 0;
    const std::vector<float> numbers = rounded_numbers(patch, is_reversed);
    if (is_line(form, numbers)) return false;
    std::vector<const std::vector<Curve2>*> kept;
    for (const auto& loop : trims.loops)
      if (has_extent(loop)) kept.push_back(&loop);
    if (kept.empty() && !trims.loops.empty() && !trims.keeps_outside) return false;
    std::vector<std::vector<Curve2>> retraced;
    for (const Curve2& given : along_border) {
      // A line, whatever its degree, as it lies on the border.
      Curve2 curve{{given.points.front(), given.points.back()}, given.edge};
      if (!std::ranges::all_of(given.points,
                               [&](const Control2& p) { return is_between(curve, p); }))
        curve = given;
      Curve2 back = reversed(curve);
      back.edge = -1;
      retraced.push_back({curve, std::move(back)});
      if (!has_extent(retraced.back())) retraced.pop_back();
    }
    if (kept.empty()) form.keeps_outside = retraced.empty() ? 0 : 1;
    for (const auto& loop : retraced) kept.push_back(&loop);
    const std::size_t number = surface_.patches.size();
    surface_.patches.push_back(form);
    surface_.numbers.insert(surface_.numbers.end(), numbers.begin(), numbers.end());
    surface_.loop_counts.push_back(static_cast<std::uint32_t>(kept.size()));
    for (const auto* loop : kept) add_loop(*loop, number, is_reversed);
    return true;
  }

  static std::vector<float> rounded_numbers(const BezierPatch& patch, bool is_reversed) {
    std::vector<float> numbers;
    const int rows = patch.degree_u + 1, columns = patch.degree_v + 1;
    for (int i = 0; i < rows; ++i) {
      for (int j = 0; j < columns; ++j) {
        const int row = is_reversed ? rows - 1 - i : i;
        const Control3& p = patch.points[static_cast<std::size_t>(columns * row + j)];
        for (const double x : {p.x, p.y, p.z}) numbers.push_back(static_cast<float>(x));
        if (patch.is_rational) numbers.push_back(static_cast<float>(p.weight));
      }
    }
    return numbers;
  }

  static bool is_between(const Curve2& line, const Control2& p) {
    const auto is_in = [](double x, double a, double b) {
      return x >= std::min(a, b) && x <= std::max(a, b);
    };
    const Point2 a = line.first(), b = line.last();
    return is_in(p.u, a.u, b.u) && is_in(p.v, a.v, b.v);
  }

  // Whether the patch has no area, since all of its rows are one, or all of its columns.
  static bool is_line(const PatchForm& form, const std::vector<float>& numbers) {
    const std::size_t columns = form.degree_v + std::size_t{1};
    const std::size_t width = form.is_rational != 0 ? 4 : 3;
    bool are_rows_one = true, are_columns_one = true;
    for (std::size_t i = 0; i < form.point_count(); ++i) {
      const auto is_at = [&](std::size_t other) {
        const auto p = numbers.begin() + static_cast<std::ptrdiff_t>(width * i);
        return std::equal(p, p + 3, numbers.begin() + static_cast<std::ptrdiff_t>(width * other));
      };
      are_rows_one = are_rows_one && is_at(i % columns);
      are_columns_one = are_columns_one && is_at(i - i % columns);
    }
    return are_rows_one || are_columns_one;
  }

  static bool has_extent(const std::vector<Curve2>& loop) {
    const TrimPoint first = trim_point(loop.front().points.front());
    for (const Curve2& curve : loop) {
      for (const Control2& p : curve.points) {
        const TrimPoint q = trim_point(p);
        if (q.u != first.u || q.v != first.v) return true;
      }
    }
    return false;
  }

  void add_loop(const std::vector<Curve2>& loop, std::size_t patch, bool is_reversed) {
    surface_.segment_counts.push_back(static_cast<std::uint32_t>(loop.size()));
    for (const Curve2& given : loop) {
      const Curve2 curve = with_end_weights_1(is_reversed ? mirrored(given) : given);
      if (curve.edge >= 0)
        uses_.push_back({curve.edge, face_number(), patch, surface_.degrees.size(), curve});
      surface_.degrees.push_back(static_cast<std::uint8_t>(curve.degree()));
      for (std::size_t i = 0; i < curve.degree(); ++i)
        surface_.trim_points.push_back(trim_point(curve.points[i]));
    }
  }

  const FaceMaterial& material_;
  TopTools_IndexedMapOfShape edges_;
  std::vector<bool> is_shared_;  // [edge_count] by two faces or more
  PatchSurface surface_;
  PartReport report_;
  std::vector<EdgeUse> uses_;
  Inexact inexact_;
};

}  // namespace

PartSurface part_surface(const TopoDS_Shape& part, const FaceMaterial& material) {
  PartWriter writer(part, material);
  for (TopExp_Explorer face(part, TopAbs_FACE); face.More(); face.Next())
    writer.add(TopoDS::Face(face.Current()));
  return writer.finish();
}

}  // namespace tessera::import::cad
