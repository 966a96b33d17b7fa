// SPDX-License-Identifier: Apache-2.0
#include "tests/bench/method_variants.h"

#include <array>

#include "slave/core/primitive/patch/methods/krawczyk_boxes.h"
#include "slave/core/primitive/patch/methods/method_answer.h"

namespace tessera::bench {
namespace {

using core::NearestRoot;
using core::NetBox;
using core::Patch;
using core::RangeOfSlopes;
using core::RaySight;
using core::SubPatch;

// (0, 0), (1, 0), (1, 1) and (0, 0), (1, 1), (0, 1), as mesh generators cut squares.
struct TwoTriangles {
  template <class Found>
  static void test(const core::FacetCorners& corners, const Found& found) {
    constexpr int kOf[2][3] = {{0, 2, 3}, {0, 3, 1}};
    for (const auto& corner : kOf) {
      double side[3], sum = 0, s = 0, t = 0;
      for (int k = 0; k < 3; ++k) {
        const double* from = corners.at[corner[(k + 1) % 3]];
        const double* to = corners.at[corner[(k + 2) % 3]];
        side[k] = from[0] * to[1] - from[1] * to[0];
        sum += side[k];
      }
      for (int k = 0; k < 3; ++k) {
        side[k] /= sum;  // NaN where the triangle is seen from its side, which is no hit
        s += side[k] * (corner[k] / 2);
        t += side[k] * (corner[k] % 2);
      }
      if (side[0] >= -core::kFacetEdge && side[1] >= -core::kFacetEdge &&
          side[2] >= -core::kFacetEdge)
        found(s, t);
    }
  }
};

struct Interval {
  double low, high;
};
Interval operator+(Interval a, Interval b) { return {a.low + b.low, a.high + b.high}; }
Interval operator*(Interval a, Interval b) {
  const double p = a.low * b.low, q = a.low * b.high, r = a.high * b.low, s = a.high * b.high;
  return {std::min(std::min(p, q), std::min(r, s)), std::max(std::max(p, q), std::max(r, s))};
}
Interval point(double a) { return {a, a}; }

// Slopes by interval arithmetic on U P' V, for bicubic nets (6.5.3, equation 6.47).
class IntervalBounds {
 public:
  template <class Shape>
  void begin(const Shape& shape, const NetBox<Shape>& whole) {
    static constexpr double kPowers[4][4] = {
        {-1, 3, -3, 1}, {3, -6, 3, 0}, {-3, 3, 0, 0}, {1, 0, 0, 0}};
    for (int a = 0; a < 2; ++a) {
      low_[a] = whole.low[a];
      width_[a] = whole.width(a);
    }
    if (shape.m() != 3 || shape.n() != 3) return;
    for (int k = 0; k < 2; ++k)
      for (int r = 0; r < 4; ++r)
        for (int c = 0; c < 4; ++c) {
          double sum = 0;
          for (int i = 0; i < 4; ++i)
            for (int j = 0; j < 4; ++j)
              sum += kPowers[r][i] * whole.f[k][4 * i + j] * kPowers[c][j];
          powers_[k][r][c] = sum;
        }
  }

  template <class Shape>
  void bound(const Shape& shape, const NetBox<Shape>& box, RangeOfSlopes& to) const {
    if (shape.m() != 3 || shape.n() != 3) return core::ClippedBounds().bound(shape, box, to);
    Interval x[2];
    double half[2];
    for (int a = 0; a < 2; ++a) {
      x[a] = {(box.low[a] - low_[a]) / width_[a], (box.high[a] - low_[a]) / width_[a]};
      half[a] = 0.5 * (x[a].high - x[a].low);
    }
    const Interval value[2][4] = {{x[0] * x[0] * x[0], x[0] * x[0], x[0], point(1)},
                                  {x[1] * x[1] * x[1], x[1] * x[1], x[1], point(1)}};
    const Interval slope[2][4] = {{point(3) * x[0] * x[0], point(2) * x[0], point(1), point(0)},
                                  {point(3) * x[1] * x[1], point(2) * x[1], point(1), point(0)}};
    for (int k = 0; k < 2; ++k)
      for (int axis = 0; axis < 2; ++axis) {
        Interval sum = point(0);
        for (int r = 0; r < 4; ++r) {
          Interval row = point(0);
          for (int c = 0; c < 4; ++c)
            row = row + point(powers_[k][r][c]) * (axis == 0 ? value : slope)[1][c];
          sum = sum + (axis == 0 ? slope : value)[0][r] * row;
        }
        to.middle[k][axis] = 0.5 * (sum.low + sum.high) * half[axis];
        to.half[k][axis] = 0.5 * (sum.high - sum.low) * half[axis];
      }
  }

 private:
  double powers_[2][4][4] = {}, low_[2] = {}, width_[2] = {};
};

// Slopes at the middle, and by how much they may change from there by bounds of second derivatives
// that hold for the whole part: nothing of a box's net is looked at but its middle.
class SecondBounds {
 public:
  template <class Shape>
  void begin(const Shape& shape, const NetBox<Shape>& whole) {
    const int m = shape.m(), n = shape.n(), stride = n + 1;
    for (int a = 0; a < 2; ++a) width_[a] = whole.width(a);
    for (int k = 0; k < 2; ++k) {
      const double* f = whole.f[k];
      for (int i = 0; i <= m; ++i)
        for (int j = 0; j <= n; ++j) {
          const double* p = f + stride * i + j;
          const auto grow = [](double& most, double x) { most = std::max(most, std::fabs(x)); };
          if (i + 2 <= m) grow(second_[k][0], m * (m - 1) * (p[0] - 2 * p[stride] + p[2 * stride]));
          if (j + 2 <= n) grow(second_[k][2], n * (n - 1) * (p[0] - 2 * p[1] + p[2]));
          if (i < m && j < n)
            grow(second_[k][1], m * n * (p[0] - p[1] - p[stride] + p[stride + 1]));
        }
    }
  }

  template <class Shape>
  void bound(const Shape& shape, const NetBox<Shape>& box, RangeOfSlopes& to) const {
    const core::NetJet jet = core::jet_of(shape, box, 0.5, 0.5);
    const double half[2] = {0.5 * box.width(0) / width_[0], 0.5 * box.width(1) / width_[1]};
    for (int k = 0; k < 2; ++k) {
      to.middle[k][0] = 0.5 * jet.fu[k];
      to.middle[k][1] = 0.5 * jet.fv[k];
      const double* second = second_[k];
      to.half[k][0] = half[0] * (second[0] * half[0] + second[1] * half[1]);
      to.half[k][1] = half[1] * (second[1] * half[0] + second[2] * half[1]);
    }
  }

 private:
  double second_[2][3] = {}, width_[2] = {};
};

template <class Facet>
void refine(const CountedHow& how, const Patch& patch, const SubPatch& part, const RaySight& sight,
            NearestRoot& to) {
  core::refined_roots<Facet>(how.refine, patch, part, sight, to);
}
void newton(const CountedHow& how, const Patch& patch, const SubPatch& part, const RaySight& sight,
            NearestRoot& to) {
  how.work += static_cast<std::uint64_t>(newton_roots(how.newton, patch, part, sight, to));
}
template <class Bounds>
void krawczyk(const CountedHow& how, const Patch& patch, const SubPatch&, const RaySight& sight,
              NearestRoot& to) {
  how.work += static_cast<std::uint64_t>(core::krawczyk_roots<Bounds>(patch, sight, to));
}
void clip(const CountedHow& how, const Patch& patch, const SubPatch& part, const RaySight& sight,
          NearestRoot& to) {
  how.work += static_cast<std::uint64_t>(clip_roots(how.clip, patch, part, sight, to));
}

struct Starts {
  int count = 0, most = 0;
  float *u = nullptr, *v = nullptr;
};
thread_local Starts starts_of_call;

// Keeps where Newton may start.
struct KeptStart {
  template <class Shape>
  static void run(const Shape&, const NetBox<Shape>& box, double u, double v, double,
                  NearestRoot&) {
    Starts& starts = starts_of_call;
    if (starts.count == starts.most) return;
    starts.u[starts.count] = static_cast<float>(box.low[0] + u * box.width(0));
    starts.v[starts.count++] = static_cast<float>(box.low[1] + v * box.width(1));
  }
};

}  // namespace

core::PatchMethodCall refine_call(const CountedHow& how, bool is_bilinear) {
  return {is_bilinear ? core::method_answer<refine<core::BilinearFacet>>
                      : core::method_answer<refine<TwoTriangles>>,
          &how};
}
core::PatchMethodCall newton_call(const CountedHow& how) {
  return {core::method_answer<newton>, &how};
}
core::PatchMethodCall krawczyk_call(const CountedHow& how, SlopeBounds bounds) {
  switch (bounds) {
    case SlopeBounds::kInterval:
      return {core::method_answer<krawczyk<IntervalBounds>>, &how};
    case SlopeBounds::kSecond:
      return {core::method_answer<krawczyk<SecondBounds>>, &how};
    case SlopeBounds::kClipped:
      break;
  }
  return {core::method_answer<krawczyk<core::ClippedBounds>>, &how};
}
core::PatchMethodCall clip_call(const CountedHow& how) { return {core::method_answer<clip>, &how}; }

int safe_starts(const core::Patch& patch, const core::SubPatch& whole, const float* origin,
                const float* direction, int most, float* u, float* v) {
  const RaySight sight(origin, direction);
  NearestRoot unused(patch, whole, sight, 0);
  starts_of_call = {0, most, u, v};
  core::krawczyk_roots<core::ClippedBounds, KeptStart>(patch, sight, unused);
  return starts_of_call.count;
}

}  // namespace tessera::bench
