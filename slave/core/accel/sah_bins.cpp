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

  __m128i bins_of(const PrimitiveRef& ref) const {
    const Float4 centroid = load4(ref.lower) + load4(ref.upper);
    return _mm_cvttps_epi32(((centroid - origin) * scale).v);
  }
  bool splits(int axis) const { return scale[axis] > 0; }
};

float blocks_of(std::uint32_t count, std::uint32_t block_size) {
  const std::uint32_t whole = (count + block_size - 1) / block_size;
  return static_cast<float>(whole);
}

}  // namespace

SahCut SahBins::cut(std::span<const PrimitiveRef> refs, const RefRange& range,
                    std::uint32_t block_size) {
  const BinMap map(range);
  for (auto& axis : bins_) std::fill_n(axis, map.count, Bin{});
  for (const PrimitiveRef& ref : refs.subspan(range.begin, range.size())) {
    alignas(16) int bin[4];
    _mm_store_si128(reinterpret_cast<__m128i*>(bin), map.bins_of(ref));
    const Float4 lower = load4(ref.lower), upper = load4(ref.upper);
    for (int a = 0; a < 3; ++a) {
      Bin& b = bins_[a][bin[a]];
      b.bounds.grow(lower, upper);
      ++b.count;
    }
  }
  SahCut best;
  best.cost = std::numeric_limits<float>::infinity();
  for (int a = 0; a < 3; ++a) {
    if (!map.splits(a)) continue;
    float right_cost[kBinsMax];
    Box4 box;
    std::uint32_t count = 0;
    for (int b = map.count - 1; b > 0; --b) {
      box.grow(bins_[a][b].bounds);
      count += bins_[a][b].count;
      right_cost[b] = count == 0 ? std::numeric_limits<float>::infinity()
                                 : box.half_area() * blocks_of(count, block_size);
    }
    box = {};
    count = 0;
    for (int b = 0; b + 1 < map.count; ++b) {
      box.grow(bins_[a][b].bounds);
      count += bins_[a][b].count;
      if (count == 0) continue;
      const float cost = box.half_area() * blocks_of(count, block_size) + right_cost[b + 1];
      if (cost < best.cost) best = {a, b, cost};
    }
  }
  return best;
}

std::pair<RefRange, RefRange> SahBins::split(std::span<PrimitiveRef> refs, const RefRange& range,
                                             const SahCut& cut) {
  RefRange left, right;
  left.begin = range.begin;
  right.end = range.end;
  std::uint32_t next = range.begin, end = range.end;
  if (cut.axis < 0) {
    const std::uint32_t middle = range.begin + range.size() / 2;
    for (; next < middle; ++next) left.grow(refs[next]);
    for (; next < end; ++next) right.grow(refs[next]);
    left.end = right.begin = middle;
    return {left, right};
  }
  const BinMap map(range);
  while (next < end) {
    alignas(16) int bin[4];
    _mm_store_si128(reinterpret_cast<__m128i*>(bin), map.bins_of(refs[next]));
    if (bin[cut.axis] <= cut.bin) {
      left.grow(refs[next++]);
    } else {
      std::swap(refs[next], refs[--end]);
      right.grow(refs[end]);
    }
  }
  left.end = right.begin = end;
  return {left, right};
}

}  // namespace tessera::core
