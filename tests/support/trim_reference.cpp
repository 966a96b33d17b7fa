// SPDX-License-Identifier: Apache-2.0
#include "tests/support/trim_reference.h"

#include <algorithm>
#include <array>

namespace tessera::test {

TrimReference::TrimReference(const PatchSurface& surface, std::size_t patch, double tolerance)
    : tolerance_(tolerance),
      keeps_outside_(surface.patches[patch].keeps_outside != 0),
      is_whole_(surface.loop_counts.empty() || surface.loop_counts[patch] == 0) {
  std::size_t loop = 0, segment = 0, point = 0;
  for (std::size_t p = 0; p <= patch && !is_whole_; ++p) {
    for (std::uint32_t l = 0; l < surface.loop_counts[p]; ++l, ++loop) {
      const std::size_t begin = point;
      for (std::uint32_t s = 0; s < surface.segment_counts[loop]; ++s, ++segment) {
        Segment made;
        for (std::size_t i = 0; i <= surface.degrees[segment]; ++i) {
          const bool is_end = i == surface.degrees[segment];
          const bool closes = is_end && s + 1 == surface.segment_counts[loop];
          const TrimPoint& x = surface.trim_points[closes ? begin : point + i];
          made.points.push_back({Long{x.weight} * x.u, Long{x.weight} * x.v, x.weight});
        }
        point += surface.degrees[segment];
        made.ends[0] = made.points.front().u / made.points.front().w;
        made.ends[1] = made.points.back().u / made.points.back().w;
        bound(made.points.data(), surface.degrees[segment], made.low, made.high);
        if (p == patch) segments_.push_back(std::move(made));
      }
    }
  }
}

std::optional<bool> TrimReference::is_kept(double u, double v) {
  if (is_whole_) return true;
  u_ = u;
  v_ = v;
  is_near_ = false;
  bool is_odd = false;
  for (const Segment& s : segments_) {
    // What is left, right or below is not crossed by a ray towards +v.
    if (s.low[0] > u_ + tolerance_ || s.high[0] < u_ - tolerance_ || s.high[1] < v_ - tolerance_)
      continue;
    if (s.low[1] > v_ + tolerance_) {
      is_odd ^= (s.ends[0] <= u_) != (s.ends[1] <= u_);
      continue;
    }
    is_odd ^= crosses(s.points.data(), static_cast<int>(s.points.size()) - 1, 0);
    if (is_near_) return std::nullopt;
  }
  return is_odd != keeps_outside_;
}

void TrimReference::bound(const Point* points, int degree, Long (&low)[2], Long (&high)[2]) const {
  for (int i = 0; i <= degree; ++i) {
    const Long at[2] = {points[i].u / points[i].w, points[i].v / points[i].w};
    for (int a = 0; a < 2; ++a) {
      low[a] = i == 0 ? at[a] : std::min(low[a], at[a]);
      high[a] = i == 0 ? at[a] : std::max(high[a], at[a]);
    }
  }
}

bool TrimReference::crosses(const Point* points, int degree, int depth) {
  if (is_near_) return false;
  Long low[2], high[2];
  bound(points, degree, low, high);
  const Long away_u = std::max({low[0] - u_, u_ - high[0], Long{0}});
  const Long away_v = std::max({low[1] - v_, v_ - high[1], Long{0}});
  if (away_u * away_u + away_v * away_v > tolerance_ * tolerance_) {
    const Long a_u = points[0].u / points[0].w, b_u = points[degree].u / points[degree].w;
    if ((a_u <= u_) == (b_u <= u_)) return false;
    if (low[1] > v_) return true;
    if (high[1] < v_) return false;
    const Long a_v = points[0].v / points[0].w, b_v = points[degree].v / points[degree].w;
    return (a_v - v_) + (b_v - a_v) * ((u_ - a_u) / (b_u - a_u)) > 0;
  }
  const Long least = 0x1p-34L;
  if ((high[0] - low[0] <= least && high[1] - low[1] <= least) || depth > 400) {
    is_near_ = true;
    return false;
  }
  std::array<Point, kPatchDegreesMax + 1> first, second;
  std::copy(points, points + degree + 1, second.begin());
  for (int k = 0; k <= degree; ++k) {
    first[static_cast<std::size_t>(k)] = second[0];
    for (int i = 0; i < degree - k; ++i) {
      Point& a = second[static_cast<std::size_t>(i)];
      const Point& b = second[static_cast<std::size_t>(i) + 1];
      a = {(a.u + b.u) / 2, (a.v + b.v) / 2, (a.w + b.w) / 2};
    }
  }
  const bool by_first = crosses(first.data(), degree, depth + 1);
  return by_first != crosses(second.data(), degree, depth + 1);
}

}  // namespace tessera::test
