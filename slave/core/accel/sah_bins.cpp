// SPDX-License-Identifier: Apache-2.0
#include "slave/core/accel/sah_bins.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace tessera::core {
namespace {

// Maps doubled centroids to bins, on all axes at once. cut() and split() decide by the same
// numbers.
struct BinMap {
  Float4 origin, scale;
  int count;

  explicit BinMap(const RefRange& range) : origin(range.centroids.lower) {
    const auto wanted = 4 + 0.05f * static_cast<float>(range.size());
    count = static_cast<int>(std::min(static_cast<float>(SahBins::kBinsMax), wanted));
    alignas(16) float lanes[4] = {};
    for (int a = 0; a < 3; ++a) {
      const float extent = range.centroids.upper[a] - range.centroids.lower[a];
      // The scale is just below `count`, so that the last centroid falls into the last bin.
      const float per_unit = static_cast<float>(count) * 0.9999f / extent;
      lanes[a] = extent > 0 && std::isfinite(per_unit) ? per_unit : 0;
    }
    scale = load4(lanes);
  }

  __m128i bins_of(Float4 centroid) const {
    return _mm_cvttps_epi32(((centroid - origin) * scale).v);
  }
  bool splits(int axis) const { return scale[axis] > 0; }
};

// From this many references on they go into two sets of bins in turns. Neighbours mostly share a
// bin, and would wait for each other's stores.
constexpr std::uint32_t kTwoSetsMin = 256;

// The side of a cut that a reference is on, and the boxes of the doubled centroids on each side.
// There is no branch, for sides are as good as random: a box takes what is on its side, and NaN for
// what is not, which min and max drop where it is their first operand.
class Sides {
 public:
  Sides(const RefRange& range, const SahCut& cut) : map_(range) {
    alignas(16) int last[4];
    std::fill_n(last, 4, std::numeric_limits<int>::max());
    last[cut.axis] = cut.bin;
    last_left_ = _mm_load_si128(reinterpret_cast<const __m128i*>(last));
  }

  // Returns: 1 for the right side, 0 for the left.
  std::uint32_t side_of(const PrimitiveRef& ref) {
    const Float4 centroid = load4(ref.lower) + load4(ref.upper);
    const __m128i lanes = _mm_cmpgt_epi32(map_.bins_of(centroid), last_left_);
    const __m128i is_right = _mm_set1_epi32(_mm_movemask_epi8(lanes) == 0 ? 0 : -1);
    const __m128i is_left = _mm_xor_si128(is_right, _mm_set1_epi32(-1));
    const Float4 at_left{_mm_or_ps(centroid.v, _mm_castsi128_ps(is_right))};
    const Float4 at_right{_mm_or_ps(centroid.v, _mm_castsi128_ps(is_left))};
    left.grow(at_left, at_left);
    right.grow(at_right, at_right);
    return static_cast<std::uint32_t>(_mm_cvtsi128_si32(is_right)) & 1u;
  }

  Box4 left, right;

 private:
  BinMap map_;
  __m128i last_left_;  // of each axis: no bin is past the last one on the two that are not cut
};

}  // namespace

void SahBins::fill(std::span<const PrimitiveRef> refs, const RefRange& range) {
  const BinMap map(range);
  const bool has_two = refs.size() >= kTwoSetsMin;
  const int sets = has_two ? 2 : 1;
  for (int set = 0; set < sets; ++set) {
    for (auto& axis : bins_[set]) std::fill_n(axis, map.count, Bin{});
  }
  const auto put = [&map](const PrimitiveRef& ref, Bin(&bins)[3][kBinsMax]) {
    const Float4 lower = load4(ref.lower), upper = load4(ref.upper);
    const __m128i lanes = map.bins_of(lower + upper);
    const auto xy = static_cast<std::uint64_t>(_mm_cvtsi128_si64(lanes));
    const int z = _mm_cvtsi128_si32(_mm_unpackhi_epi32(lanes, lanes));
    bins[0][static_cast<std::uint32_t>(xy)].add(lower, upper);
    bins[1][xy >> 32].add(lower, upper);
    bins[2][z].add(lower, upper);
  };
  std::size_t i = 0;
  for (; has_two && i + 1 < refs.size(); i += 2) {
    put(refs[i], bins_[0]);
    put(refs[i + 1], bins_[1]);
  }
  for (; i < refs.size(); ++i) put(refs[i], bins_[0]);
  if (!has_two) return;
  for (int a = 0; a < 3; ++a) {
    for (int b = 0; b < map.count; ++b) bins_[0][a][b].add(bins_[1][a][b]);
  }
}

SahCut SahBins::cut(std::span<const PrimitiveRef> refs, const RefRange& range,
                    std::uint32_t block_size) {
  fill(refs.subspan(range.begin, range.size()), range);
  return best_cut(range, block_size);
}

void SahBins::add(const SahBins& part, const RefRange& range) {
  const BinMap map(range);
  for (int a = 0; a < 3; ++a) {
    for (int b = 0; b < map.count; ++b) bins_[0][a][b].add(part.bins_[0][a][b]);
  }
}

SahCut SahBins::best_cut(const RefRange& range, std::uint32_t block_size) const {
  const BinMap map(range);
  SahCut best;
  best.cost = std::numeric_limits<float>::infinity();
  for (int a = 0; a < 3; ++a) {
    if (map.splits(a)) weigh(a, map.count, block_size, best);
  }
  set_boxes(map.count, best);
  return best;
}

SahCut SahBins::cut_longest(std::span<const PrimitiveRef> refs, const RefRange& range,
                            std::uint32_t block_size) {
  const BinMap map(range);
  int axis = 0;
  for (int a = 1; a < 3; ++a) {
    if (range.centroids.upper[a] - range.centroids.lower[a] >
        range.centroids.upper[axis] - range.centroids.lower[axis])
      axis = a;
  }
  SahCut best;
  best.cost = std::numeric_limits<float>::infinity();
  if (!map.splits(axis)) return best;
  Bin* const bins = bins_[0][axis];
  std::fill_n(bins, map.count, Bin{});
  for (const PrimitiveRef& ref : refs.subspan(range.begin, range.size())) {
    const Float4 lower = load4(ref.lower), upper = load4(ref.upper);
    alignas(16) int lanes[4];
    _mm_store_si128(reinterpret_cast<__m128i*>(lanes), map.bins_of(lower + upper));
    bins[lanes[axis]].add(lower, upper);
  }
  weigh(axis, map.count, block_size, best);
  set_boxes(map.count, best);
  return best;
}

void SahBins::weigh(int axis, int bin_count, std::uint32_t block_size, SahCut& best) const {
  const Bin* const bins = bins_[0][axis];
  float right_cost[kBinsMax];
  Box4 box;
  std::uint32_t count = 0;
  for (int b = bin_count - 1; b > 0; --b) {
    box.grow(bins[b].bounds);
    count += bins[b].count;
    right_cost[b] = count == 0 ? std::numeric_limits<float>::infinity()
                               : box.half_area() * blocks_of(count, block_size);
  }
  box = {};
  count = 0;
  for (int b = 0; b + 1 < bin_count; ++b) {
    box.grow(bins[b].bounds);
    count += bins[b].count;
    if (count == 0) continue;
    const float cost = box.half_area() * blocks_of(count, block_size) + right_cost[b + 1];
    if (cost < best.cost) best = {axis, b, cost, {}, {}};
  }
}

void SahBins::set_boxes(int bin_count, SahCut& cut) const {
  if (cut.axis < 0) return;
  const Bin* const bins = bins_[0][cut.axis];
  for (int b = 0; b < bin_count; ++b) (b <= cut.bin ? cut.left : cut.right).grow(bins[b].bounds);
}

SahSides SahBins::order(std::span<PrimitiveRef> refs, const RefRange& range, const SahCut& cut,
                        std::uint32_t begin, std::uint32_t end) {
  Sides sides(range, cut);
  std::uint32_t next = begin;
  // Every reference changes places with the first one on the right; one on the left stays there.
  for (std::uint32_t i = begin; i < end; ++i) {
    const PrimitiveRef ref = refs[i];
    refs[i] = refs[next];
    refs[next] = ref;
    next += 1 - sides.side_of(ref);
  }
  return {begin, next, end, sides.left, sides.right};
}

std::pair<RefRange, RefRange> SahBins::join(std::span<PrimitiveRef> refs, const RefRange& range,
                                            const SahCut& cut, std::span<const SahSides> parts) {
  RefRange left, right;
  std::uint32_t border = range.begin;
  for (const SahSides& part : parts) {
    border += part.middle - part.begin;
    left.centroids.grow(part.left);
    right.centroids.grow(part.right);
  }
  // As many as stand on the right in front of the border stand on the left behind it.
  std::size_t last = parts.size();
  std::uint32_t from = 0;  // behind the last one on the left that has not moved
  for (const SahSides& part : parts) {
    for (std::uint32_t to = part.middle; to < std::min(part.end, border); ++to) {
      while (last == parts.size() || from == std::max(parts[last].begin, border))
        from = std::max(parts[--last].middle, border);
      std::swap(refs[to], refs[--from]);
    }
  }
  left.begin = range.begin;
  left.end = right.begin = border;
  right.end = range.end;
  left.bounds = cut.left;
  right.bounds = cut.right;
  share_room(refs, left, right, range.limit);
  return {left, right};
}

std::pair<RefRange, RefRange> SahBins::split(std::span<PrimitiveRef> refs, const RefRange& range,
                                             const SahCut& cut) {
  if (cut.axis >= 0) {
    const SahSides whole = order(refs, range, cut, range.begin, range.end);
    return join(refs, range, cut, {&whole, 1});
  }
  RefRange left, right;
  left.begin = range.begin;
  right.end = range.end;
  const std::uint32_t middle = range.begin + range.size() / 2;
  for (std::uint32_t i = range.begin; i < middle; ++i) left.grow(refs[i]);
  for (std::uint32_t i = middle; i < range.end; ++i) right.grow(refs[i]);
  left.end = right.begin = middle;
  share_room(refs, left, right, range.limit);
  return {left, right};
}

}  // namespace tessera::core
