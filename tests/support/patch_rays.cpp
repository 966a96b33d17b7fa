// SPDX-License-Identifier: Apache-2.0
#include "tests/support/patch_rays.h"

#include <cmath>

#include "slave/core/primitive/patch/patch_evaluation.h"

namespace tessera::test {
namespace {

constexpr double kTwoPi = 6.283185307179586;

Vec3d vector(const double (&a)[3]) { return {a[0], a[1], a[2]}; }

core::PatchRay from_to(Vec3d from, Vec3d to) {
  core::PatchRay ray{};
  for (int k = 0; k < 3; ++k) {
    ray.origin[k] = static_cast<float>(from[k]);
    ray.direction[k] = static_cast<float>(to[k] - from[k]);
  }
  ray.t_min = 0;
  return ray;
}

}  // namespace

Vec3d PatchRayMaker::ball() {
  for (;;) {
    const Vec3d v{2 * number() - 1, 2 * number() - 1, 2 * number() - 1};
    if (dot(v, v) <= 1 && dot(v, v) > 0.01) return v;
  }
}

Vec3d PatchRayMaker::outside() {
  const Bounds3f& box = scene_.bounds();
  const Vec3d middle = 0.5 * (widened(box.lower) + widened(box.upper)), d = ball();
  return middle + (1.5 * length(widened(box.extent())) / length(d)) * d;
}

// In units of the shape, as it was before it was moved.
Vec3d PatchRayMaker::inside(double angle) {
  if (!is_ring_) return placed(0.05 * ball());
  return placed(Vec3d{std::cos(angle), std::sin(angle), 0} + 0.2 * ball());
}

double PatchRayMaker::border() {
  const unsigned parts = 1u << any_.below(6);
  return static_cast<double>(any_.below(parts + 1)) / parts;
}

core::PatchRay PatchRayMaker::at_border(bool from_inside) {
  const core::Patch patch = scene_.patch(any_.below(static_cast<unsigned>(scene_.patch_count())));
  const bool is_u = any_.one_in(2);
  const double s = border(), r = any_.one_in(4) ? border() : number();
  const Vec3d p = vector(core::evaluate(patch, is_u ? s : r, is_u ? r : s).point);
  if (!from_inside) return from_to(outside(), p);
  const Vec3d q = (p - Vec3d{1, 1, 1} * double{shift_}) * (1 / double{scale_});
  return from_to(inside(std::atan2(q.y, q.x) + 0.2 * (number() - 0.5)), p);
}

core::PatchRay PatchRayMaker::at_surface(PatchRays kind) {
  const core::Patch patch = scene_.patch(any_.below(static_cast<unsigned>(scene_.patch_count())));
  const core::PatchJet jet = core::evaluate(patch, number(), number());
  const Vec3d p = vector(jet.point), du = vector(jet.du), dv = vector(jet.dv), n = cross(du, dv);
  const Bounds3f& box = scene_.bounds();
  const double size = length(widened(box.extent()));
  if (kind == PatchRays::kFar) {
    const Vec3d middle = 0.5 * (widened(box.lower) + widened(box.upper));
    return from_to(middle + 1000.0 * (outside() - middle), p);
  }
  const double angle = kTwoPi * number(), steep = std::pow(10.0, -7 * number());
  const Vec3d along = normalize(std::cos(angle) * normalize(du) + std::sin(angle) * normalize(dv));
  const Vec3d d = along + (any_.one_in(2) ? steep : -steep) * normalize(n);
  return from_to(p - ((0.5 + number()) * size) * d, p);
}

core::PatchRay PatchRayMaker::next(PatchRays kind) {
  switch (kind) {
    case PatchRays::kCamera: {
      const Bounds3f& box = scene_.bounds();
      const Vec3d e = widened(box.extent());
      return from_to(outside(), widened(box.lower) + e * Vec3d{number(), number(), number()});
    }
    case PatchRays::kInside: {
      const Vec3d o = inside(kTwoPi * number());
      return from_to(o, o + double{scale_} * ball());
    }
    case PatchRays::kBorder:
    case PatchRays::kInsideAtBorder:
      return at_border(kind == PatchRays::kInsideAtBorder);
    case PatchRays::kGrazing:
    case PatchRays::kFar:
      break;
  }
  return at_surface(kind);
}

}  // namespace tessera::test
