// SPDX-License-Identifier: Apache-2.0
#include "tests/bench/thesis_bundle.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <set>

#include "common/math/bounds3.h"
#include "slave/core/primitive/triangle/exact_hit_abi.h"

namespace tessera::bench {
namespace {

// Precomputed numbers of a triangle for the projection test (5.1, after Wald 2004), in float32.
struct Projection {
  int k;
  float n_u, n_v, n_d;
  float b_nu, b_nv, b_d, c_nu, c_nv, c_d;

  Projection(Vec3f a, Vec3f b, Vec3f c) {
    const Vec3f e = c - a, f = b - a, n = cross(e, f);
    k = std::fabs(n.x) > std::fabs(n.y) ? 0 : 1;
    if (std::fabs(n.z) > std::fabs(n[k])) k = 2;
    const int u = (k + 1) % 3, v = (k + 2) % 3;
    n_u = n[u] / n[k];
    n_v = n[v] / n[k];
    n_d = dot(n, a) / n[k];
    const float area = e[u] * f[v] - e[v] * f[u];
    b_nu = -e[v] / area;
    b_nv = e[u] / area;
    b_d = (e[v] * a[u] - e[u] * a[v]) / area;
    c_nu = f[v] / area;
    c_nv = -f[u] / area;
    c_d = (f[u] * a[v] - f[v] * a[u]) / area;
  }
};

struct Answer {
  float t;
  bool is_inside;
};

Answer test_projection(const Projection& p, Vec3f origin, Vec3f d) {
  const int u = (p.k + 1) % 3, v = (p.k + 2) % 3;
  const float speed = d[p.k] + p.n_u * d[u] + p.n_v * d[v];
  const float t = (p.n_d - origin[p.k] - p.n_u * origin[u] - p.n_v * origin[v]) / speed;
  const float hu = origin[u] + t * d[u], hv = origin[v] + t * d[v];
  const float lambda = hu * p.b_nu + hv * p.b_nv + p.b_d;
  const float mue = hu * p.c_nu + hv * p.c_nv + p.c_d;
  return {t, lambda >= 0 && mue >= 0 && lambda + mue <= 1};
}

// The Pluecker test in its common-origin form (5.2): signs of three volumes.
bool is_inside_pluecker(Vec3f a, Vec3f b, Vec3f c, Vec3f origin, Vec3f d) {
  const Vec3f pa = a - origin, pb = b - origin, pc = c - origin;
  const float ab = dot(cross(pb, pa), d), bc = dot(cross(pc, pb), d), ca = dot(cross(pa, pc), d);
  return (ab >= 0 && bc >= 0 && ca >= 0) || (ab <= 0 && bc <= 0 && ca <= 0);
}

}  // namespace

ThesisBundle::ThesisBundle(const core::TriangleStore& triangles, const core::CameraRays& camera)
    : triangles_(triangles), camera_(camera), mailbox_(triangles.primitive_count()) {
  for (int a = 0; a < 3; ++a) origin_[a] = double{camera.origin()[a]};
  for (std::size_t i = 0; i < kMailboxSizes.size(); ++i) hashed_[i].resize(kMailboxSizes[i]);
}

void ThesisBundle::add(double x, double y) {
  const Vec3f d = camera_.direction(x, y);
  direction_.push_back({d.x, d.y, d.z});
}

bool ThesisBundle::has_one_side() {
  ++bundle_;
  best_.assign(size(), std::numeric_limits<double>::infinity());
  bool is_one = true;
  for (int a = 0; a < 3; ++a) {
    goes_down_[a] = direction(0, a) < 0;
    for (std::size_t i = 0; i < size(); ++i)
      is_one = is_one && (direction(i, a) < 0) == goes_down_[a] && direction(i, a) != 0;
  }
  return is_one;
}

// Adds rays by quads of 2x2 pixels, so that four consecutive rays are what a register held.
bool ThesisBundle::begin(int x_px, int y_px, int edge_px) {
  direction_.clear();
  for (int quad = 0; quad < (edge_px * edge_px + 3) / 4; ++quad) {
    const int across = std::max(edge_px / 2, 1);
    const int x = x_px + quad % across * 2, y = y_px + quad / across * 2;
    for (int i = 0; i < std::min(4, edge_px * edge_px); ++i) add(x + i % 2 + 0.5, y + i / 2 + 0.5);
  }
  const std::size_t n = size(), row = 2 * static_cast<std::size_t>(edge_px);
  corners_ = {0};
  if (n > 1) corners_ = {0, row - 3, n - row + 2, n - 1};
  return has_one_side();
}

bool ThesisBundle::begin_corners(int x_px, int y_px, int edge_px) {
  direction_.clear();
  for (int i = 0; i < 4; ++i) add(x_px + i % 2 * edge_px, y_px + i / 2 * edge_px);
  corners_ = {0, 1, 2, 3};
  return has_one_side();
}

Segment ThesisBundle::clip(std::size_t ray, const Voxel& voxel) const {
  Segment segment{0, std::numeric_limits<double>::infinity()};
  for (int a = 0; a < 3; ++a) {
    const double p = distance(ray, a, goes_down(a) ? voxel.upper[a] : voxel.lower[a]);
    const double q = distance(ray, a, goes_down(a) ? voxel.lower[a] : voxel.upper[a]);
    segment.near = std::max(segment.near, p);
    segment.far = std::min(segment.far, q);
  }
  return segment;
}

void ThesisBundle::test_leaf(const std::uint32_t* triangles, std::uint32_t count, bool with_details,
                             ThesisCounts& counts) {
  if (count == 0) return;
  ++counts.leaves;
  counts.tests += count;
  Bounds3f box;
  std::set<std::array<float, 6>> edges;
  for (std::uint32_t i = 0; i < count; ++i) {
    for (int c = 0; c < 3; ++c) {
      const Vec3f p = triangles_.vertex(triangles[i], c);
      const Vec3f q = triangles_.vertex(triangles[i], (c + 1) % 3);
      box.grow(p);
      if (!with_details) continue;
      const std::array<float, 6> edge{p.x, p.y, p.z, q.x, q.y, q.z};
      const std::array<float, 6> turned{q.x, q.y, q.z, p.x, p.y, p.z};
      edges.insert(std::min(edge, turned));
    }
  }
  counts.edges += edges.size();
  Voxel around{};
  for (int a = 0; a < 3; ++a) {
    around.lower[a] = double{box.lower[a]};
    around.upper[a] = double{box.upper[a]};
  }
  bool is_met = false;
  for (std::size_t i = 0; i < size() && !is_met; ++i) is_met = !clip(i, around).is_empty();
  if (!is_met) counts.tests_outside_box += count;
  for (std::uint32_t i = 0; i < count; ++i) {
    count_repeats(triangles[i], counts);
    if (mailbox_[triangles[i]] == bundle_) continue;
    mailbox_[triangles[i]] = bundle_;
    ++counts.tests_once;
    test(triangles[i], with_details, counts);
  }
}

void ThesisBundle::count_repeats(std::uint32_t triangle, ThesisCounts& counts) {
  for (std::size_t i = 0; i < hashed_.size(); ++i) {
    Slot& slot = hashed_[i][triangle % kMailboxSizes[i]];
    if (slot.triangle == triangle && slot.bundle == bundle_) continue;
    slot = {triangle, bundle_};
    ++counts.tests_hashed[i];
  }
}

void ThesisBundle::test(std::uint32_t triangle, bool with_details, ThesisCounts& counts) {
  const Vec3f a = triangles_.vertex(triangle, 0), b = triangles_.vertex(triangle, 1),
              c = triangles_.vertex(triangle, 2);
  const Projection projection(a, b, c);
  const Vec3f origin = camera_.origin();
  for (std::size_t first = 0; first < size(); first += 4) {
    bool is_near = false, is_inside = false, is_hit = false;
    for (std::size_t i = first; i < std::min(first + 4, size()); ++i) {
      const Vec3f d{direction_[i][0], direction_[i][1], direction_[i][2]};
      const Answer answer = test_projection(projection, origin, d);
      const bool in_range = answer.t > 0 && double{answer.t} < best_[i];
      is_near |= in_range;
      is_inside |= answer.is_inside;
      if (in_range && answer.is_inside) {
        is_hit = true;
        best_[i] = double{answer.t};
      }
      if (!with_details) continue;
      const float corners[9] = {a.x, a.y, a.z, b.x, b.y, b.z, c.x, c.y, c.z};
      const core::ExactHit exact = core::exact_hit(&origin.x, &d.x, corners);
      const bool is_exact = exact.is_hit && exact.t > 0;
      const bool is_projection = answer.is_inside && answer.t > 0;
      const bool is_pluecker = is_inside_pluecker(a, b, c, origin, d) && answer.t > 0;
      ++counts.decisions;
      counts.projection_errors += is_projection != is_exact ? 1 : 0;
      counts.pluecker_errors += is_pluecker != is_exact ? 1 : 0;
    }
    if (!is_near) ++counts.exit_by_distance;
    if (is_near && !is_hit) ++counts.exit_inside;
    if (is_hit) ++counts.full;
    if (is_inside) ++counts.full_without_distance;
  }
}

}  // namespace tessera::bench
