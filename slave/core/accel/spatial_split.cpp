// SPDX-License-Identifier: Apache-2.0
#include "slave/core/accel/spatial_split.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace tessera::core {
namespace {

constexpr float kInfinity = std::numeric_limits<float>::infinity();

void set_axis(Vec3f& v, int axis, float value) {
  (axis == 0 ? v.x : axis == 1 ? v.y : v.z) = value;
}

Bounds3f box_of(const PrimitiveRef& ref) {
  return {{ref.lower[0], ref.lower[1], ref.lower[2]}, {ref.upper[0], ref.upper[1], ref.upper[2]}};
}

// Slabs of equal width across a range.
struct Slabs {
  float lower, width, scale;

  Slabs(const RefRange& range, int axis)
      : lower(range.bounds.lower[axis]),
        width(range.bounds.upper[axis] - lower),
        scale(static_cast<float>(SpatialSplitter::kBins) / width) {}

  bool are_thick() const { return width > 0 && std::isfinite(width) && std::isfinite(scale); }
  int of(float x) const {
    constexpr auto kLast = static_cast<float>(SpatialSplitter::kBins - 1);
    return static_cast<int>(std::clamp((x - lower) * scale, 0.0f, kLast));
  }
  // The plane in front of a slab.
  float plane(int slab) const {
    return lower + width * (static_cast<float>(slab) / SpatialSplitter::kBins);
  }
};

bool is_right_of(const PrimitiveRef& ref, const SpatialCut& cut) {
  return ref.lower[cut.axis] >= cut.plane && ref.upper[cut.axis] > cut.plane;
}

}  // namespace

// Bins hold parts of boxes. Parts of primitives are found for the cut that is made, not for all
// that are weighed: that takes seven times as long.
void SpatialSplitter::fill(std::span<const PrimitiveRef> refs, const RefRange& range, int axis) {
  const Slabs slabs(range, axis);
  std::fill_n(bins_, kBins, Bin{});
  for (const PrimitiveRef& ref : refs) {
    const int first = slabs.of(ref.lower[axis]), last = slabs.of(ref.upper[axis]);
    ++bins_[first].begins;
    ++bins_[last].ends;
    if (first == last) {
      bins_[first].bounds.grow(load4(ref.lower), load4(ref.upper));
      continue;
    }
    for (int b = first; b <= last; ++b) {
      Bounds3f slab = box_of(ref);
      if (b > first) set_axis(slab.lower, axis, std::max(slabs.plane(b), slab.lower[axis]));
      if (b < last) set_axis(slab.upper, axis, std::min(slabs.plane(b + 1), slab.upper[axis]));
      const PrimitiveRef of_part = ref_of(slab, ref.primitive);
      bins_[b].bounds.grow(load4(of_part.lower), load4(of_part.upper));
    }
  }
}

SpatialCut SpatialSplitter::cut(std::span<const PrimitiveRef> refs, const RefRange& range,
                                std::uint32_t block_size) {
  SpatialCut best{-1, 0, kInfinity};
  const std::uint32_t count = range.size();
  for (int axis = 0; axis < 3; ++axis) {
    const Slabs slabs(range, axis);
    if (!slabs.are_thick()) continue;
    fill(refs.subspan(range.begin, count), range, axis);
    float area_right[kBins];
    std::uint32_t count_right[kBins];
    Box4 box;
    std::uint32_t in_box = 0;
    for (int b = kBins - 1; b > 0; --b) {
      box.grow(bins_[b].bounds);
      count_right[b] = in_box += bins_[b].ends;
      area_right[b] = box.half_area();
    }
    box = {};
    in_box = 0;
    for (int b = 1; b < kBins; ++b) {
      box.grow(bins_[b - 1].bounds);
      in_box += bins_[b - 1].begins;
      const bool is_cut = in_box > 0 && in_box < count && count_right[b] > 0 &&
                          count_right[b] < count && in_box + count_right[b] <= count + range.room();
      const float cost = box.half_area() * blocks_of(in_box, block_size) +
                         area_right[b] * blocks_of(count_right[b], block_size);
      if (is_cut && cost < best.cost) best = {axis, slabs.plane(b), cost};
    }
  }
  return best;
}

// A part on the right that lies in the plane is left out: the part on the left has it.
void SpatialSplitter::cut_in_two(PrimitiveRef& ref, const SpatialCut& cut,
                                 std::span<PrimitiveRef> refs, std::uint32_t& end,
                                 std::uint32_t limit) const {
  Bounds3f below = box_of(ref), above = below;
  set_axis(below.upper, cut.axis, cut.plane);
  set_axis(above.lower, cut.axis, cut.plane);
  const Bounds3f left = clipper_.clip(ref.primitive, below);
  const Bounds3f right = clipper_.clip(ref.primitive, above);
  const bool is_right = !right.is_empty() && right.upper[cut.axis] > cut.plane;
  if (left.is_empty()) {
    if (is_right) ref = ref_of(right, ref.primitive);
    return;
  }
  if (is_right && end == limit) return;
  if (is_right) refs[end++] = ref_of(right, ref.primitive);
  ref = ref_of(left, ref.primitive);
}

std::pair<RefRange, RefRange> SpatialSplitter::split(std::span<PrimitiveRef> refs,
                                                     const RefRange& range,
                                                     const SpatialCut& cut) const {
  std::uint32_t end = range.end;
  for (std::uint32_t i = range.begin; i < range.end; ++i) {
    PrimitiveRef& ref = refs[i];
    if (ref.lower[cut.axis] < cut.plane && ref.upper[cut.axis] > cut.plane)
      cut_in_two(ref, cut, refs, end, range.limit);
  }
  RefRange left, right;
  std::uint32_t next = range.begin;
  for (std::uint32_t i = range.begin; i < end; ++i) {
    if (is_right_of(refs[i], cut)) {
      right.grow(refs[i]);
    } else {
      left.grow(refs[i]);
      std::swap(refs[i], refs[next++]);
    }
  }
  // Roundings may have put all on one side; none has been cut then.
  if (next == range.begin || next == end) return SahBins::split(refs, range, SahCut{});
  left.begin = range.begin;
  left.end = right.begin = next;
  right.end = end;
  share_room(refs, left, right, range.limit);
  return {left, right};
}

}  // namespace tessera::core
