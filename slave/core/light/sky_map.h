// SPDX-License-Identifier: Apache-2.0
// Light from an environment map: radiance by direction, and directions sampled by how much light
// they bring.
//
// Directions are drawn by texel, and uniformly within it (Pharr, Jakob and Humphreys, "Physically
// Based Rendering", 2016, section 14.2.4): nine of ten in proportion to the mean of the bilinear
// picture over the texel times the sine of its row's polar angle, one of ten by that sine alone.
// So no direction has a chance of zero, and where a sun does not shine the rest of the sky, however
// dim beside it, still gets its samples.
//
// Samples have the same bits on every processor and C library: arithmetic and square roots only.
//
// Threads. Constant after construction.
#pragma once

#include <memory>
#include <vector>

#include "common/scene/scene.h"
#include "slave/core/light/sky_layout.h"

namespace tessera::core {

class SkyMap {
 public:
  // Requires: validate_scene() has passed the map.
  explicit SkyMap(std::shared_ptr<const EnvironmentMap> map);

  const std::shared_ptr<const EnvironmentMap>& map() const { return map_; }

  // Radiance at a place of the picture, in texels from the upper left corner.
  Vec3f at(Vec2f place) const;
  // Light of all directions together, radiance times solid angle; luminance.
  double power() const { return power_; }

  struct Sample {
    Vec3f direction;  // unit
    Vec3f radiance;
    float angle;  // 1 over the pdf by solid angle; 0: take nothing
  };
  // Requires: power() > 0; 0 <= x, y < 1.
  Sample sample(Vec2f square) const;
  std::uint64_t memory_bytes() const;
  // View for packets (slave/core/light/sky-inl.h), whose samples are those of sample(), to the bit,
  // and which also find radiance and pdf of directions. Requires: this outlives the view.
  SkyView view() const;

 private:
  Vec3f texel(int x, int y) const;
  double weight_of(int x, int y) const;

  std::shared_ptr<const EnvironmentMap> map_;
  double power_ = 0;
  std::vector<double> rows_;     // [height + 1], cumulative from 0 to 1
  std::vector<double> columns_;  // [height][width + 1], likewise
  // Where the search for a part of the sums begins, so that they need not be searched as a whole.
  std::vector<std::uint16_t> row_guide_;     // [height]
  std::vector<std::uint16_t> column_guide_;  // [height][width]
};

}  // namespace tessera::core
