// SPDX-License-Identifier: Apache-2.0
#include "slave/core/primitive/freeform/patch_point.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "common/math/rounding.h"
#include "common/math/vec3d.h"
#include "slave/core/primitive/patch/methods/patch_methods.h"
#include "slave/core/primitive/patch/patch_evaluation.h"

namespace tessera::core {
namespace {

Vec3d in_double3(const double (&x)[3]) { return {x[0], x[1], x[2]}; }

// Whether the derivatives tell a normal, and which.
bool find_normal(const PatchJet& jet, Vec3d& normal) {
  const Vec3d du = in_double3(jet.du), dv = in_double3(jet.dv), across = cross(du, dv);
  const double size = length(across);
  if (!(size > 0x1p-30 * length(du) * length(dv))) return false;
  normal = (1 / size) * across;
  return true;
}

Vec3d normal_at(const Patch& patch, double u, double v, const PatchJet& jet, Vec3d otherwise) {
  Vec3d normal;
  if (find_normal(jet, normal)) return normal;
  for (double share = 0x1p-20; share < 1; share *= 2) {
    const double at_u = u + (0.5 - u) * share, at_v = v + (0.5 - v) * share;
    if (find_normal(evaluate(patch, at_u, at_v), normal)) return normal;
  }
  return otherwise;  // a patch that is a line
}

}  // namespace

PatchSurfacePoint patch_point(const Patch& patch, const SubPatch& part, const float* origin,
                              const float* direction, float t, PatchMethod method) {
  // The root itself may be below t, which is rounded.
  const float before = std::nextafter(t, -std::numeric_limits<float>::infinity());
  const PatchAnswer answer = answer_by(method, patch, part, origin, direction, before);
  const PatchJet jet = evaluate(patch, answer.u, answer.v);
  const Vec3d d{direction[0], direction[1], direction[2]};
  const Vec3d normal = normal_at(patch, answer.u, answer.v, jet, (-1 / length(d)) * d);
  double off = 0, most = 0;
  for (int a = 0; a < 3; ++a) {
    off += std::fabs(normal[a]) * std::fabs(jet.point[a]);
    most = std::max(most, std::fabs(jet.point[a]));
  }
  PatchSurfacePoint at;
  at.point = rounded(in_double3(jet.point));
  at.normal = rounded(normal);
  at.offset = static_cast<float>(4 * double{kUnitRoundoff} * off +
                                 8 * plain::kEvaluationError * (most + patch.extent) +
                                 2 * method_error(method, patch));
  at.u = static_cast<float>(answer.u);
  at.v = static_cast<float>(answer.v);
  return at;
}

const Mesh& mesh_of_patches() {
  static const Mesh mesh = [] {
    Mesh one;
    one.positions.resize(3);
    one.uvs = {{0, 0}, {1, 0}, {0, 1}};
    one.triangles = {{0, 1, 2}};
    one.materials = {0};
    return one;
  }();
  return mesh;
}

TangentTriangle tangent_triangle(const Patch& patch, float u, float v) {
  const PatchJet jet = evaluate(patch, double{u}, double{v});
  const Vec3d du = in_double3(jet.du), dv = in_double3(jet.dv);
  const Vec3d first = in_double3(jet.point) - double{u} * du - double{v} * dv;
  return {{rounded(first), rounded(first + du), rounded(first + dv)}};
}

}  // namespace tessera::core
