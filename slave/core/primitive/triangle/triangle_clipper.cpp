// SPDX-License-Identifier: Apache-2.0
#include "slave/core/primitive/triangle/triangle_clipper.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

namespace tessera::core {
namespace {

// What is left of a triangle after cuts. Each face that cuts it adds a corner. Where roundings have
// bent a thin polygon, a face may add half as many corners as there are, at most: 3, 4, 6, 9, 13,
// 19, 28 for six faces.
struct Polygon {
  double corner[28][3];
  int count = 0;

  void add(const double* p) {
    for (int a = 0; a < 3; ++a) corner[count][a] = p[a];
    ++count;
  }
};

// Sutherland and Hodgman, "Reentrant polygon clipping", 1974. side +1 keeps what is above the
// plane, -1 what is below; what lies in the plane stays.
void cut(const Polygon& polygon, int axis, double plane, double side, Polygon& kept) {
  kept.count = 0;
  for (int i = 0; i < polygon.count; ++i) {
    const double* const p = polygon.corner[i];
    const double* const q = polygon.corner[(i + 1) % polygon.count];
    const double from = side * (p[axis] - plane), to = side * (q[axis] - plane);
    if (from >= 0) kept.add(p);
    if ((from > 0 && to < 0) || (from < 0 && to > 0)) {
      const double t = from / (from - to);
      double middle[3];
      for (int a = 0; a < 3; ++a) middle[a] = p[a] + t * (q[a] - p[a]);
      middle[axis] = plane;
      kept.add(middle);
    }
  }
}

// Whether a cut would change the polygon. Most planes cut nothing off.
bool is_beyond(const Polygon& polygon, int axis, double plane, double side) {
  for (int i = 0; i < polygon.count; ++i) {
    if (!(side * (polygon.corner[i][axis] - plane) >= 0)) return true;
  }
  return false;
}

}  // namespace

// A corner made by cut() is off by at most 4 roundings of double of the largest coordinate of the
// triangle, and it may be cut again, up to six times: 32 of them in all, moved out before the box
// is rounded to float32, outwards, too. The planes are moved out by as much.
Bounds3f TriangleClipper::clip(std::uint32_t triangle, const Bounds3f& voxel) const {
  const float* const v = vertices_.data() + std::size_t{9} * triangle;
  Polygon polygon, half;
  double largest = 0;
  for (int c = 0; c < 3; ++c) {
    double corner[3];
    for (int a = 0; a < 3; ++a) {
      corner[a] = static_cast<double>(v[3 * c + a]);
      largest = std::max(largest, std::fabs(corner[a]));
    }
    polygon.add(corner);
  }
  const double slack = largest * 0x1p-48;
  Polygon* from = &polygon;
  Polygon* to = &half;
  const auto keep = [&](int axis, double plane, double side) {
    if (!is_beyond(*from, axis, plane, side)) return;
    cut(*from, axis, plane, side, *to);
    std::swap(from, to);
  };
  for (int a = 0; a < 3; ++a) {
    keep(a, static_cast<double>(voxel.lower[a]) - slack, 1);
    keep(a, static_cast<double>(voxel.upper[a]) + slack, -1);
  }
  const Polygon& left = *from;
  if (left.count == 0) return {};
  Vec3f lower, upper;
  const auto set = [](Vec3f& to, int axis, float value) {
    (axis == 0 ? to.x : axis == 1 ? to.y : to.z) = value;
  };
  for (int a = 0; a < 3; ++a) {
    double low = left.corner[0][a], high = low;
    for (int i = 1; i < left.count; ++i) {
      low = std::min(low, left.corner[i][a]);
      high = std::max(high, left.corner[i][a]);
    }
    constexpr float kInfinity = std::numeric_limits<float>::infinity();
    const auto outward = [](double value, float towards) {
      const auto rounded = static_cast<float>(value);
      const bool is_inside =
          towards < 0 ? static_cast<double>(rounded) > value : static_cast<double>(rounded) < value;
      return is_inside ? std::nextafter(rounded, towards) : rounded;
    };
    set(lower, a, std::max(outward(low - slack, -kInfinity), voxel.lower[a]));
    set(upper, a, std::min(outward(high + slack, kInfinity), voxel.upper[a]));
  }
  return {lower, upper};
}

}  // namespace tessera::core
