// SPDX-License-Identifier: Apache-2.0
#include "slave/core/primitive/freeform/placed_parts.h"

#include <algorithm>
#include <atomic>
#include <cstddef>
#include <memory>

#include "slave/core/primitive/freeform/shared_surface.h"

namespace tessera::core {
namespace {

PlacedParts& parts_of_thread() {
  thread_local const auto parts = std::make_unique<PlacedParts>();
  return *parts;
}

std::uint32_t slot_of(std::uint64_t place, std::uint32_t part) {
  const std::uint64_t key = (place << 20 ^ part) * 0x9e3779b97f4a7c15u;
  return static_cast<std::uint32_t>(key >> 40) & (PlacedParts::kSlots - 1);
}

}  // namespace

std::uint64_t new_place_numbers(std::uint64_t count) {
  static std::atomic<std::uint64_t> next = 0;
  return next.fetch_add(count, std::memory_order_relaxed);
}

PlacedParts::PlacedParts()
    : entries_(std::make_unique_for_overwrite<Entry[]>(kPlacedPartsMax)),
      numbers_(std::make_unique_for_overwrite<float[]>(kPlacedNumbersMax)),
      entry_of_(std::make_unique_for_overwrite<std::uint16_t[]>(kSlots)) {
  drop();
}

void PlacedParts::drop() {
  std::fill_n(entry_of_.get(), kSlots, kNone);
  count_ = number_count_ = 0;
}

PartInWorld PlacedParts::find(const InstanceBlock& place, std::uint64_t place_number,
                              const Patch& patch, const SubPatch& part) {
  std::uint32_t slot = slot_of(place_number, part.primitive);
  for (; entry_of_[slot] != kNone; slot = (slot + 1) & (kSlots - 1)) {
    const Entry& entry = entries_[entry_of_[slot]];
    if (entry.place == place_number && entry.number == part.primitive)
      return {&entry.patch, &entry.part};
  }
  if (!has_room()) {
    drop();
    slot = slot_of(place_number, part.primitive);
  }
  entry_of_[slot] = static_cast<std::uint16_t>(count_);
  Entry& entry = entries_[static_cast<std::size_t>(count_++)];
  entry.place = place_number;
  entry.number = part.primitive;
  make(place, patch, part, entry);
  entry.part.patch = 0;
  entry.part.primitive = place.first_primitive + part.primitive;
  return {&entry.patch, &entry.part};
}

void PlacedParts::make(const InstanceBlock& place, const Patch& patch, const SubPatch& part,
                       Entry& to) {
  to.patch = patch;
  to.part = part;
  if (place.is_identity != 0) return;
  float* const numbers = numbers_.get() + number_count_;
  number_count_ += static_cast<int>(number_count_of(patch));
  Bounds3f box{{0, 0, 0}, {0, 0, 0}};  // nobody asks for it
  to.part = place_part(to_world_of(place), part, to.patch, numbers, box);
}

PartInWorld part_in_world(const InstanceBlock& place, std::uint64_t place_number,
                          const Patch& patch, const SubPatch& part) {
  return parts_of_thread().find(place, place_number, patch, part);
}

bool has_room_for_part() { return parts_of_thread().has_room(); }

}  // namespace tessera::core
