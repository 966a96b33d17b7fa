// SPDX-License-Identifier: Apache-2.0
#include "slave/core/primitive/patch/trim_set.h"

#include <algorithm>
#include <utility>

#include "common/base/check.h"

namespace tessera::core {
namespace {

// NaN becomes 0.
double in_square(double x) { return x > 0 ? std::min(x, 1.0) : 0.0; }

}  // namespace

TrimSet::TrimSet(const PatchSurface& surface, const TrimCellOptions& options,
                 const FatSplitting& splitting)
    : TrimSet(surface, std::make_shared<const TrimLoops>(surface, options), splitting) {}

TrimSet::TrimSet(const PatchSurface& surface, std::shared_ptr<const TrimLoops> loops,
                 const FatSplitting& splitting)
    : loops_(std::move(loops)),
      borders_(surface, widened_segments(surface), cells().coefficients, splitting) {}

bool TrimSet::is_kept(std::uint32_t patch, double u, double v, TrimSteps& steps) const {
  if (patch >= loops_->whole.size()) return true;
  return loops_->square(patch).is_kept({in_square(u), in_square(v)}, steps);
}

Kept TrimSet::kept_of(std::uint32_t patch, const TrimArea& area) const {
  if (patch >= loops_->whole.size()) return Kept::kAll;
  return loops_->square(patch).kept_of(
      {in_square(area.u0), in_square(area.u1), in_square(area.v0), in_square(area.v1)});
}

std::uint64_t TrimSet::kept(std::uint32_t patch, std::span<const TrimPlace> places) const {
  TESSERA_CHECK_LE(places.size(), kTrimPlacesMax);
  const std::size_t count = places.size();
  if (count == 0) return 0;
  if (patch >= loops_->whole.size()) return ~std::uint64_t{0} >> (64 - count);
  const TrimMask& mask = loops_->masks[patch];
  TrimPlace at[kTrimPlacesMax], low{1, 1}, high{0, 0};
  std::uint8_t number[kTrimPlacesMax];
  std::size_t asked = 0;
  std::uint64_t bits = 0;
  for (std::size_t i = 0; i < count; ++i) {
    const TrimPlace place{in_square(places[i].u), in_square(places[i].v)};
    const TrimMask::Column& column = mask.columns[TrimMask::along(place.u)];
    const int row = TrimMask::along(place.v);
    bits |= std::uint64_t{column.kept >> row & 1u} << i;
    if ((column.asks >> row & 1u) == 0) continue;
    at[asked] = place;
    number[asked++] = static_cast<std::uint8_t>(i);
    low = {std::min(low.u, place.u), std::min(low.v, place.v)};
    high = {std::max(high.u, place.u), std::max(high.v, place.v)};
  }
  if (asked == 0) return bits;
  const std::uint64_t answers = loops_->square(patch).kept({at, asked}, low, high);
  for (std::size_t i = 0; i < asked; ++i) bits |= (answers >> i & 1) << number[i];
  return bits;
}

}  // namespace tessera::core
