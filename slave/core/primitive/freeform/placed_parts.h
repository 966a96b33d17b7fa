// SPDX-License-Identifier: Apache-2.0
// The table behind placed_parts_abi.h, and numbers for places.
//
// Threads. PlacedParts: one owner. new_place_numbers(): any thread.
#pragma once

#include <cstdint>
#include <memory>

#include "common/scene/scene_footprint.h"
#include "slave/core/primitive/freeform/placed_parts_abi.h"

namespace tessera::core {

// Returns: the first of `count` numbers that no other place has had since the program began, so
// that what a thread keeps is never taken for a place of another scene.
std::uint64_t new_place_numbers(std::uint64_t count);

// A hash table with open addresses; what is in it stays where it is until all of it is dropped.
class PlacedParts {
 public:
  PlacedParts();

  PartInWorld find(const InstanceBlock& place, std::uint64_t place_number, const Patch& patch,
                   const SubPatch& part);
  bool has_room() const {
    return count_ < kPlacedPartsMax && number_count_ + 4 * kPatchPointsMax <= kPlacedNumbersMax;
  }

  static constexpr std::uint32_t kSlots = 2 * kPlacedPartsMax;  // a power of two
  struct Entry {
    std::uint64_t place;
    std::uint32_t number;  // of the part within the surface
    SubPatch part;
    Patch patch;
  };
  static constexpr std::uint64_t kBytes = kPlacedPartsMax * sizeof(Entry) +
                                          kPlacedNumbersMax * sizeof(float) +
                                          kSlots * sizeof(std::uint16_t);

 private:
  static constexpr std::uint16_t kNone = 0xffff;

  void drop();
  void make(const InstanceBlock& place, const Patch& patch, const SubPatch& part, Entry& to);

  std::unique_ptr<Entry[]> entries_;           // [kPlacedPartsMax]
  std::unique_ptr<float[]> numbers_;           // [kPlacedNumbersMax]
  std::unique_ptr<std::uint16_t[]> entry_of_;  // [kSlots]; kNone: empty
  int count_ = 0, number_count_ = 0;
};
static_assert(kPlacedPartsMax < 0xffff && (PlacedParts::kSlots & (PlacedParts::kSlots - 1)) == 0);
static_assert(PlacedParts::kBytes <= kPlacedPartsBytes);

}  // namespace tessera::core
