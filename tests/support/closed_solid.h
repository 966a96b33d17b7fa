// SPDX-License-Identifier: Apache-2.0
// Whether rays from inside of a closed solid of trimmed patches get out of it where its faces meet.
//
// What is a leak. A ray that begins inside and meets nothing, or meets the outside of a face before
// it has met the inside of one. Two things are passed: what a surface has beyond its loops, as
// widths give it, may stick into the solid; and where a solid is hollow at an edge, a ray at the
// edge leaves by one face and enters by the other, in either order within their gap; so it is where
// two faces of a file lie one on the other. Then it has to leave behind that. A ray that does not,
// but met a widened border, was held by it: in the slit between two faces of which one lies above
// the other, nothing says which way their normals face it. Such rays are counted on their own.
// Whether a place is inside is asked by three lines through it, which all have to leave both ways.
//
// Threads. An object is one thread's.
#pragma once

#include <cstddef>
#include <functional>
#include <memory>
#include <vector>

#include "common/math/vec3d.h"
#include "common/scene/patch_surface.h"
#include "slave/core/scene/prepared_scene.h"
#include "slave/core/scene/ray_caster.h"
#include "tests/support/choices.h"

namespace tessera::test {

// A place of an edge, as both of its faces have it; normals of length 1 that point out.
struct EdgePlace {
  Vec3d on[2], normal[2];
};

struct LeakCounts {
  std::size_t rays = 0, leaks = 0;
  std::size_t held = 0;               // by a widened border alone
  std::size_t passed = 0;             // what is passed, of all rays
  std::size_t doubted = 0;            // hits that were asked for another face at their place
  std::size_t outside = 0;            // places that were not inside
  std::vector<core::CastRay> leaked;  // the first of those that leak
};

class ClosedSolid {
 public:
  // size: of its box; reach: how far from an edge faces may be met instead of it.
  // Requires: a surface that validate_scene() takes, whose normals point out.
  ClosedSolid(const PatchSurface& surface, double size, double reach);

  // Casts `count` rays from inside at places of edges.
  LeakCounts cast(const std::function<EdgePlace()>& place, std::size_t count,
                  Choices& choices) const;

 private:
  core::CastRay ray_at(const EdgePlace& place, Choices& choices) const;
  std::vector<core::CastRay> inside(const std::vector<core::CastRay>& rays, Choices& choices) const;
  // A ray from inside.
  struct Walk {
    core::CastRay ray;
    bool has_met_border = false;
  };

  void cast_all(const std::vector<core::CastRay>& rays, LeakCounts& counts) const;
  bool is_on_another(const core::CastRay& ray, const core::CastHit& hit) const;

  const PatchSurface surface_;
  double size_, reach_;
  std::shared_ptr<const core::PreparedScene> solid_, without_widths_;
};

}  // namespace tessera::test
