// SPDX-License-Identifier: Apache-2.0
#include "common/viewpoint/axis_rays.h"

#include <algorithm>
#include <cmath>

namespace tessera {
namespace {

constexpr int kSide = AxisRays::kSide;
constexpr std::size_t kGaps = kSide + 1;
// The points stand a little beside the middles of their cells, so that no ray runs along the
// middle of a symmetric model, where its seams are.
constexpr Vec3d kShift{0.0618, 0.0382, -0.0236};
// Surfaces this near to each other, in lattice units, are two sides of one sheet.
constexpr float kSheetThickness = 1.0f / (1 << 20);

// The lines of one axis are numbered by their places along the next two axes.
std::size_t line_of(int b, int c) { return static_cast<std::size_t>(c * kSide + b); }

std::size_t number(Axis axis) { return static_cast<std::size_t>(axis); }

// The whole numbers in [low, high] that are places on the lattice, as [first, last]. Conversions to
// int take the place of ceil() and floor(), because most triangles of a large scene end here.
struct Places {
  int first, last;
  Places(double low, double high) {
    const double from = std::clamp<double>(low, 0, kSide);
    first = static_cast<int>(from);
    first += first < from;
    last = high >= 0 ? static_cast<int>(std::min<double>(high, kSide - 1)) : -1;
  }
  bool is_empty() const { return first > last; }
};

// Where a triangle's plane section at u = i begins and ends along v, and at which t.
struct Section {
  double v_low = kSide, t_low = 0, v_high = -1, t_high = 0;

  void add(double v, double t) {
    if (v < v_low) {
      v_low = v;
      t_low = t;
    }
    if (v > v_high) {
      v_high = v;
      t_high = t;
    }
  }
  double t(double v) const {
    return v_high > v_low ? t_low + (v - v_low) / (v_high - v_low) * (t_high - t_low) : t_low;
  }
};

}  // namespace

AxisRays::AxisRays(const Scene& scene, const Bounds3f& bounds) : bounds_(bounds) {
  const Vec3d extent =
      bounds_.is_empty() ? Vec3d{} : widened(bounds_.upper) - widened(bounds_.lower);
  if (!(extent.x > 0 && extent.y > 0 && extent.z > 0)) return;
  step_ = (1.0 / kSide) * extent;
  per_step_ = {1 / step_.x, 1 / step_.y, 1 / step_.z};
  origin_ = {bounds_.lower.x + (0.5 + kShift.x) * step_.x,
             bounds_.lower.y + (0.5 + kShift.y) * step_.y,
             bounds_.lower.z + (0.5 + kShift.z) * step_.z};
  std::array<Gaps, 3> gaps;
  for (Gaps& g : gaps) {
    g.seen_from_below.assign(kGaps * kSide * kSide, {Bounds3f::kInf, false});
    g.seen_from_above.assign(kGaps * kSide * kSide, {-Bounds3f::kInf, false});
  }
  std::uint64_t crossings = 0;
  for (const Instance& instance : scene.instances) {
    if (instance.kind != ObjectKind::kMesh) continue;
    const Mesh& mesh = *scene.meshes[instance.mesh];
    for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
      const Triangle triangle = on_lattice(mesh, t, instance.object_to_world);
      const std::uint32_t material = mesh.materials[mesh.materials.size() == 1 ? 0 : t];
      crossings += draw(triangle, scene.materials[material].is_double_sided, gaps);
      if (crossings > kCrossingsMax) return;
    }
  }
  for (int axis = 0; axis < 3; ++axis) sweep(axis, gaps[static_cast<std::size_t>(axis)]);
}

AxisRays::Triangle AxisRays::on_lattice(const Mesh& mesh, std::size_t triangle,
                                        const Transform& transform) const {
  Triangle result;
  for (std::size_t corner = 0; corner < 3; ++corner) {
    const Vec3d p = widened(transform.point(mesh.positions[mesh.triangles[triangle][corner]]));
    const Vec3d offset = p - origin_;
    result[corner] = {offset.x * per_step_.x, offset.y * per_step_.y, offset.z * per_step_.z};
  }
  return result;
}

// Returns: how many rays the triangle's box spans.
std::uint64_t AxisRays::draw(const Triangle& triangle, bool is_double_sided,
                             std::array<Gaps, 3>& gaps) {
  const auto range = [&](int i) {
    return Places(std::min({triangle[0][i], triangle[1][i], triangle[2][i]}),
                  std::max({triangle[0][i], triangle[1][i], triangle[2][i]}));
  };
  const std::array<Places, 3> ranges{range(0), range(1), range(2)};
  std::uint64_t spanned = 0;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const Places &us = ranges[(axis + 1) % 3], &vs = ranges[(axis + 2) % 3];
    if (us.is_empty() || vs.is_empty()) continue;
    draw_along(static_cast<int>(axis), triangle, us.first, us.last, is_double_sided, gaps[axis]);
    spanned += static_cast<std::uint64_t>(us.last - us.first + 1) *
               static_cast<std::uint64_t>(vs.last - vs.first + 1);
  }
  return spanned;
}

void AxisRays::draw_along(int axis, const Triangle& triangle, int u_first, int u_last,
                          bool is_double_sided, Gaps& gaps) {
  const int b = (axis + 1) % 3, c = (axis + 2) % 3;
  const Vec3d e1 = triangle[1] - triangle[0], e2 = triangle[2] - triangle[0];
  const double facing = e1[b] * e2[c] - e1[c] * e2[b];  // the normal's part along the axis
  if (!(facing != 0)) return;
  const bool is_front_from_above = facing > 0 || is_double_sided;
  const bool is_front_from_below = facing < 0 || is_double_sided;
  for (int u = u_first; u <= u_last; ++u) {
    Section section;
    for (std::size_t i = 0; i < 3; ++i) {
      const Vec3d &p = triangle[i], &q = triangle[(i + 1) % 3];
      if (!(std::min(p[b], q[b]) <= u && u <= std::max(p[b], q[b]))) continue;
      const double share = q[b] != p[b] ? (u - p[b]) / (q[b] - p[b]) : 0;
      section.add(p[c] + share * (q[c] - p[c]), p[axis] + share * (q[axis] - p[axis]));
      if (q[b] == p[b]) section.add(q[c], q[axis]);
    }
    const Places along(section.v_low, section.v_high);
    for (int v = along.first; v <= along.last; ++v) {
      const double t = section.t(v);
      const auto gap = static_cast<std::size_t>(std::ceil(std::clamp<double>(t, 0, kSide)));
      const std::size_t slot = line_of(u, v) * kGaps + gap;
      const auto at = static_cast<float>(t);
      GapEnd& below = gaps.seen_from_below[slot];
      if (std::abs(at - below.at) <= kSheetThickness) {
        below.is_front |= is_front_from_below;
      } else if (at < below.at) {
        below = {at, is_front_from_below};
      }
      GapEnd& above = gaps.seen_from_above[slot];
      if (std::abs(at - above.at) <= kSheetThickness) {
        above.is_front |= is_front_from_above;
      } else if (at > above.at) {
        above = {at, is_front_from_above};
      }
    }
  }
}

void AxisRays::sweep(int axis, const Gaps& gaps) {
  const auto upward = static_cast<std::size_t>(2 * axis), downward = upward + 1;
  for (const std::size_t way : {upward, downward}) {
    met_[way].resize(kPoints);
    met_outside_[way].resize(kSide * kSide);
  }
  const int b = (axis + 1) % 3, c = (axis + 2) % 3;
  const double step = step_[axis], low_side = -0.5 - kShift[axis];
  const auto coded = [&](const GapEnd& end, double from) {
    const auto distance = static_cast<float>(std::abs(end.at - from) * step);
    return std::isinf(end.at) || end.is_front ? distance : -distance;
  };
  for (int v = 0; v < kSide; ++v) {
    for (int u = 0; u < kSide; ++u) {
      const std::size_t line = line_of(u, v);
      const auto slot = [&](int along) {
        std::array<int, 3> place{};
        place[static_cast<std::size_t>(axis)] = along;
        place[static_cast<std::size_t>(b)] = u;
        place[static_cast<std::size_t>(c)] = v;
        return static_cast<std::size_t>(index(place[0], place[1], place[2]));
      };
      GapEnd seen{Bounds3f::kInf, false};
      for (int along = kSide; along >= 0; --along) {
        const GapEnd& gap = gaps.seen_from_below[line * kGaps + static_cast<std::size_t>(along)];
        if (!std::isinf(gap.at)) seen = gap;
        if (along > 0) met_[upward][slot(along - 1)] = coded(seen, along - 1);
      }
      met_outside_[upward][line] = coded(seen, low_side);
      seen = {-Bounds3f::kInf, false};
      for (int along = 0; along <= kSide; ++along) {
        const GapEnd& gap = gaps.seen_from_above[line * kGaps + static_cast<std::size_t>(along)];
        if (!std::isinf(gap.at)) seen = gap;
        if (along < kSide) met_[downward][slot(along)] = coded(seen, along);
      }
      met_outside_[downward][line] = coded(seen, low_side + kSide);
    }
  }
}

Vec3d AxisRays::point(int index) const {
  const auto [x, y, z] = place(index);
  return {origin_.x + x * step_.x, origin_.y + y * step_.y, origin_.z + z * step_.z};
}

AxisRays::Met AxisRays::met_from_outside(int index, Axis axis) const {
  const std::size_t way = number(axis), along = way / 2;
  const std::array<int, 3> at = place(index);
  const float d = met_outside_[way][line_of(at[(along + 1) % 3], at[(along + 2) % 3])];
  return {std::abs(d), !std::signbit(d)};
}

}  // namespace tessera
