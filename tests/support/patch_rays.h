// SPDX-License-Identifier: Apache-2.0
// Kinds of rays to try patches with.
// Threads. Owned by one test.
#pragma once

#include "common/math/vec3d.h"
#include "tests/support/choices.h"
#include "tests/support/patch_shapes.h"

namespace tessera::test {

enum class PatchRays {
  kCamera,  // from outside to somewhere in the box
  kInside,  // from inside of a closed shape, anywhere
  kBorder,  // from outside at borders of patches and parts, and at poles
  kInsideAtBorder,
  kGrazing,  // at 10^-7 to 1 to the surface
  kFar,      // from a thousand sizes away
};

class PatchRayMaker {
 public:
  // is_ring: what is inside is near a circle about the z axis, as a torus has it, else near the
  // middle of the shape's box; both as moved by `moved` with the scale and shift.
  PatchRayMaker(const PatchScene& scene, bool is_ring, unsigned seed, float scale = 1,
                float shift = 0)
      : scene_(scene), any_(seed), is_ring_(is_ring), scale_(scale), shift_(shift) {}

  core::PatchRay next(PatchRays kind);
  Choices& any() { return any_; }

 private:
  Vec3d ball();
  Vec3d outside();
  Vec3d inside(double angle);
  Vec3d placed(Vec3d p) const { return p * double{scale_} + Vec3d{1, 1, 1} * double{shift_}; }
  double number() { return double{any_.share()}; }
  // A parameter on the border of a part of level 0 to 5.
  double border();
  core::PatchRay at_border(bool from_inside);
  core::PatchRay at_surface(PatchRays kind);

  const PatchScene& scene_;
  Choices any_;
  bool is_ring_;
  float scale_, shift_;
};

}  // namespace tessera::test
