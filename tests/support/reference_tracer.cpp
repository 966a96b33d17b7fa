// SPDX-License-Identifier: Apache-2.0
#include "tests/support/reference_tracer.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace tessera::test {
namespace {

struct Vec3d {
  double x, y, z;
};
Vec3d operator-(Vec3d a, Vec3d b) { return {a.x - b.x, a.y - b.y, a.z - b.z}; }
Vec3d to_double(Vec3f a) { return {a.x, a.y, a.z}; }
double dot(Vec3d a, Vec3d b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
Vec3d cross(Vec3d a, Vec3d b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
double length(Vec3d a) { return std::sqrt(dot(a, a)); }

constexpr double kTolerance = 16 * 0x1p-24;

// Distance of the ray from the line through p and q in the plane across the ray; positive on the
// left.
double signed_distance(Vec3d p, Vec3d q, Vec3d direction) {
  const Vec3d edge = q - p;
  const Vec3d across = cross(direction, edge);
  const double size = length(across);
  return size > 0 ? dot(across, p) / size : 0;
}

}  // namespace

ReferenceAnswer reference_hit(const Ray& ray, const ReferenceTriangle& triangle) {
  const Vec3d origin = to_double(ray.origin), direction = to_double(ray.direction);
  const Vec3d a = to_double(triangle.a) - origin, b = to_double(triangle.b) - origin,
              c = to_double(triangle.c) - origin;
  const double s = std::max({length(a), length(b), length(c)});
  const Vec3d normal = cross(b - a, c - a);
  const double slope = dot(normal, direction);
  double distance[3] = {signed_distance(a, b, direction), signed_distance(b, c, direction),
                        signed_distance(c, a, direction)};
  if (slope > 0) {
    for (double& d : distance) d = -d;
  }
  const double inside = std::min({distance[0], distance[1], distance[2]});
  ReferenceAnswer answer;
  const double cosine = std::fabs(slope) / (length(normal) * length(direction));
  answer.t = dot(normal, a) / slope;
  answer.t_error = kTolerance * s / (length(direction) * cosine);
  // Nothing can be said of a triangle that is seen edge-on within the tolerance.
  if (!(slope != 0) || !(answer.t_error < s / length(direction))) {
    answer.verdict = Verdict::kEdge;
    answer.t_error = std::numeric_limits<double>::infinity();
    if (inside > -kTolerance * s || slope == 0) return answer;
  }
  const bool is_out =
      answer.t < ray.t_min - answer.t_error || answer.t > ray.t_max + answer.t_error;
  const bool is_in = answer.t > ray.t_min + answer.t_error && answer.t < ray.t_max - answer.t_error;
  if (inside < -kTolerance * s || is_out) {
    answer.verdict = Verdict::kMiss;
  } else {
    answer.verdict = inside > kTolerance * s && is_in ? Verdict::kHit : Verdict::kEdge;
  }
  return answer;
}

const char* judge(const Ray& ray, const std::vector<ReferenceTriangle>& triangles, bool is_hit,
                  std::uint32_t primitive, float t) {
  double nearest_sure = std::numeric_limits<double>::infinity();
  for (const ReferenceTriangle& triangle : triangles) {
    const ReferenceAnswer answer = reference_hit(ray, triangle);
    if (answer.verdict == Verdict::kHit)
      nearest_sure = std::min(nearest_sure, answer.t + answer.t_error);
  }
  if (!is_hit) return nearest_sure < std::numeric_limits<double>::infinity() ? "missed" : nullptr;
  if (primitive >= triangles.size()) return "primitive out of range";
  const ReferenceAnswer own = reference_hit(ray, triangles[primitive]);
  if (own.verdict == Verdict::kMiss) return "false hit";
  if (std::isfinite(own.t_error)) {
    if (!(std::fabs(t - own.t) <= own.t_error)) return "t is off";
    if (own.t - own.t_error > nearest_sure) return "wrong primitive: another one is closer";
  }
  return nullptr;
}

}  // namespace tessera::test
