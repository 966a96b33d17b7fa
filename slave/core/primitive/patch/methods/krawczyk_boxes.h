// SPDX-License-Identifier: Apache-2.0
// Boxes by Krawczyk's operator, then Newton (R. Moore, "A test for existence of solutions to
// nonlinear systems", SIAM J. Numer. Anal. 14, 1977; D. Toth, "On ray tracing parametric surfaces",
// SIGGRAPH 1985; thesis, 6.5). In a box with middle y, f = (N_0 . X, N_1 . X), Y the inverse of the
// middle of bounds of f', and W half their widths:
//   K = y - Y f(y) +- |Y| W (half widths of the box)
// holds all roots of the box. Where K is beside the box there is none; where it is inside, or r =
// the norm of |Y| W is below 1 and Newton's first step is short enough, Newton cannot go wrong;
// otherwise the box becomes what it shares with K, and is halved where that is most of it.
//
// What bounds f' over a box is a type, Bounds, with
//   void begin(shape, const NetBox&): of the whole part, once;
//   void bound(shape, const NetBox&, RangeOfSlopes&): in units of a box's half widths.
//
// Weakness: rays in tangents halve until kMethodBoxesMax boxes are looked at, and what is not found
// by then is lost.
//
// Threads. Pure functions.
#pragma once

#include "slave/core/primitive/patch/methods/newton_step.h"

namespace tessera::core {

// Of d f_k / d (x, y), where x, y are in [-1, 1] over the box.
struct RangeOfSlopes {
  double middle[2][2], half[2][2];  // [k][0: by x, 1: by y]
};

// Bounds by clipping: differences of the box's own net (6.5.3, equations 6.48 and 6.49).
struct ClippedBounds {
  template <class Shape>
  void begin(const Shape&, const NetBox<Shape>&) {}
  template <class Shape>
  void bound(const Shape& shape, const NetBox<Shape>& box, RangeOfSlopes& to) const {
    const int m = shape.m(), n = shape.n(), stride = n + 1;
    for (int k = 0; k < 2; ++k) {
      const double* f = box.f[k];
      const auto range = [&](int axis, int step, int rows, int columns) {
        double low = f[step] - f[0], high = low;
        for (int i = 0; i < rows; ++i)
          for (int j = 0; j < columns; ++j) {
            const double d = f[stride * i + j + step] - f[stride * i + j];
            low = std::min(low, d);
            high = std::max(high, d);
          }
        const double scale = 0.25 * (axis == 0 ? m : n);
        to.middle[k][axis] = scale * (high + low);
        to.half[k][axis] = scale * (high - low);
      };
      range(0, stride, m, n + 1);
      range(1, 1, m + 1, n);
    }
  }
};

// What is done in a box in which Newton is safe: Newton, from the place (u, v) of the box's own
// [0, 1]^2.
struct NewtonInBox {
  static constexpr double kRounding = 0x1p-20;  // of a box

  template <class Shape>
  static void run(const Shape& shape, const NetBox<Shape>& box, double u, double v, double flat,
                  NearestRoot& to) {
    double at[2] = {u, v};
    for (int step = 0; step < kMethodNewtonStepsMax; ++step) {
      const NetJet jet = jet_of(shape, box, at[0], at[1]);
      double by[2] = {};
      if (newton_step(jet, by))
        for (int a = 0; a < 2; ++a) at[a] = std::clamp(at[a] + by[a], -0.5, 1.5);
      if (!(jet.size() <= flat)) continue;
      // A root beside the box is another one's, but for roundings.
      const bool is_inside = at[0] >= -kRounding && at[0] <= 1 + kRounding && at[1] >= -kRounding &&
                             at[1] <= 1 + kRounding;
      if (is_inside) to.add(box.low[0] + at[0] * box.width(0), box.low[1] + at[1] * box.width(1));
      return;
    }
  }
};

// Safe: what is done in a box in which Newton is safe, as NewtonInBox.
template <class Shape, class Bounds, class Safe>
class KrawczykBoxes {
 public:
  KrawczykBoxes(const Shape& shape, NearestRoot& to) : shape_(shape), to_(to) {}

  // Returns: how many boxes were looked at.
  int run(const Patch& patch, const RaySight& sight) {
    NetBox<Shape>& first = stack_[0];
    scale_ = first.look_at_part(shape_, patch, sight, to_.range());
    depth_ = 1;
    bounds_.begin(shape_, first);
    int boxes = 0;
    for (; depth_ > 0 && boxes < kMethodBoxesMax; ++boxes) step();
    return boxes;
  }

 private:
  // K, in the box's own [-1, 1]^2, and r.
  struct Operator {
    double middle[2], reach[2], r;
    bool is_beside() const { return is_beside(0) || is_beside(1); }
    bool is_safe() const {
      const bool is_inside =
          std::fabs(middle[0]) + reach[0] <= 1 && std::fabs(middle[1]) + reach[1] <= 1;
      return r < 1 && (is_inside || std::max(std::fabs(middle[0]), std::fabs(middle[1])) < 1 - r);
    }

   private:
    bool is_beside(int axis) const { return std::fabs(middle[axis]) - reach[axis] > 1; }
  };

  void step() {
    NetBox<Shape>& box = stack_[depth_ - 1];
    if (box.is_elsewhere(shape_, scale_.noise)) return drop();
    if (box.is_within(shape_, scale_.flat)) return accept(box.middle(0), box.middle(1));
    const bool is_short[2] = {box.width(0) < kMethodLeastWidth, box.width(1) < kMethodLeastWidth};
    if (is_short[0] && is_short[1]) return accept(box.middle(0), box.middle(1));
    RangeOfSlopes slopes;
    bounds_.bound(shape_, box, slopes);
    Operator k;
    if (!find(box, slopes, k)) return halve(slopes, is_short);
    if (k.is_beside()) return drop();
    if (k.is_safe()) {
      Safe::run(shape_, box, 0.5 + 0.5 * k.middle[0], 0.5 + 0.5 * k.middle[1], scale_.flat, to_);
      return drop();
    }
    if (!shrink(box, k)) halve(slopes, is_short);
  }

  // Returns: whether there is an operator: the middle of the slopes has an inverse.
  bool find(const NetBox<Shape>& box, const RangeOfSlopes& slopes, Operator& k) const {
    const auto& j = slopes.middle;
    const double determinant = j[0][0] * j[1][1] - j[0][1] * j[1][0];
    if (!(std::fabs(determinant) > 0)) return false;
    const double y[2][2] = {{j[1][1] / determinant, -j[0][1] / determinant},
                            {-j[1][0] / determinant, j[0][0] / determinant}};
    const NetJet jet = jet_of(shape_, box, 0.5, 0.5);
    k.r = 0;
    for (int a = 0; a < 2; ++a) {
      k.middle[a] = -(y[a][0] * jet.f[0] + y[a][1] * jet.f[1]);
      k.reach[a] = 0;
      for (int l = 0; l < 2; ++l)
        k.reach[a] += std::fabs(y[a][l]) * (slopes.half[l][0] + slopes.half[l][1]);
      k.r = std::max(k.r, k.reach[a]);
    }
    return std::isfinite(k.r);
  }

  // Returns: whether a side became a good deal shorter.
  bool shrink(NetBox<Shape>& box, const Operator& k) {
    bool is_shorter = false;
    for (int a = 0; a < 2; ++a) {
      const double from = std::max(0.0, 0.5 * (1 + k.middle[a] - k.reach[a]) - kRounding);
      const double to = std::min(1.0, 0.5 * (1 + k.middle[a] + k.reach[a]) + kRounding);
      if (!(to - from < kShorter)) continue;
      box.keep(shape_, a, from, to);
      is_shorter = true;
    }
    return is_shorter;
  }

  void halve(const RangeOfSlopes& slopes, const bool (&is_short)[2]) {
    NetBox<Shape>& box = stack_[depth_ - 1];
    if (depth_ == kMethodStackMax) return drop();
    const auto size = [&](int axis) {
      return std::max(std::fabs(slopes.middle[0][axis]) + slopes.half[0][axis],
                      std::fabs(slopes.middle[1][axis]) + slopes.half[1][axis]);
    };
    const int axis = is_short[0] ? 1 : is_short[1] ? 0 : size(0) >= size(1) ? 0 : 1;
    stack_[depth_] = box;
    box.keep(shape_, axis, 0.5, 1);
    stack_[depth_++].keep(shape_, axis, 0, 0.5);
  }

  void accept(double u, double v) {
    to_.add(u, v);
    drop();
  }
  void drop() { --depth_; }

  static constexpr double kRounding = 0x1p-20;  // of a box
  static constexpr double kShorter = 0.8;       // a side that is left, for the box to be cut to it

  const Shape shape_;
  NearestRoot& to_;
  Bounds bounds_;
  NetScale scale_{};
  int depth_ = 0;
  NetBox<Shape> stack_[kMethodStackMax];
};

// Returns: how many boxes were looked at.
template <class Bounds, class Safe = NewtonInBox>
int krawczyk_roots(const Patch& patch, const RaySight& sight, NearestRoot& to) {
  int boxes = 0;
  by_degrees(patch, [&]<class Shape>(const Shape& shape) {
    boxes = KrawczykBoxes<Shape, Bounds, Safe>(shape, to).run(patch, sight);
  });
  return boxes;
}

}  // namespace tessera::core
