// SPDX-License-Identifier: Apache-2.0
#include "slave/core/primitive/triangle/exact_hit_abi.h"

#include <cmath>
#include <initializer_list>

namespace tessera::core {
namespace {

// A value as an unevaluated exact sum; the difference of two floats always is one.
struct Pair {
  double high, low;
};

// Knuth's sum: s + error = a + b exactly.
Pair two_sum(double a, double b) {
  const double sum = a + b;
  const double b_part = sum - a;
  return {sum, (a - (sum - b_part)) + (b - b_part)};
}

Pair two_product(double a, double b) {
  const double product = a * b;
  return {product, std::fma(a, b, -product)};
}

// An exact sum of doubles, from the smallest magnitude up, none of which overlap.
class Expansion {
 public:
  void add(double value) {
    int kept = 0;
    for (int i = 0; i < size_; ++i) {
      const Pair sum = two_sum(value, parts_[i]);
      if (sum.low != 0) parts_[kept++] = sum.low;
      value = sum.high;
    }
    if (value != 0) parts_[kept++] = value;
    size_ = kept;
  }

  // Adds sign * a b c, exactly. The parts of a product of float differences keep clear of
  // underflow: the smallest is 2^-149 cubed times 2^-106.
  void add_product(double a, double b, double c, double sign) {
    const Pair ab = two_product(a, b);
    for (const double part : {ab.low, ab.high}) {
      const Pair abc = two_product(part, c);
      add(sign * abc.low);
      add(sign * abc.high);
    }
  }

  // Returns: the sum to 2^-52, for the largest part dominates. It is zero only where the sum is.
  double value() const {
    double sum = 0;
    for (int i = 0; i < size_; ++i) sum += parts_[i];
    return sum;
  }

 private:
  // 6 terms of the determinant, 8 products of parts each, 4 parts each.
  double parts_[192];
  int size_ = 0;
};

// An operand of a quotient is good enough at this relative error.
constexpr double kGoodEnough = 0x1p-30;

struct Vector {
  Pair axis[3];
};

Vector difference(const float* p, const float* q) {
  Vector result;
  for (int a = 0; a < 3; ++a) result.axis[a] = two_sum(double{p[a]}, -double{q[a]});
  return result;
}

double determinant_exact(const Vector& p, const Vector& q, const Vector& r) {
  Expansion sum;
  for (int i = 0; i < 3; ++i) {
    const int j = (i + 1) % 3, k = (i + 2) % 3;
    for (const double a : {p.axis[i].high, p.axis[i].low}) {
      if (a == 0) continue;
      for (int half = 0; half < 4; ++half) {
        const auto part = [](const Pair& pair, int low) { return low != 0 ? pair.low : pair.high; };
        sum.add_product(part(q.axis[j], half & 1), part(r.axis[k], half >> 1), a, 1);
        sum.add_product(part(q.axis[k], half & 1), part(r.axis[j], half >> 1), a, -1);
      }
    }
  }
  return sum.value();
}

// p . (q x r) with a relative error of at most `tolerance`, or its exact sign where that is 1.
double determinant(const Vector& p, const Vector& q, const Vector& r, double tolerance) {
  double value = 0, size = 0;
  for (int i = 0; i < 3; ++i) {
    const int j = (i + 1) % 3, k = (i + 2) % 3;
    const double a = q.axis[j].high * r.axis[k].high, b = q.axis[k].high * r.axis[j].high;
    value += p.axis[i].high * (a - b);
    size += std::fabs(p.axis[i].high) * (std::fabs(a) + std::fabs(b));
  }
  if (std::fabs(value) * tolerance > size * kDeterminantError) return value;
  return determinant_exact(p, q, r);
}

// The line of a ray, and the corners of a triangle seen from its origin.
struct Line {
  Vector d, to[3];

  Line(const float* origin, const float* direction, const float* triangle) {
    for (int a = 0; a < 3; ++a) d.axis[a] = {double{direction[a]}, 0};
    for (int c = 0; c < 3; ++c) to[c] = difference(triangle + 3 * c, origin);
  }
  // Whether the line passes all edges on the same side, or through them.
  bool passes() const {
    bool is_left = false, is_right = false;
    for (int c = 0; c < 3; ++c) {
      const double side = determinant(d, to[c], to[(c + 1) % 3], 1);
      is_left = is_left || side < 0;
      is_right = is_right || side > 0;
      if (is_left && is_right) return false;
    }
    return is_left || is_right;
  }
};

}  // namespace

bool has_area(const float* triangle) {
  double b[3], c[3];
  for (int a = 0; a < 3; ++a) {
    b[a] = double{triangle[3 + a]} - double{triangle[a]};
    c[a] = double{triangle[6 + a]} - double{triangle[a]};
  }
  return b[1] * c[2] != b[2] * c[1] || b[2] * c[0] != b[0] * c[2] || b[0] * c[1] != b[1] * c[0];
}

int exact_side(const float* origin, const float* triangle) {
  const double volume =
      determinant(difference(triangle, origin), difference(triangle + 3, triangle),
                  difference(triangle + 6, triangle), 1);
  return (volume > 0) - (volume < 0);
}

bool is_exact_hit(const float* origin, const float* direction, const float* triangle) {
  return has_area(triangle) && Line(origin, direction, triangle).passes();
}

ExactHit exact_hit(const float* origin, const float* direction, const float* triangle) {
  constexpr ExactHit kMiss{false, 0};
  if (!has_area(triangle)) return kMiss;
  const Line line(origin, direction, triangle);
  if (!line.passes()) return kMiss;
  const Vector edge_b = difference(triangle + 3, triangle),
               edge_c = difference(triangle + 6, triangle);
  const double distance = determinant(line.to[0], edge_b, edge_c, kGoodEnough);
  const double speed = determinant(line.d, edge_b, edge_c, kGoodEnough);
  return {true, static_cast<float>(distance / speed)};
}

}  // namespace tessera::core
