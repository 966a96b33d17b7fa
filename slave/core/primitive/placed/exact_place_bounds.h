// SPDX-License-Identifier: Apache-2.0
// The box of a scene whose places share surfaces, equal to that of the same scene flattened. Boxes
// of places are wider than what is in them, and what is chosen by the size of a scene must not
// depend on how it is stored.
//
// Threads. Pure functions.
#pragma once

#include <array>
#include <span>

#include "common/math/bounds3.h"
#include "slave/core/primitive/instance_layout.h"
#include "slave/core/primitive/primitive_index.h"

namespace tessera::core {

// By axis of the world, how far control points may be rounded away from where a place brings them.
class PlaceRoundings {
 public:
  // points: the box of the surface's control points.
  PlaceRoundings(const InstanceBlock& place, const Bounds3f& points);

  // The box with room for that on all sides.
  Bounds3f grown(Bounds3f box) const;

 private:
  std::array<double, 3> off_{};  // 0 where the map is the identity
};

// The least box that holds `flattened`, which may be empty, and the boxes that sub-patches of the
// places would have if they were flattened. of_places: boxes that hold the places.
template <int W>
Bounds3f exact_place_bounds(const PlacedBvh<W>& index, std::span<const Bounds3f> of_places,
                            const Bounds3f& flattened);

}  // namespace tessera::core
