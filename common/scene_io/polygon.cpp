// SPDX-License-Identifier: Apache-2.0
#include "common/scene_io/polygon.h"

#include <algorithm>
#include <cmath>

namespace tessera {
namespace {

struct Vec3d {
  double x = 0, y = 0, z = 0;
};

Vec3d between(Vec3f from, Vec3f to) {
  return {double{to.x} - double{from.x}, double{to.y} - double{from.y},
          double{to.z} - double{from.z}};
}
Vec3d cross_of(const Vec3d& a, const Vec3d& b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
double dot_of(const Vec3d& a, const Vec3d& b) { return a.x * b.x + a.y * b.y + a.z * b.z; }

// Newell's normal, whose length is twice the area. The sum over the fan equals that over the edges.
Vec3d newell_normal(std::span<const Vec3f> corners) {
  Vec3d sum;
  Vec3d edge = between(corners[0], corners[1]);
  for (std::size_t i = 2; i < corners.size(); ++i) {
    const Vec3d next = between(corners[0], corners[i]);
    const Vec3d n = cross_of(edge, next);
    sum = {sum.x + n.x, sum.y + n.y, sum.z + n.z};
    edge = next;
  }
  return sum;
}

// Tolerance for a corner that stands into its polygon by no more than the rounding of coordinates:
// heights below 4 * 2^-24 of the largest coordinate over an edge of length |edge|.
double slack(std::span<const Vec3f> corners, const Vec3d& edge, const Vec3d& normal) {
  double largest = 0;
  for (const Vec3f& c : corners)
    largest =
        std::max({largest, std::abs(double{c.x}), std::abs(double{c.y}), std::abs(double{c.z})});
  return 0x1p-22 * largest * std::sqrt(dot_of(edge, edge) * dot_of(normal, normal));
}

}  // namespace

bool PolygonCutter::is_fan(std::span<const Vec3f> corners) {
  if (corners.size() < 4) return true;
  const Vec3d normal = newell_normal(corners);
  Vec3d edge = between(corners[0], corners[1]);
  for (std::size_t i = 2; i < corners.size(); ++i) {
    const Vec3d next = between(corners[0], corners[i]);
    const double area = dot_of(cross_of(edge, next), normal);
    if (!(area >= 0) && !(area >= -slack(corners, between(corners[i - 1], corners[i]), normal)))
      return false;
    edge = next;
  }
  return true;
}

double PolygonCutter::twice_area(std::uint32_t a, std::uint32_t b, std::uint32_t c) const {
  const Point &p = points_[a], &q = points_[b], &r = points_[c];
  return (q.x - p.x) * (r.y - p.y) - (q.y - p.y) * (r.x - p.x);
}

bool PolygonCutter::is_ear(std::uint32_t corner, Demand demand) {
  if (demand == Demand::kAny) return true;
  work_left_ -= std::min<std::uint64_t>(work_left_, 1);
  const std::uint32_t before = previous_[corner], behind = next_[corner];
  const double area = twice_area(before, corner, behind);
  if (demand == Demand::kClean ? !(area > 0) : !(area >= 0)) return false;
  work_left_ -= std::min<std::uint64_t>(work_left_, reflex_.size());
  const auto is_at = [this](std::uint32_t p, std::uint32_t q) {
    return points_[p].x == points_[q].x && points_[p].y == points_[q].y;
  };
  const auto stands_inside = [&](std::uint32_t p) {
    if (p == before || p == corner || p == behind) return false;
    const double u = twice_area(before, corner, p), v = twice_area(corner, behind, p),
                 w = twice_area(behind, before, p);
    if (demand == Demand::kTouched) return u > 0 && v > 0 && w > 0;
    return u >= 0 && v >= 0 && w >= 0 && !is_at(p, before) && !is_at(p, corner) &&
           !is_at(p, behind);
  };
  return std::none_of(reflex_.begin(), reflex_.end(), stands_inside);
}

void PolygonCutter::cut_off(std::uint32_t corner) {
  const std::uint32_t before = previous_[corner], behind = next_[corner];
  triangles_.push_back({before, corner, behind});
  next_[before] = behind;
  previous_[behind] = before;
  // Convex corners stay convex. Neighbours that stood inward may have straightened, and the corner
  // itself is gone.
  std::erase_if(reflex_, [&](std::uint32_t p) {
    return p == corner ||
           ((p == before || p == behind) && twice_area(previous_[p], p, next_[p]) > 0);
  });
}

void PolygonCutter::fan(std::size_t count) {
  is_guessed_ = true;
  for (std::uint32_t i = 2; i < count; ++i) triangles_.push_back({0, i - 1, i});
}

std::span<const PolygonCutter::Triangle> PolygonCutter::cut(std::span<const Vec3f> corners) {
  triangles_.clear();
  is_guessed_ = false;
  const auto count = static_cast<std::uint32_t>(corners.size());
  const Vec3d n = newell_normal(corners);
  const double x = std::abs(n.x), y = std::abs(n.y), z = std::abs(n.z);
  if (!(std::max({x, y, z}) > 0) || work_left_ == 0) {
    fan(count);
    return triangles_;
  }
  points_.clear();
  reflex_.clear();
  next_.resize(count);
  previous_.resize(count);
  // The projection is along the axis nearest to the normal, so that the polygon goes round to the
  // left.
  for (std::uint32_t i = 0; i < count; ++i) {
    const Vec3f& c = corners[i];
    const Point p = x >= y && x >= z ? Point{c.y, c.z} : y >= z ? Point{c.z, c.x} : Point{c.x, c.y};
    const double along = x >= y && x >= z ? n.x : y >= z ? n.y : n.z;
    points_.push_back(along > 0 ? p : Point{p.y, p.x});
    next_[i] = i + 1 < count ? i + 1 : 0;
    previous_[i] = i > 0 ? i - 1 : count - 1;
  }
  for (std::uint32_t i = 0; i < count; ++i) {
    if (!(twice_area(previous_[i], i, next_[i]) > 0)) reflex_.push_back(i);
  }
  std::uint32_t at = 1, refused = 0;
  Demand demand = Demand::kClean;
  for (std::uint32_t left = count; left > 3;) {
    if (work_left_ == 0) demand = Demand::kAny;
    if (is_ear(at, demand)) {
      is_guessed_ = is_guessed_ || demand == Demand::kAny;
      const std::uint32_t behind = next_[at];
      cut_off(at);
      at = behind;
      --left;
      refused = 0;
      demand = Demand::kClean;
    } else {
      at = next_[at];
      if (++refused < left) continue;
      demand = demand == Demand::kClean ? Demand::kTouched : Demand::kAny;
      refused = 0;
    }
  }
  // The triangle that is left over turns the other way where edges have crossed.
  is_guessed_ = is_guessed_ || twice_area(previous_[at], at, next_[at]) < 0;
  triangles_.push_back({previous_[at], at, next_[at]});
  return triangles_;
}

}  // namespace tessera
