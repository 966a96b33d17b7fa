// SPDX-License-Identifier: Apache-2.0
#include "slave/core/primitive/patch/sub_patch_bounds.h"

namespace tessera::core {
namespace {

// A factor for each bound: kBeyond of a numerator, kBeyond of what it is multiplied with, kBeyond
// for roundings, and room.
constexpr double kWider = 1 + 4 * kBeyond;

void bound_polynomial(const PatchNet& x, int a, double error, SubPatchBounds& out) {
  PatchNet rest = x;
  for (int i = 0; i <= x.m; ++i)
    for (int j = 0; j <= x.n; ++j)
      rest.c[i][j] -= a == 0 ? 2.0 * i / x.m - 1 : a == 1 ? 2.0 * j / x.n - 1 : 0;
  out.reach[a] = size_of(rest) * kWider + error;
  // A coefficient of a second derivative is made of four, times at most 16^2 / 4.
  const PatchNet dx = derivative_x(x), dy = derivative_y(x);
  const double slack = 256 * error;
  out.xx[a] = size_of(derivative_x(dx)) * kWider + slack;
  out.xy[a] = size_of(derivative_y(dx)) * kWider + slack;
  out.yy[a] = size_of(derivative_y(dy)) * kWider + slack;
}

// Sizes of the weights and of their derivatives, and what they may be off by.
struct Weights {
  double low, high, error, x, y, xx, xy, yy;

  explicit Weights(const PatchNet& w) {
    const NetRange range = range_of(w);
    low = range.low - kBeyond * range.high;
    high = range.high;
    error = kNetError * high;
    const PatchNet wx = derivative_x(w), wy = derivative_y(w);
    x = size_of(wx) * kWider + 16 * error;
    y = size_of(wy) * kWider + 16 * error;
    xx = size_of(derivative_x(wx)) * kWider + 256 * error;
    xy = size_of(derivative_y(wx)) * kWider + 256 * error;
    yy = size_of(derivative_y(wy)) * kWider + 256 * error;
  }
};

// The largest |S| by component. Beyond the square |X| is at most sum |B| w times the size, and that
// w + 2 kBeyond of the largest weight, which is below w (1 + 2 kBeyond high / low).
double size_over(const PatchNet& x, const PatchNet& w, const Weights& weights, double error) {
  double size = 0;
  for (int i = 0; i <= w.m; ++i)
    for (int j = 0; j <= w.n; ++j) size = std::max(size, std::fabs(x.c[i][j]) / w.c[i][j]);
  return size * (1 + 2 * kBeyond * weights.high / weights.low) * kWider + error / weights.low;
}

// Which derivatives of a component are nearly 1, as that of the parameter's own one is in a frame.
enum class Own { kX, kY, kNone };

struct Derivatives {
  double x, y, xx, xy, yy;
};

// With X = w S: w (S_x - e) = X_x - w e - w_x S, where e is 1 for the parameter's own component and
// 0 else; X_x is raised to the degree of w, so that what is nearly equal cancels before it is
// bounded. Then w S_xx = X_xx - 2 w_x S_x - w_xx S, and so on.
Derivatives rational_derivatives(const PatchNet& x, const PatchNet& w, const Weights& weights,
                                 double size, Own own, double error) {
  const double low = weights.low;
  const bool own_x = own == Own::kX, own_y = own == Own::kY;
  const PatchNet dx = derivative_x(x), dy = derivative_y(x);
  const PatchNet raised_x = times_u(dx, 1, 1), raised_y = times_v(dy, 1, 1);
  const double off_x = size_of(own_x ? difference(raised_x, w) : raised_x) * kWider;
  const double off_y = size_of(own_y ? difference(raised_y, w) : raised_y) * kWider;
  Derivatives d{};
  d.x =
      (off_x + size * weights.x + 16 * error + (own_x ? weights.error : 0)) / low + (own_x ? 1 : 0);
  d.y =
      (off_y + size * weights.y + 16 * error + (own_y ? weights.error : 0)) / low + (own_y ? 1 : 0);
  const double second = 256 * error;
  d.xx = (size_of(derivative_x(dx)) * kWider + second + 2 * d.x * weights.x + size * weights.xx) /
         low * kWider;
  d.xy = (size_of(derivative_y(dx)) * kWider + second + d.x * weights.y + d.y * weights.x +
          size * weights.xy) /
         low * kWider;
  d.yy = (size_of(derivative_y(dy)) * kWider + second + 2 * d.y * weights.y + size * weights.yy) /
         low * kWider;
  return d;
}

void bound_rational(const PatchNet& x, const PatchNet& w, const Weights& weights, int a,
                    double error, SubPatchBounds& out) {
  const double size = size_over(x, w, weights, error);
  const double slack = error + size * weights.error;
  if (a == 2) {
    out.reach[a] = size;
  } else {
    const PatchNet rest = a == 0 ? difference(times_u(x, 1, 1), times_u(w, -1, 1))
                                 : difference(times_v(x, 1, 1), times_v(w, -1, 1));
    out.reach[a] = (size_of(rest) * kWider + slack + weights.error) / weights.low;
  }
  const Own own = a == 0 ? Own::kX : a == 1 ? Own::kY : Own::kNone;
  const Derivatives d = rational_derivatives(x, w, weights, size, own, error);
  out.xx[a] = d.xx;
  out.xy[a] = d.xy;
  out.yy[a] = d.yy;
}

}  // namespace

SubPatchBounds bounds_of(const PatchNet (&local)[3], const PatchNet& w, bool is_rational,
                         const double (&error)[3]) {
  SubPatchBounds out;
  if (!is_rational) {
    for (int a = 0; a < 3; ++a) bound_polynomial(local[a], a, error[a], out);
    return out;
  }
  const Weights weights(w);
  for (int a = 0; a < 3; ++a) {
    if (weights.low > 0) {
      bound_rational(local[a], w, weights, a, error[a], out);
    } else {
      out.reach[a] = out.xx[a] = out.xy[a] = out.yy[a] = INFINITY;
    }
  }
  return out;
}

DerivativeBounds derivative_bounds_of(const PatchNet (&local)[3], const PatchNet& w,
                                      bool is_rational, const double (&error)[3]) {
  DerivativeBounds out;
  const Weights weights(w);
  for (int a = 0; a < 3; ++a) {
    Derivatives d{INFINITY, INFINITY, INFINITY, INFINITY, INFINITY};
    if (!is_rational) {
      const PatchNet dx = derivative_x(local[a]), dy = derivative_y(local[a]);
      const double slack = 256 * error[a];
      d = {size_of(dx) * kWider + slack, size_of(dy) * kWider + slack,
           size_of(derivative_x(dx)) * kWider + slack, size_of(derivative_y(dx)) * kWider + slack,
           size_of(derivative_y(dy)) * kWider + slack};
    } else if (weights.low > 0) {
      const double size = size_over(local[a], w, weights, error[a]);
      d = rational_derivatives(local[a], w, weights, size, Own::kNone, error[a]);
    }
    out.x[a] = d.x;
    out.y[a] = d.y;
    out.xx[a] = d.xx;
    out.xy[a] = d.xy;
    out.yy[a] = d.yy;
  }
  return out;
}

}  // namespace tessera::core
