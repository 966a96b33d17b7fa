// SPDX-License-Identifier: Apache-2.0
#include "slave/core/primitive/placed/exact_place_bounds.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <set>
#include <tuple>
#include <vector>

#include "slave/core/accel/bvh_farthest.h"
#include "slave/core/primitive/freeform/patch_store.h"
#include "slave/core/primitive/instance/instance_placement.h"
#include "slave/core/primitive/placed/surface_index.h"

namespace tessera::core {
namespace {

// Finds the part of a place that reaches farthest along a direction. The search goes down the
// surface's hierarchy only where something may reach farther than the best so far.
template <int W>
class FarthestPart {
 public:
  FarthestPart(const SurfaceIndex<W>& index, const InstanceBlock& place)
      : index_(index),
        place_(place),
        to_world_(to_world_of(place)),
        off_(place, index.surface->points) {}

  float find(const AxisDirection& along, float best) const {
    const auto reach_of = [&](const Bounds3f& box) {
      return along.of(off_.grown(placed_bounds(to_world_, {&box, 1})));
    };
    const auto best_in_leaf = [&](std::uint32_t leaf, float far) {
      const std::uint32_t first = first_block_of(leaf);
      for (std::uint32_t b = first; b < first + block_count_of(leaf); ++b)
        far = std::max(far, along.of(box_of(index_.blocks[b] ^ kIsItem)));
      return far;
    };
    return farthest_in_bvh(index_.structure.nodes.data(), best, reach_of, best_in_leaf);
  }

 private:
  // As a flattened scene has it.
  Bounds3f box_of(std::uint32_t number) const {
    const SubPatch& part = index_.surface->parts[number];
    Bounds3f box = index_.surface->boxes[number];
    if (place_.is_identity != 0) return box;
    Patch patch = index_.surface->patches[part.patch];
    float numbers[4 * kPatchPointsMax];
    static_cast<void>(place_part(to_world_, part, patch, numbers, box));
    return box;
  }

  const SurfaceIndex<W>& index_;
  const InstanceBlock& place_;
  const Transform to_world_;
  const PlaceRoundings off_;
};

// What the coordinate of a place's parts along an axis depends on: the surface, the map but for how
// far it moves them along other axes, and whether it is the identity.
using PlaceKey = std::tuple<std::uint32_t, std::uint32_t, std::array<float, 10>>;
PlaceKey key_of(const InstanceBlock& place, int axis) {
  std::array<float, 10> map{};
  for (std::size_t i = 0; i < 9; ++i) map[i] = place.to_world[i / 3][i % 3];
  map[9] = place.to_world[axis][3];
  return {place.mesh, place.is_identity, map};
}

}  // namespace

PlaceRoundings::PlaceRoundings(const InstanceBlock& place, const Bounds3f& points) {
  if (place.is_identity == 0) off_ = corner_roundings(to_world_of(place), points);
}

Bounds3f PlaceRoundings::grown(Bounds3f box) const {
  constexpr float kInf = std::numeric_limits<float>::infinity();
  float lower[3], upper[3];
  for (int a = 0; a < 3; ++a) {
    const double off = off_[static_cast<std::size_t>(a)];
    const double low = double{box.lower[a]} - off, high = double{box.upper[a]} + off;
    lower[a] = off > 0 ? std::nextafter(static_cast<float>(low), -kInf) : box.lower[a];
    upper[a] = off > 0 ? std::nextafter(static_cast<float>(high), kInf) : box.upper[a];
  }
  return {{lower[0], lower[1], lower[2]}, {upper[0], upper[1], upper[2]}};
}

// The place whose box reaches farthest comes first, so that few others have to be looked at; of
// places in a row, one.
template <int W>
Bounds3f exact_place_bounds(const PlacedBvh<W>& index, std::span<const Bounds3f> of_places,
                            const Bounds3f& flattened) {
  const std::vector<InstanceBlock>& places = index.patches->shared.places;
  float limit[2][3];
  for (int d = 0; d < 6; ++d) {
    const AxisDirection along{d / 2, d % 2 == 0 ? -1.0f : 1.0f};
    float best = along.of(flattened);
    std::set<PlaceKey> seen;
    const auto look_at = [&](std::size_t i) {
      if (!(along.of(of_places[i]) > best)) return;
      if (!seen.insert(key_of(places[i], along.axis)).second) return;
      best = FarthestPart<W>(*index.surfaces[places[i].mesh], places[i]).find(along, best);
    };
    std::size_t first = 0;
    for (std::size_t i = 1; i < of_places.size(); ++i) {
      if (along.of(of_places[i]) > along.of(of_places[first])) first = i;
    }
    if (!of_places.empty()) look_at(first);
    for (std::size_t i = 0; i < of_places.size(); ++i) look_at(i);
    limit[d % 2][d / 2] = along.sign * best;
  }
  const auto &low = limit[0], &high = limit[1];
  return {{low[0], low[1], low[2]}, {high[0], high[1], high[2]}};
}

template Bounds3f exact_place_bounds<8>(const PlacedBvh<8>&, std::span<const Bounds3f>,
                                        const Bounds3f&);
template Bounds3f exact_place_bounds<16>(const PlacedBvh<16>&, std::span<const Bounds3f>,
                                         const Bounds3f&);

}  // namespace tessera::core
