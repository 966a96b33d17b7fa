// SPDX-License-Identifier: Apache-2.0
// Where light subpaths begin: points that shed a share of a scene's light, and first rays of paths
// that carry it into the scene. Lights of every kind are picked by power.
//
// Points of a run of indices are taken from a (0,2)-sequence, so that light is spread evenly over
// position and direction (Keller, "Instant radiosity", 1997; Wald et al., "Interactive global
// illumination", 2002). A path carries flux; the mean over many paths is the power of all lights.
//
// Threads. Constant after construction.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "common/math/bounds3.h"
#include "slave/core/light/light_point_layout.h"
#include "slave/core/light/light_set.h"

namespace tessera::core {

// Up to this many delta lights are VPLs of their own; of more, VPLs are picked by power.
inline constexpr std::size_t kLightsEachMax = 8;

struct LightRay {
  Vec3f origin, direction;  // direction: unit
  Vec3f flux;               // as if this were the only path
};

class LightSubpaths {
 public:
  // bounds: of all geometry. Requires: lights outlives it.
  LightSubpaths(const LightSet& lights, const Bounds3f& bounds);

  // Lights that are VPLs of their own; every pixel gathers from each of them.
  const std::vector<LightPoint>& each() const { return each_; }

  // Power of the lights that place() picks from, and of all lights; luminance. 0: there are none.
  double placed_power() const { return placed_.total; }
  double power() const { return all_.total; }

  // Picks one point of those lights that are not in each(), with light as if it were the only one.
  // Requires: placed_power() > 0; 0 <= x, y < 1.
  LightPoint place(Vec2f pick) const;

  // Picks a ray of any light. Requires: power() > 0. Returns: nothing where the light sheds none
  // along that direction.
  std::optional<LightRay> ray(Vec2f pick, Vec2f direction) const;

 private:
  // Chances of lights, by power: all emitters together, then lights one by one, then the sky.
  struct Shares {
    std::vector<float> cumulative;  // ends at 1
    double total = 0;
  };
  struct Pick {
    std::size_t source;
    float chance;
    Vec2f rest;  // what is unused of the numbers, stretched to the square again
  };
  Shares shares(bool has_each) const;
  static Pick pick(const Shares& shares, Vec2f x);
  struct FromSky {
    Vec3f way;  // the way light travels, unit
    Vec3f irradiance;
  };
  double sky_power() const;
  FromSky from_sky(Vec2f x) const;
  Vec3f on_disk(Vec3f direction, Vec2f square) const;

  const LightSet& lights_;
  Vec3f centre_;
  float radius_ = 0;  // of a ball around the scene
  Shares placed_, all_;
  std::vector<LightPoint> each_;
};

}  // namespace tessera::core
