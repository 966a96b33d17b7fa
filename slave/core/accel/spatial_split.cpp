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
  // The plane in front of a slab.
  float plane(int slab) const {
    return lower + width * (static_cast<float>(slab) / SpatialSplitter::kBins);
  }
};

// The slabs of all axes. One that is not thick has a single slab.
class SlabMap {
 public:
  explicit SlabMap(const RefRange& range) : origin_(range.bounds.lower) {
    alignas(16) float scale[4] = {};
    for (int a = 0; a < 3; ++a) {
      const Slabs slabs(range, a);
      scale[a] = slabs.are_thick() ? slabs.scale : 0;
    }
    scale_ = load4(scale);
  }

  // Writes the number of the slab on each axis.
  void find(Float4 point, int (&slab)[4]) const {
    constexpr auto kLast = static_cast<float>(SpatialSplitter::kBins - 1);
    // The fourth lane, a number or its like, may be denormal, and products of denormals are slow.
    const __m128 axes = _mm_and_ps(point.v, _mm_castsi128_ps(_mm_setr_epi32(-1, -1, -1, 0)));
    const __m128 at = _mm_mul_ps(_mm_sub_ps(axes, origin_.v), scale_.v);
    const __m128 clamped = _mm_min_ps(_mm_max_ps(at, _mm_setzero_ps()), _mm_set1_ps(kLast));
    _mm_store_si128(reinterpret_cast<__m128i*>(slab), _mm_cvttps_epi32(clamped));
  }

 private:
  Float4 origin_, scale_;
};

bool is_right_of(const PrimitiveRef& ref, const SpatialCut& cut) {
  return ref.lower[cut.axis] >= cut.plane && ref.upper[cut.axis] > cut.plane;
}

}  // namespace

// Bins hold parts of boxes. Parts of primitives are found for the cut that is made, not for all
// that are weighed: that takes seven times as long.
void SpatialSplitter::fill(std::span<const PrimitiveRef> refs, const RefRange& range) {
  const SlabMap map(range);
  for (auto& axis : bins_) std::fill_n(axis, kBins, Bin{});
  for (const PrimitiveRef& ref : refs) {
    const Float4 lower = load4(ref.lower), upper = load4(ref.upper);
    alignas(16) int first[4], last[4];
    map.find(lower, first);
    map.find(upper, last);
    for (int a = 0; a < 3; ++a) {
      Bin* const bins = bins_[a];
      ++bins[first[a]].begins;
      ++bins[last[a]].ends;
      if (first[a] == last[a]) {
        bins[first[a]].bounds.grow(lower, upper);
      } else {
        fill_slabs(ref, range, a, first[a], last[a]);
      }
    }
  }
}

void SpatialSplitter::fill_slabs(const PrimitiveRef& ref, const RefRange& range, int axis,
                                 int first, int last) {
  const Slabs slabs(range, axis);
  PrimitiveRef part = ref;
  for (int b = first; b <= last; ++b) {
    part.lower[axis] = b > first ? std::max(slabs.plane(b), ref.lower[axis]) : ref.lower[axis];
    part.upper[axis] = b < last ? std::min(slabs.plane(b + 1), ref.upper[axis]) : ref.upper[axis];
    bins_[axis][b].bounds.grow(load4(part.lower), load4(part.upper));
  }
}

SpatialCut SpatialSplitter::cut(std::span<const PrimitiveRef> refs, const RefRange& range,
                                std::uint32_t block_size) {
  SpatialCut best{-1, 0, kInfinity};
  const std::uint32_t count = range.size();
  fill(refs.subspan(range.begin, count), range);
  for (int axis = 0; axis < 3; ++axis) {
    const Slabs slabs(range, axis);
    if (!slabs.are_thick()) continue;
    const Bin* const bins = bins_[axis];
    float area_right[kBins];
    std::uint32_t count_right[kBins];
    Box4 box;
    std::uint32_t in_box = 0;
    for (int b = kBins - 1; b > 0; --b) {
      box.grow(bins[b].bounds);
      count_right[b] = in_box += bins[b].ends;
      area_right[b] = box.half_area();
    }
    box = {};
    in_box = 0;
    for (int b = 1; b < kBins; ++b) {
      box.grow(bins[b - 1].bounds);
      in_box += bins[b - 1].begins;
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
