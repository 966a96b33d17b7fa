// SPDX-License-Identifier: Apache-2.0
// Control nets of polynomials of two variables in Bernstein form, and what is done to them: parts,
// derivatives, degrees raised, ranges. The values of a polynomial over the unit square lie within
// the range of its net.
//
// Layout: coefficient (i, j), of u^i v^j, is c[i][j]; all others are not looked at. There is room
// for two degrees more than patches have, for products with linear functions.
//
// Threads. Plain values; pure functions.
#pragma once

#include <algorithm>
#include <cmath>

#include "slave/core/primitive/patch/patch_layout.h"

namespace tessera::core {

struct PatchNet {
  int m = 0, n = 0;
  double c[kPatchDegreeMax + 3][kPatchDegreeMax + 3] = {};
};

inline PatchNet net_of(int m, int n) {
  PatchNet net;
  net.m = m;
  net.n = n;
  return net;
}

struct NetRange {
  double low, high;
  double size() const { return std::max(std::fabs(low), std::fabs(high)); }
};

inline NetRange range_of(const PatchNet& net) {
  NetRange range{net.c[0][0], net.c[0][0]};
  for (int i = 0; i <= net.m; ++i)
    for (int j = 0; j <= net.n; ++j) {
      range.low = std::min(range.low, net.c[i][j]);
      range.high = std::max(range.high, net.c[i][j]);
    }
  return range;
}
inline double size_of(const PatchNet& net) { return range_of(net).size(); }

// Restricts a net to u in [a, 1], or to [0, a], by de Casteljau's scheme. For a = 1/2 each of its
// steps has one rounding.
inline void cut_u(PatchNet& net, double a, bool keeps_high) {
  for (int k = 1; k <= net.m; ++k)
    for (int q = 0; q <= net.m - k; ++q) {
      const int i = keeps_high ? q : net.m - q, low = keeps_high ? i : i - 1;
      for (int j = 0; j <= net.n; ++j)
        net.c[i][j] = (1 - a) * net.c[low][j] + a * net.c[low + 1][j];
    }
}
// The same of v.
inline void cut_v(PatchNet& net, double a, bool keeps_high) {
  for (int i = 0; i <= net.m; ++i)
    for (int k = 1; k <= net.n; ++k)
      for (int q = 0; q <= net.n - k; ++q) {
        const int j = keeps_high ? q : net.n - q, low = keeps_high ? j : j - 1;
        net.c[i][j] = (1 - a) * net.c[i][low] + a * net.c[i][low + 1];
      }
}

// Derivatives by x and y, where the net's square is [-1, 1]^2.
inline PatchNet derivative_x(const PatchNet& net) {
  PatchNet d = net_of(std::max(net.m - 1, 0), net.n);
  for (int i = 0; i < net.m; ++i)
    for (int j = 0; j <= net.n; ++j) d.c[i][j] = 0.5 * net.m * (net.c[i + 1][j] - net.c[i][j]);
  return d;
}
inline PatchNet derivative_y(const PatchNet& net) {
  PatchNet d = net_of(net.m, std::max(net.n - 1, 0));
  for (int i = 0; i <= net.m; ++i)
    for (int j = 0; j < net.n; ++j) d.c[i][j] = 0.5 * net.n * (net.c[i][j + 1] - net.c[i][j]);
  return d;
}

// The net times (low (1 - u) + high u): of one degree more in u. (1, 1) raises the degree, and
// (-1, 1) is the product with x where the square is [-1, 1]^2.
inline PatchNet times_u(const PatchNet& net, double low, double high) {
  PatchNet e = net_of(net.m + 1, net.n);
  for (int i = 0; i <= e.m; ++i) {
    const double a = static_cast<double>(i) / e.m;
    for (int j = 0; j <= e.n; ++j)
      e.c[i][j] =
          (i > 0 ? high * a * net.c[i - 1][j] : 0) + (i < e.m ? low * (1 - a) * net.c[i][j] : 0);
  }
  return e;
}
// The same of v.
inline PatchNet times_v(const PatchNet& net, double low, double high) {
  PatchNet e = net_of(net.m, net.n + 1);
  for (int j = 0; j <= e.n; ++j) {
    const double a = static_cast<double>(j) / e.n;
    for (int i = 0; i <= e.m; ++i)
      e.c[i][j] =
          (j > 0 ? high * a * net.c[i][j - 1] : 0) + (j < e.n ? low * (1 - a) * net.c[i][j] : 0);
  }
  return e;
}

// Requires: nets of the same degrees.
inline PatchNet difference(const PatchNet& a, const PatchNet& b) {
  PatchNet d = net_of(a.m, a.n);
  for (int i = 0; i <= d.m; ++i)
    for (int j = 0; j <= d.n; ++j) d.c[i][j] = a.c[i][j] - b.c[i][j];
  return d;
}

}  // namespace tessera::core
