// SPDX-License-Identifier: Apache-2.0
// A freeform surface as files have it: rational Bezier patches, trimmed by loops of rational
// segments. Nothing is raised, reduced, split or tessellated before it travels.
//
// A patch is S(u, v) = sum B_i(u) B_j(v) w_ij P_ij / sum B_i(u) B_j(v) w_ij on [0, 1]^2, of degrees
// 1 to 15. Point (i, j) is number (degree_v + 1) i + j of its patch. Its geometric normal is along
// dS/du x dS/dv, its texture coordinates are u and v.
//
// A loop is closed: each segment is a rational Bezier curve in (u, v) to where the next one begins,
// the last one to the first. What an odd number of a patch's loops enclose is kept, or left out
// where keeps_outside says so. A patch without loops is whole; a loop there and back trims nothing.
//
// Units. Lengths in scene units. Threads. Plain values.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "common/base/api.h"
#include "common/math/vec3.h"

namespace tessera {

inline constexpr int kPatchDegreesMax = 15;

struct PatchForm {
  std::uint8_t degree_u = 3, degree_v = 3;  // 1 to kPatchDegreesMax
  std::uint8_t is_rational = 0;             // 1: each point is followed by its weight, > 0
  std::uint8_t keeps_outside = 0;           // 1: what the loops enclose is left out
  bool operator==(const PatchForm&) const = default;

  std::size_t point_count() const {
    return (std::size_t{degree_u} + 1) * (std::size_t{degree_v} + 1);
  }
  std::size_t number_count() const { return point_count() * (is_rational != 0 ? 4 : 3); }
};

// A point of a segment of a loop: coordinates in the patch's square, and weight, > 0.
struct TrimPoint {
  float u = 0, v = 0, weight = 1;
  bool operator==(const TrimPoint&) const = default;
};

struct PatchSurface {
  std::vector<PatchForm> patches;        // [patch_count]
  std::vector<float> numbers;            // the patches' points, one patch after the other
  std::vector<std::uint32_t> materials;  // [patch_count], or 1 for all; never empty
  // Of patches, loops and segments in their order. All are empty where nothing is trimmed.
  std::vector<std::uint32_t> loop_counts;     // [patch_count] loops of each patch
  std::vector<std::uint32_t> segment_counts;  // [loop_count] segments of each loop, at least 1
  std::vector<std::uint8_t> degrees;          // [segment_count] 1 to kPatchDegreesMax
  // Of each segment all points but the last, which is the first one of the segment that follows.
  std::vector<TrimPoint> trim_points;
  // [segment_count] or empty: how far from a segment rays still meet the surface, so that solids
  // whose faces do not quite meet stay closed; 0: not at all, as at open edges. In scene units.
  std::vector<float> trim_widths;

  bool operator==(const PatchSurface&) const = default;
};

// One patch of a surface after the other, with its places in the surface's arrays:
//   for (PatchCursor at(surface); at.is_any(); at.advance()) ...
// Requires: arrays that fit each other, as validate_scene() checks; the surface outlives it.
class TESSERA_API PatchCursor {
 public:
  explicit PatchCursor(const PatchSurface& surface) : surface_(&surface) {}
  bool is_any() const { return patch_ < surface_->patches.size(); }
  void advance();

  std::size_t patch() const { return patch_; }
  const PatchForm& form() const { return surface_->patches[patch_]; }
  std::uint32_t material() const {
    return surface_->materials[surface_->materials.size() == 1 ? 0 : patch_];
  }
  // Point (i, j) is number (degree_v + 1) i + j. Requires: point < form().point_count().
  Vec3f point(std::size_t point) const {
    const float* p = numbers(point);
    return {p[0], p[1], p[2]};
  }
  float weight(std::size_t point) const { return form().is_rational != 0 ? numbers(point)[3] : 1; }

  std::size_t first_number() const { return first_number_; }          // in numbers
  std::size_t first_loop() const { return first_loop_; }              // in segment_counts
  std::size_t first_segment() const { return first_segment_; }        // in degrees, trim_widths
  std::size_t first_trim_point() const { return first_trim_point_; }  // in trim_points
  std::size_t loop_count() const {
    return surface_->loop_counts.empty() ? 0 : surface_->loop_counts[patch_];
  }

 private:
  const float* numbers(std::size_t point) const {
    return surface_->numbers.data() + first_number_ + point * (form().is_rational != 0 ? 4 : 3);
  }

  const PatchSurface* surface_;
  std::size_t patch_ = 0, first_number_ = 0;
  std::size_t first_loop_ = 0, first_segment_ = 0, first_trim_point_ = 0;
};

}  // namespace tessera
