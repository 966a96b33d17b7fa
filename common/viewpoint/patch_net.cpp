// SPDX-License-Identifier: Apache-2.0
#include "common/viewpoint/patch_net.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace tessera {
namespace {

constexpr int kHalvingsMax = 4;
constexpr int kCellsMax = 8;
constexpr int kCurveSteps = 8;  // lines that stand for a curved segment of a loop

constexpr std::size_t kPointsOfCurveMax = kPatchDegreesMax + 1;

// w x, w y, w z, w.
using Homogeneous = std::array<double, 4>;

Homogeneous between(const Homogeneous& a, const Homogeneous& b, double t) {
  Homogeneous r;
  for (std::size_t k = 0; k < 4; ++k) r[k] = (1 - t) * a[k] + t * b[k];
  return r;
}

Vec3f point_of(const Homogeneous& h) {
  return {static_cast<float>(h[0] / h[3]), static_cast<float>(h[1] / h[3]),
          static_cast<float>(h[2] / h[3])};
}

// B_0 to B_degree at t.
std::array<double, kPointsOfCurveMax> bernstein(std::size_t degree, double t) {
  std::array<double, kPointsOfCurveMax> b{1};
  for (std::size_t n = 1; n <= degree; ++n) {
    for (std::size_t i = n; i > 0; --i) b[i] = (1 - t) * b[i] + t * b[i - 1];
    b[0] *= 1 - t;
  }
  return b;
}

// A part of a patch's square.
struct UvBox {
  double u_low = 0, u_high = 1, v_low = 0, v_high = 1;
};

// The box of what a patch keeps of its square, as far as boxes tell.
UvBox kept_box(const PatchSurface& surface, const PatchCursor& patch) {
  UvBox box;
  if (patch.loop_count() == 0 || patch.form().keeps_outside != 0) return box;
  PatchCursor next = patch;
  next.advance();
  box = {1, 0, 1, 0};
  for (std::size_t i = patch.first_trim_point(); i < next.first_trim_point(); ++i) {
    const double u = surface.trim_points[i].u, v = surface.trim_points[i].v;
    box = {std::min(box.u_low, u), std::max(box.u_high, u), std::min(box.v_low, v),
           std::max(box.v_high, v)};
  }
  return box;
}

// The control points of a patch, or of a part of one, which are [degree_u + 1][degree_v + 1].
class Net {
 public:
  Net(const PatchCursor& patch, const UvBox& box)
      : rows_(std::size_t{patch.form().degree_u} + 1),
        columns_(std::size_t{patch.form().degree_v} + 1),
        points_(rows_ * columns_) {
    for (std::size_t i = 0; i < points_.size(); ++i) {
      const double w = patch.weight(i);
      const Vec3f p = patch.point(i);
      points_[i] = {w * p.x, w * p.y, w * p.z, w};
    }
    for (const bool is_v : {false, true}) {
      const double low = is_v ? box.v_low : box.u_low, high = is_v ? box.v_high : box.u_high;
      if (high < 1) *this = cut(is_v, high).first;
      if (low > 0) *this = cut(is_v, low / high).second;
    }
  }

  // The two parts below and above t along u, or along v.
  std::pair<Net, Net> cut(bool is_v, double t) const {
    std::pair<Net, Net> parts{*this, *this};
    const std::size_t count = is_v ? columns_ : rows_, stride = is_v ? 1 : columns_;
    const std::size_t curves = is_v ? rows_ : columns_, next_curve = is_v ? columns_ : 1;
    for (std::size_t c = 0; c < curves; ++c) {
      const auto at = [&](std::size_t i) { return c * next_curve + i * stride; };
      std::array<Homogeneous, kPointsOfCurveMax> work;
      for (std::size_t i = 0; i < count; ++i) work[i] = points_[at(i)];
      for (std::size_t step = 0; step < count; ++step) {
        const std::size_t last = count - 1 - step;
        parts.first.points_[at(step)] = work[0];
        parts.second.points_[at(last)] = work[last];
        for (std::size_t i = 0; i < last; ++i) work[i] = between(work[i], work[i + 1], t);
      }
    }
    return parts;
  }

  void add_halves(int halvings, std::vector<Vec3f>& to) const {
    if (halvings == 0) {
      for (const Homogeneous& h : points_) to.push_back(point_of(h));
      return;
    }
    const auto [low, high] = cut(false, 0.5);
    for (const Net* half : {&low, &high}) {
      const auto [left, right] = half->cut(true, 0.5);
      left.add_halves(halvings - 1, to);
      right.add_halves(halvings - 1, to);
    }
  }

  // Point (u, v) of the part, each in [0, 1], from Bernstein's sums of both.
  Vec3f at(double u, double v) const {
    const auto in_u = bernstein(rows_ - 1, u), in_v = bernstein(columns_ - 1, v);
    Homogeneous sum{};
    for (std::size_t i = 0; i < rows_; ++i) {
      for (std::size_t j = 0; j < columns_; ++j) {
        for (std::size_t k = 0; k < 4; ++k)
          sum[k] += in_u[i] * in_v[j] * points_[i * columns_ + j][k];
      }
    }
    return point_of(sum);
  }

 private:
  std::size_t rows_, columns_;
  std::vector<Homogeneous> points_;
};

// Which cells of a patch's box have their middle in what the loops leave: to their right an odd
// number of lines, which stand for the loops, crosses the row of middles.
class KeptCells {
 public:
  KeptCells(const PatchSurface& surface, const PatchCursor& patch, const UvBox& box, int cells)
      : box_(box), cells_(cells), keeps_outside_(patch.form().keeps_outside != 0) {
    if (patch.loop_count() == 0) return;
    crossings_.resize(static_cast<std::size_t>(cells));
    std::size_t segment = patch.first_segment(), point = patch.first_trim_point();
    for (std::size_t i = 0; i < patch.loop_count(); ++i) {
      std::vector<UvPoint> corners;
      const std::size_t first_point = point;
      const std::size_t end = segment + surface.segment_counts[patch.first_loop() + i];
      for (; segment < end; ++segment) {
        const std::size_t degree = surface.degrees[segment];
        std::array<TrimPoint, kPointsOfCurveMax> points;
        for (std::size_t k = 0; k <= degree; ++k) {
          const bool is_closing = k == degree && segment + 1 == end;
          points[k] = surface.trim_points[is_closing ? first_point : point + k];
        }
        add_corners(degree, points, corners);
        point += degree;
      }
      for (std::size_t c = 0; c < corners.size(); ++c)
        cross(corners[c], corners[c + 1 < corners.size() ? c + 1 : 0]);
    }
  }

  bool keeps(int i, int j) const {
    if (crossings_.empty()) return true;
    const double u = middle(box_.u_low, box_.u_high, i);
    const auto& row = crossings_[static_cast<std::size_t>(j)];
    const auto beyond = std::count_if(row.begin(), row.end(), [&](double at) { return at > u; });
    return (beyond % 2 == 1) != keeps_outside_;
  }

 private:
  struct UvPoint {
    double u, v;
  };

  double middle(double low, double high, int cell) const {
    return low + (high - low) * (cell + 0.5) / cells_;
  }

  // Adds points of a segment but its last one.
  static void add_corners(std::size_t degree,
                          const std::array<TrimPoint, kPointsOfCurveMax>& points,
                          std::vector<UvPoint>& corners) {
    const int steps = degree == 1 ? 1 : kCurveSteps;
    for (int step = 0; step < steps; ++step) {
      const auto b = bernstein(degree, static_cast<double>(step) / steps);
      double u = 0, v = 0, w = 0;
      for (std::size_t k = 0; k <= degree; ++k) {
        const double share = b[k] * points[k].weight;
        u += share * points[k].u;
        v += share * points[k].v;
        w += share;
      }
      corners.push_back({u / w, v / w});
    }
  }

  void cross(UvPoint a, UvPoint b) {
    for (int j = 0; j < cells_; ++j) {
      const double v = middle(box_.v_low, box_.v_high, j);
      if ((a.v > v) == (b.v > v)) continue;
      crossings_[static_cast<std::size_t>(j)].push_back(a.u +
                                                        (v - a.v) / (b.v - a.v) * (b.u - a.u));
    }
  }

  const UvBox box_;
  const int cells_;
  const bool keeps_outside_;
  std::vector<std::vector<double>> crossings_;  // [row]: where lines cross it; empty: no loops
};

std::shared_ptr<const Mesh> mesh_of(const PatchSurface& surface, int cells) {
  auto mesh = std::make_shared<Mesh>();
  for (PatchCursor patch(surface); patch.is_any(); patch.advance()) {
    const UvBox box = kept_box(surface, patch);
    const Net net(patch, box);
    const KeptCells kept(surface, patch, box, cells);
    const auto first = static_cast<std::uint32_t>(mesh->positions.size());
    const auto side = static_cast<std::uint32_t>(cells);
    for (int i = 0; i <= cells; ++i) {
      for (int j = 0; j <= cells; ++j)
        mesh->positions.push_back(net.at(double(i) / cells, double(j) / cells));
    }
    for (std::uint32_t i = 0; i < side; ++i) {
      for (std::uint32_t j = 0; j < side; ++j) {
        if (!kept.keeps(static_cast<int>(i), static_cast<int>(j))) continue;
        const std::uint32_t a = first + i * (side + 1) + j, b = a + side + 1;
        mesh->triangles.push_back({a, b, b + 1});
        mesh->triangles.push_back({a, b + 1, a + 1});
        mesh->materials.insert(mesh->materials.end(), 2, patch.material());
      }
    }
  }
  if (mesh->triangles.empty()) mesh->materials = {0};
  return mesh;
}

// Cells along a side of a patch, of which the meshes have four million at most.
int cells_for(std::uint64_t patch_count) {
  int cells = kCellsMax;
  while (cells > 1 && patch_count * static_cast<std::uint64_t>(cells * cells) > kNetPointsMax)
    cells /= 2;
  return cells;
}

}  // namespace

std::vector<Vec3f> fine_net(const PatchSurface& surface) {
  std::uint64_t count = 0;
  for (const PatchForm& form : surface.patches) count += form.point_count();
  int halvings = kHalvingsMax;
  while (halvings > 0 && count << 2 * halvings > kNetPointsMax) --halvings;
  std::vector<Vec3f> points;
  points.reserve(count << 2 * halvings);
  for (PatchCursor patch(surface); patch.is_any(); patch.advance())
    Net(patch, kept_box(surface, patch)).add_halves(halvings, points);
  return points;
}

Scene with_meshes_for_surfaces(const Scene& scene) {
  Scene result = scene;
  std::uint64_t patch_count = 0;
  for (const auto& surface : scene.surfaces) patch_count += surface->patches.size();
  const auto first = static_cast<std::uint32_t>(scene.meshes.size());
  for (const auto& surface : scene.surfaces)
    result.meshes.push_back(mesh_of(*surface, cells_for(patch_count)));
  for (Instance& instance : result.instances) {
    if (instance.kind == ObjectKind::kPatchSurface)
      instance = {first + instance.mesh, instance.object_to_world, ObjectKind::kMesh};
  }
  result.surfaces.clear();
  return result;
}

}  // namespace tessera
