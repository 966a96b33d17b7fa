// SPDX-License-Identifier: Apache-2.0
#include "slave/core/primitive/instance/instance_placement.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace tessera::core {
namespace {

constexpr double kRoundoff = 0x1p-24;  // u, of float32
using Matrix = std::array<std::array<double, 3>, 3>;

Matrix linear_part(const Transform& t) {
  Matrix m{};
  for (std::size_t i = 0; i < 3; ++i) {
    for (std::size_t j = 0; j < 3; ++j) m[i][j] = double{t.m[i][j]};
  }
  return m;
}

// Returns: nothing for a matrix without inverse.
std::optional<Matrix> inverse_of(const Matrix& m) {
  Matrix inverse{};
  double determinant = 0;
  for (std::size_t i = 0; i < 3; ++i) {
    const std::size_t i1 = (i + 1) % 3, i2 = (i + 2) % 3;
    for (std::size_t j = 0; j < 3; ++j) {
      const std::size_t j1 = (j + 1) % 3, j2 = (j + 2) % 3;
      inverse[j][i] = m[i1][j1] * m[i2][j2] - m[i1][j2] * m[i2][j1];
    }
    if (i == 0) {
      for (std::size_t j = 0; j < 3; ++j) determinant += m[0][j] * inverse[j][0];
    }
  }
  if (!(std::fabs(determinant) > 0 && std::isfinite(determinant))) return std::nullopt;
  for (auto& row : inverse) {
    for (double& value : row) value /= determinant;
  }
  return inverse;
}

// By axis, how far a corner in world space may be from M p + T: Transform::point() rounds each
// product once and each of three sums, which is 4 u of the sizes added up, with some room; products
// may underflow.
std::array<double, 3> corner_errors(const Transform& t, const std::array<double, 3>& largest) {
  std::array<double, 3> errors{};
  for (std::size_t i = 0; i < 3; ++i) {
    double size = std::fabs(double{t.m[i][3]});
    for (std::size_t j = 0; j < 3; ++j) size += std::fabs(double{t.m[i][j]}) * largest[j];
    errors[i] = 4.5 * kRoundoff * size + double{std::numeric_limits<float>::min()};
  }
  return errors;
}

std::array<double, 3> largest_of(const Bounds3f& b) {
  std::array<double, 3> largest{};
  for (int a = 0; a < 3; ++a) {
    largest[static_cast<std::size_t>(a)] =
        std::max(std::fabs(double{b.lower[a]}), std::fabs(double{b.upper[a]}));
  }
  return largest;
}

float rounded_up(double value) {
  return std::nextafter(static_cast<float>(value), std::numeric_limits<float>::infinity());
}

}  // namespace

std::array<double, 3> corner_roundings(const Transform& to_world, const Bounds3f& corners) {
  return corner_errors(to_world, largest_of(corners));
}

// The pad. With A the inverse as stored, a corner w = M p + T + e comes back as A (w - T) = p + (A
// M - I) p + A e. Products of A M are computed here in double, whose roundings are 2^-50 of their
// sizes.
std::optional<InstanceBlock> place_instance(const Transform& to_world, const Bounds3f& bounds) {
  const Matrix m = linear_part(to_world);
  const std::optional<Matrix> inverse = inverse_of(m);
  if (!inverse || bounds.is_empty()) return std::nullopt;
  const std::array<double, 3> largest = largest_of(bounds),
                              errors = corner_errors(to_world, largest);
  InstanceBlock block{};
  block.is_identity = to_world.is_identity() ? 1 : 0;
  for (std::size_t i = 0; i < 3; ++i) {
    double pad = 0, reach = std::fabs(double{to_world.m[i][3]});
    float largest_of_row = 0;
    for (std::size_t j = 0; j < 3; ++j) {
      block.to_world[i][j] = to_world.m[i][j];
      block.to_object[j][i] = static_cast<float>((*inverse)[i][j]);
      largest_of_row = std::max(largest_of_row, std::fabs(block.to_object[j][i]));
      reach += std::fabs(m[i][j]) * largest[j];
    }
    block.to_world[i][3] = to_world.m[i][3];
    for (std::size_t j = 0; j < 3; ++j) {
      double residual = i == j ? -1 : 0, size = 0;
      for (std::size_t k = 0; k < 3; ++k) {
        const double product = double{block.to_object[k][i]} * m[k][j];
        residual += product;
        size += std::fabs(product);
      }
      pad += (std::fabs(residual) + 0x1p-50 * (size + 1)) * largest[j];
      pad += std::fabs(double{block.to_object[j][i]}) * errors[j];
    }
    block.pad[i] = rounded_up(pad * (1 + 0x1p-40));
    // Values have to be far from the ends of float32, so that no kernel overflows.
    const bool is_sound = reach < 0x1p96 && block.pad[i] < 0x1p96f && largest_of_row > 0x1p-96f &&
                          largest_of_row < 0x1p96f;
    if (!is_sound) return std::nullopt;
  }
  return block;
}

Bounds3f placed_bounds(const Transform& to_world, std::span<const Bounds3f> parts) {
  Bounds3f placed;
  if (to_world.is_identity()) {
    for (const Bounds3f& part : parts) placed.grow(part);
    return placed;
  }
  const Matrix m = linear_part(to_world);
  for (const Bounds3f& part : parts) {
    if (part.is_empty()) continue;
    const std::array<double, 3> errors = corner_errors(to_world, largest_of(part));
    float lower[3], upper[3];
    for (std::size_t i = 0; i < 3; ++i) {
      // 2^-50 of the sizes for sums in double is far below what errors[] has to spare.
      double low = double{to_world.m[i][3]} - errors[i],
             high = double{to_world.m[i][3]} + errors[i];
      for (std::size_t j = 0; j < 3; ++j) {
        const int axis = static_cast<int>(j);
        const double p = m[i][j] * double{part.lower[axis]}, q = m[i][j] * double{part.upper[axis]};
        low += std::min(p, q);
        high += std::max(p, q);
      }
      const float inf = std::numeric_limits<float>::infinity();
      lower[i] = std::nextafter(static_cast<float>(low), -inf);
      upper[i] = std::nextafter(static_cast<float>(high), inf);
    }
    placed.grow(Vec3f{lower[0], lower[1], lower[2]});
    placed.grow(Vec3f{upper[0], upper[1], upper[2]});
  }
  return placed;
}

}  // namespace tessera::core
