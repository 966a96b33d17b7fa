// SPDX-License-Identifier: Apache-2.0
#include "slave/core/primitive/patch/fat_borders_beside.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <unordered_map>
#include <vector>

#include "common/math/vec3d.h"
#include "slave/core/primitive/patch/fat_border.h"
#include "slave/core/primitive/patch/fat_border_frame.h"

namespace tessera::core {
namespace {

// How much the bounds of a border may grow for others: thicknesses to this many times theirs, and
// its ends by this share of the half of its length.
constexpr double kThicker = 1.5, kLonger = 1.0 / 16;
constexpr std::size_t kCandidatesMax = 16;  // borders that are remembered for one place
constexpr double kLinkMax = std::numeric_limits<std::int16_t>::max();

float longest_side(const Bounds3f& box) {
  const Vec3f size = box.extent();
  return std::max({size.x, size.y, size.z});
}

bool holds(const Bounds3f& box, const Vec3d& p) {
  return p.x >= double{box.lower.x} && p.x <= double{box.upper.x} && p.y >= double{box.lower.y} &&
         p.y <= double{box.upper.y} && p.z >= double{box.lower.z} && p.z <= double{box.upper.z};
}

// A cell of space with sides of 2^level.
struct Place {
  int level;
  std::array<std::int64_t, 3> cell;
  bool operator==(const Place&) const = default;
};
struct PlaceHash {
  std::size_t operator()(const Place& place) const {
    std::uint64_t hash = static_cast<std::uint64_t>(place.level) + 0x9e3779b97f4a7c15u;
    for (const std::int64_t x : place.cell)
      hash = (hash ^ static_cast<std::uint64_t>(x)) * 0xff51afd7ed558ccdu, hash ^= hash >> 32;
    return static_cast<std::size_t>(hash);
  }
};

class Joiner {
 public:
  Joiner(const Patch* patches, std::span<SubPatch> parts, std::span<Bounds3f> boxes)
      : patches_(patches), parts_(parts), boxes_(boxes) {}

  // Long borders come first, as they hold shorter ones.
  void run() {
    std::vector<std::size_t> order;
    for (std::size_t i = 0; i < parts_.size(); ++i) {
      if (is_fat_border(parts_[i]) && parts_[i].has_frame && longest_side(boxes_[i]) > 0)
        order.push_back(i);
    }
    std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
      return longest_side(boxes_[a]) > longest_side(boxes_[b]);
    });
    for (const std::size_t number : order) {
      const SubPatch& border = parts_[number];
      const RunPlaces run(patches_[border.patch], run_of(border));
      if (!join(number, run)) remember(number);
    }
  }

 private:
  // One that stands in the hierarchy.
  struct Leader {
    std::size_t number, last;  // of itself, and of the last that it stands for
    // As they were when it stood for itself alone.
    float reach[3], from_parabola;
    Bounds3f box;
  };

  bool join(std::size_t number, const RunPlaces& run) {
    const Vec3d middle = run.places()[run.places().size() / 2];
    const double radius = run.radius(growth_of(parts_[number]));
    for (const int level : levels_) {
      const auto found = known_.find(place_of(level, middle));
      if (found == known_.end()) continue;
      for (const std::size_t candidate : found->second) {
        Leader& leader = leaders_[candidate];
        if (holds(leader.box, middle) && take(leader, number, run, radius)) return true;
      }
    }
    return false;
  }

  bool take(Leader& leader, std::size_t number, const RunPlaces& run, double radius) {
    const double steps = static_cast<double>(number) - static_cast<double>(leader.last);
    if (std::fabs(steps) > kLinkMax) return false;
    const FatReach reach = reach_in(parts_[leader.number], run, radius);
    if (!(reach.of_row[0] <= double{leader.reach[0]} + kLonger &&
          reach.of_row[1] <= double{leader.reach[1]} + (kThicker - 1) &&
          reach.of_row[2] <= kThicker * double{leader.reach[2]} &&
          reach.from_parabola <= kThicker * double{leader.from_parabola}))
      return false;
    widen(reach, parts_[leader.number]);
    boxes_[leader.number].grow(boxes_[number]);
    boxes_[number] = Bounds3f{};
    parts_[leader.last].row = static_cast<std::uint16_t>(static_cast<std::int16_t>(steps));
    leader.last = number;
    return true;
  }

  // In all cells that its box meets, of which there are two along an axis at most.
  void remember(std::size_t number) {
    const Bounds3f& box = boxes_[number];
    const int level = std::ilogb(longest_side(box)) + 1;
    const SubPatch& border = parts_[number];
    leaders_.push_back({number,
                        number,
                        {border.reach[0], border.reach[1], border.reach[2]},
                        border.second[2][2],
                        box});
    if (std::find(levels_.begin(), levels_.end(), level) == levels_.end()) levels_.push_back(level);
    const auto corner = [](Vec3f p) { return Vec3d{p.x, p.y, p.z}; };
    const Place low = place_of(level, corner(box.lower)), high = place_of(level, corner(box.upper));
    for (std::int64_t x = low.cell[0]; x <= high.cell[0]; ++x)
      for (std::int64_t y = low.cell[1]; y <= high.cell[1]; ++y)
        for (std::int64_t z = low.cell[2]; z <= high.cell[2]; ++z) {
          std::vector<std::size_t>& of = known_[{level, {x, y, z}}];
          if (of.size() < kCandidatesMax) of.push_back(leaders_.size() - 1);
        }
  }

  // Coordinates of cells beyond 2^52 are cut off there: borders are then remembered for less.
  static Place place_of(int level, const Vec3d& p) {
    Place place{level, {}};
    for (int a = 0; a < 3; ++a)
      place.cell[static_cast<std::size_t>(a)] = static_cast<std::int64_t>(
          std::clamp(std::floor(std::ldexp(p[a], -level)), -0x1p52, 0x1p52));
    return place;
  }

  const Patch* patches_;
  std::span<SubPatch> parts_;
  std::span<Bounds3f> boxes_;
  std::vector<Leader> leaders_;
  std::vector<int> levels_;
  std::unordered_map<Place, std::vector<std::size_t>, PlaceHash> known_;
};

}  // namespace

void join_borders_beside(const Patch* patches, std::span<SubPatch> parts,
                         std::span<Bounds3f> boxes) {
  Joiner(patches, parts, boxes).run();
}

}  // namespace tessera::core
