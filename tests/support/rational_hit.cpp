// SPDX-License-Identifier: Apache-2.0
#include "tests/support/rational_hit.h"

#include <algorithm>
#include <cmath>

#include "slave/core/primitive/triangle/exact_hit_abi.h"
#include "tests/support/big_integer.h"

namespace tessera::test {
namespace {

struct Vector {
  BigInteger x, y, z;
};
Vector operator-(const Vector& p, const Vector& q) { return {p.x - q.x, p.y - q.y, p.z - q.z}; }
Vector cross(const Vector& p, const Vector& q) {
  return {p.y * q.z - p.z * q.y, p.z * q.x - p.x * q.z, p.x * q.y - p.y * q.x};
}
BigInteger dot(const Vector& p, const Vector& q) { return p.x * q.x + p.y * q.y + p.z * q.z; }

// The greatest exponent e for which all values are integers times 2^e, or less.
int exponent_of(const float* values, int count, int least) {
  for (int k = 0; k < count; ++k) {
    int own = 0;
    if (values[k] == 0) continue;
    std::frexp(values[k], &own);
    least = std::min(least, std::max(own - 24, -149));
  }
  return least;
}

Vector vector(const float* values, int exponent) {
  return {{values[0], exponent}, {values[1], exponent}, {values[2], exponent}};
}

bool has_area_in_double(const Vector& edge_b, const Vector& edge_c, int exponent) {
  const auto in_double = [&](const Vector& v, double* to) {
    to[0] = v.x.in_double(exponent);
    to[1] = v.y.in_double(exponent);
    to[2] = v.z.in_double(exponent);
  };
  double b[3] = {}, c[3] = {};
  in_double(edge_b, b);
  in_double(edge_c, c);
  for (int i = 0; i < 3; ++i) {
    const int j = (i + 1) % 3;
    if (b[i] * c[j] != b[j] * c[i]) return true;
  }
  return false;
}

}  // namespace

RationalHit rational_hit(const float* origin, const float* direction, const float* triangle) {
  constexpr int kMost = 127;
  const int place = exponent_of(triangle, 9, exponent_of(origin, 3, kMost));
  const int way = exponent_of(direction, 3, kMost);
  const Vector a = vector(triangle, place), d = vector(direction, way);
  const Vector edge_b = vector(triangle + 3, place) - a, edge_c = vector(triangle + 6, place) - a;
  if (!has_area_in_double(edge_b, edge_c, place)) return {};

  const Vector from = vector(origin, place) - a;
  const Vector p = cross(d, edge_c);
  const BigInteger volume = dot(edge_b, p);
  const int side = volume.sign();
  if (side == 0) return {};
  const BigInteger u = dot(from, p);
  if (u.sign() * side < 0) return {};
  const Vector q = cross(from, edge_b);
  const BigInteger v = dot(d, q);
  if (v.sign() * side < 0) return {};
  if ((volume - u - v).sign() * side < 0) return {};
  const BigInteger distance = dot(edge_c, q);
  return {true, distance.in_long_double(place - way) / volume.in_long_double(0)};
}

DefinedT defined_t(const float* origin, const float* direction, const float* triangle) {
  constexpr float kLeast = 0x1p-100f;
  double a[3] = {}, b[3] = {}, c[3] = {}, normal[3] = {}, size = 0, reach = 0;
  for (int k = 0; k < 3; ++k) {
    a[k] = double{triangle[k]} - double{origin[k]};
    b[k] = double{triangle[3 + k]} - double{triangle[k]};
    c[k] = double{triangle[6 + k]} - double{triangle[k]};
    reach += std::fabs(a[k]);
  }
  for (int k = 0; k < 3; ++k) {
    const int i = (k + 1) % 3, j = (k + 2) % 3;
    const double one = b[i] * c[j], other = b[j] * c[i];
    normal[k] = one - other;
    size = std::max(size, std::fabs(one) + std::fabs(other));
  }
  const double scale = std::ldexp(1.0, -std::ilogb(size));
  for (double& n : normal) n *= scale;
  const double distance = (normal[0] * a[0] + normal[1] * a[1]) + normal[2] * a[2];
  const double least = size * scale * 0x1p-24;
  const auto over = static_cast<float>(distance);
  const auto speed =
      static_cast<float>((double{direction[0]} * normal[0] + double{direction[1]} * normal[1]) +
                         double{direction[2]} * normal[2]);
  const float length =
      (std::fabs(direction[0]) + std::fabs(direction[1])) + std::fabs(direction[2]);
  const bool is_clear = std::fabs(distance) >= least * reach && std::fabs(over) >= kLeast &&
                        std::fabs(over) <= 1 / kLeast &&
                        std::fabs(speed) >= static_cast<float>(least) * length + kLeast;
  if (is_clear) return {over / speed, true};
  return {core::exact_hit(origin, direction, triangle).t, false};
}

bool is_near(const DefinedT& defined, long double t) {
  const long double u = 0x1p-24L, squares = 8 * u * u;  // of second order in u
  const long double share = squares + (defined.is_of_plane ? 3 * u + u / 2 : u + 0x1p-29L);
  return std::fabs(defined.t - t) <= std::fabs(t) * share + 0x1p-150L;
}

}  // namespace tessera::test
