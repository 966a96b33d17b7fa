// SPDX-License-Identifier: Apache-2.0
#include "tests/support/patch_area.h"

#include <array>
#include <cmath>

namespace tessera::test {
namespace {

// Gauss-Legendre over [0, 1] with 8 nodes.
constexpr std::array<double, 8> kNodes = {
    0.01985507175123188, 0.10166676129318664, 0.2372337950418355,  0.40828267875217511,
    0.59171732124782489, 0.7627662049581645,  0.89833323870681336, 0.98014492824876812};
constexpr std::array<double, 8> kShares = {
    0.05061426814518813, 0.11119051722668724, 0.15685332293894364, 0.18134189168918099,
    0.18134189168918099, 0.15685332293894364, 0.11119051722668724, 0.05061426814518813};
constexpr int kParts = 4;  // of each interval

struct D3 {
  double x = 0, y = 0, z = 0, w = 0;
};
struct D2 {
  double u = 0, v = 0;
};

void bernstein(int n, double t, double* b, double* d) {
  double lower[kPatchDegreesMax + 2] = {1};
  for (int k = 1; k < n; ++k) {
    lower[k] = t * lower[k - 1];
    for (int i = k - 1; i > 0; --i) lower[i] = t * lower[i - 1] + (1 - t) * lower[i];
    lower[0] *= 1 - t;
  }
  for (int i = 0; i <= n; ++i) {
    const double left = i > 0 ? lower[i - 1] : 0, right = i < n ? lower[i] : 0;
    b[i] = t * left + (1 - t) * right;
    d[i] = n * (left - right);
  }
}

enum class Measure { kArea, kVolume };

// |dS/du x dS/dv|, or S . (dS/du x dS/dv) / 3.
double stretch(Measure measure, const PatchCursor& patch, double u, double v) {
  const int n = patch.form().degree_u, m = patch.form().degree_v;
  double bu[16], du[16], bv[16], dv[16];
  bernstein(n, u, bu, du);
  bernstein(m, v, bv, dv);
  D3 s, su, sv;
  for (int i = 0; i <= n; ++i) {
    for (int j = 0; j <= m; ++j) {
      const auto k = static_cast<std::size_t>((m + 1) * i + j);
      const Vec3f p = patch.point(k);
      const double w = patch.weight(k);
      const auto add = [&](D3& to, double share) {
        to.x += share * p.x, to.y += share * p.y, to.z += share * p.z, to.w += share;
      };
      add(s, w * bu[i] * bv[j]);
      add(su, w * du[i] * bv[j]);
      add(sv, w * bu[i] * dv[j]);
    }
  }
  const auto slope = [&](const D3& d) {
    return D3{(d.x - d.w * s.x / s.w) / s.w, (d.y - d.w * s.y / s.w) / s.w,
              (d.z - d.w * s.z / s.w) / s.w, 0};
  };
  const D3 a = slope(su), b = slope(sv);
  const D3 normal{a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x, 0};
  if (measure == Measure::kArea) return std::hypot(normal.x, normal.y, normal.z);
  return (s.x * normal.x + s.y * normal.y + s.z * normal.z) / s.w / 3;
}

// Integral of stretch() along u.
double strip(Measure measure, const PatchCursor& patch, double to, double v) {
  double sum = 0;
  for (int part = 0; part < kParts; ++part) {
    for (std::size_t k = 0; k < kNodes.size(); ++k)
      sum += kShares[k] / kParts * stretch(measure, patch, to * (part + kNodes[k]) / kParts, v);
  }
  return to * sum;
}

double whole(Measure measure, const PatchCursor& patch) {
  double sum = 0;
  for (int part = 0; part < kParts; ++part) {
    for (std::size_t k = 0; k < kNodes.size(); ++k)
      sum += kShares[k] / kParts * strip(measure, patch, 1, (part + kNodes[k]) / kParts);
  }
  return sum;
}

using Segment = std::vector<TrimPoint>;
using Loop = std::vector<Segment>;

void place(const Segment& s, double t, D2& at, D2& slope) {
  const int n = static_cast<int>(s.size()) - 1;
  double b[16], d[16];
  bernstein(n, t, b, d);
  double u = 0, v = 0, w = 0, du = 0, dv = 0, dw = 0;
  for (int i = 0; i <= n; ++i) {
    const TrimPoint& p = s[static_cast<std::size_t>(i)];
    const double weight = p.weight;
    u += weight * b[i] * p.u, v += weight * b[i] * p.v, w += weight * b[i];
    du += weight * d[i] * p.u, dv += weight * d[i] * p.v, dw += weight * d[i];
  }
  at = {u / w, v / w};
  slope = {(du - dw * at.u) / w, (dv - dw * at.v) / w};
}

std::vector<Loop> loops_of(const PatchSurface& surface, const PatchCursor& patch) {
  std::vector<Loop> loops;
  std::size_t segment = patch.first_segment(), point = patch.first_trim_point();
  for (std::size_t i = 0; i < patch.loop_count(); ++i) {
    Loop loop;
    for (std::uint32_t k = surface.segment_counts[patch.first_loop() + i]; k > 0; --k) {
      loop.emplace_back(
          surface.trim_points.begin() + static_cast<long>(point),
          surface.trim_points.begin() + static_cast<long>(point + surface.degrees[segment]));
      point += surface.degrees[segment++];
    }
    for (std::size_t k = 0; k < loop.size(); ++k)
      loop[k].push_back(loop[(k + 1) % loop.size()].front());
    loops.push_back(std::move(loop));
  }
  return loops;
}

// Whether a loop, as a polygon of 64 lines a segment, encloses a place.
bool encloses(const Loop& loop, D2 p) {
  bool is_odd = false;
  for (const Segment& s : loop) {
    D2 a, b, slope;
    place(s, 0, a, slope);
    for (int i = 1; i <= 64; ++i, a = b) {
      place(s, i / 64.0, b, slope);
      if ((a.v > p.v) != (b.v > p.v) && p.u < a.u + (p.v - a.v) / (b.v - a.v) * (b.u - a.u))
        is_odd = !is_odd;
    }
  }
  return is_odd;
}

double enclosed(Measure measure, const PatchCursor& patch, const Loop& loop) {
  double sum = 0, square = 0;  // `square`: the loop's own area, which says which way it goes round
  for (const Segment& s : loop) {
    for (int part = 0; part < kParts; ++part) {
      for (std::size_t k = 0; k < kNodes.size(); ++k) {
        D2 at, slope;
        place(s, (part + kNodes[k]) / kParts, at, slope);
        if (slope.v == 0) continue;
        sum += kShares[k] / kParts * slope.v * strip(measure, patch, at.u, at.v);
        square += kShares[k] / kParts * slope.v * at.u;
      }
    }
  }
  return square < 0 ? -sum : sum;
}

double measured(Measure measure, const PatchSurface& surface, const PatchCursor& patch) {
  const std::vector<Loop> loops = loops_of(surface, patch);
  if (loops.empty()) return whole(measure, patch);
  double sum = 0;
  for (std::size_t i = 0; i < loops.size(); ++i) {
    D2 p, slope;
    place(loops[i][0], 0.4637, p, slope);
    int depth = 0;
    for (std::size_t j = 0; j < loops.size(); ++j)
      if (j != i && encloses(loops[j], p)) ++depth;
    sum += (depth % 2 == 0 ? 1 : -1) * enclosed(measure, patch, loops[i]);
  }
  return patch.form().keeps_outside != 0 ? whole(measure, patch) - sum : sum;
}

}  // namespace

std::vector<double> patch_areas(const PatchSurface& surface) {
  std::vector<double> areas;
  for (PatchCursor patch(surface); patch.is_any(); patch.advance())
    areas.push_back(measured(Measure::kArea, surface, patch));
  return areas;
}

double surface_volume(const PatchSurface& surface) {
  double sum = 0;
  for (PatchCursor patch(surface); patch.is_any(); patch.advance())
    sum += measured(Measure::kVolume, surface, patch);
  return sum;
}

}  // namespace tessera::test
