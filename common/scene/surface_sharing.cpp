// SPDX-License-Identifier: Apache-2.0
#include "common/scene/surface_sharing.h"

#include <algorithm>
#include <cmath>

#include "common/math/bounds3.h"
#include "common/math/transform_checks.h"

namespace tessera {
namespace {

using Matrix = std::array<std::array<double, 3>, 3>;

// Requires: the map is not singular.
Matrix inverse_of(const Transform& t) {
  Matrix inverse{};
  double determinant = 0;
  for (std::size_t i = 0; i < 3; ++i) {
    const auto at = [&](std::size_t row, std::size_t column) {
      return double{t.m[(i + row) % 3][column % 3]};
    };
    for (std::size_t j = 0; j < 3; ++j)
      inverse[j][i] = at(1, j + 1) * at(2, j + 2) - at(1, j + 2) * at(2, j + 1);
    if (i == 0)
      for (std::size_t j = 0; j < 3; ++j) determinant += at(0, j) * inverse[j][0];
  }
  for (auto& row : inverse)
    for (double& value : row) value /= determinant;
  return inverse;
}

}  // namespace

SurfaceReach reach_of(std::span<const PatchForm> patches, std::span<const float> numbers) {
  SurfaceReach reach;
  for (const PatchForm& form : patches) {
    if (form.number_count() > numbers.size()) break;
    Bounds3f box;
    const std::size_t width = form.is_rational != 0 ? 4 : 3;
    for (std::size_t k = 0; k < form.number_count(); k += width)
      box.grow(Vec3f{numbers[k], numbers[k + 1], numbers[k + 2]});
    numbers = numbers.subspan(form.number_count());
    double extent = 0;
    for (int a = 0; a < 3; ++a) {
      const double lower{box.lower[a]}, upper{box.upper[a]};
      extent = std::max(extent, upper - lower);
      double& largest = reach.largest[static_cast<std::size_t>(a)];
      largest = std::max({largest, std::fabs(lower), std::fabs(upper)});
    }
    if (extent > 0) reach.least_extent = std::min(reach.least_extent, extent);
  }
  return reach;
}

// Extent. With the inverse A in float32, a control point p comes back from the world, where it is
// rounded, as A (M p + e) = p + (A M - I) p + A e. By axis |e| <= 4.5 u (|M| |p| + |T|) and what
// underflows, and |A M - I| <= u |A| |M| + 2^-150 |M|, where entries of A underflow. So two points
// that are apart by an extent along an axis stay apart where the extent is more than twice that.
// Four times leave room for the roundings of the inverse in double. Largest coordinates are taken
// as larger by 2^-11, for parts reach beyond their patch.
bool may_share(const SurfaceReach& surface, const Transform& to_world) {
  constexpr double kRoundoff = 0x1p-24, kFar = 0x1p95, kLeast = 0x1p-126;
  if (is_singular(to_world)) return false;
  const Matrix inverse = inverse_of(to_world);
  double off[3];  // by axis of the world: e, and u |M| |p| of the other term
  double reached = 0;
  for (std::size_t i = 0; i < 3; ++i) {
    double size = 0;
    for (std::size_t j = 0; j < 3; ++j)
      size += std::fabs(double{to_world.m[i][j]}) * surface.largest[j] * (1 + 0x1p-11);
    const double moved = std::fabs(double{to_world.m[i][3]});
    if (!(size + moved < kFar)) return false;
    reached += size;
    off[i] = kRoundoff * (5.5 * size + 4.5 * moved) + kLeast;
  }
  for (const auto& row : inverse) {
    double back = 0x1p-150 * reached, largest = 0;
    for (std::size_t j = 0; j < 3; ++j) {
      back += std::fabs(row[j]) * off[j];
      largest = std::max(largest, std::fabs(row[j]));
    }
    const bool is_sound = largest > 1 / kFar && largest < kFar && back < kFar;
    if (!is_sound || !(surface.least_extent > 4 * back)) return false;
  }
  return true;
}

}  // namespace tessera
