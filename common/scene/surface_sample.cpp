// SPDX-License-Identifier: Apache-2.0
#include "common/scene/surface_sample.h"

#include "common/scene/block_bytes.h"
#include "common/scene/validate_surface.h"

namespace tessera {
namespace {

// Mixes the bits of a number (S. Vigna, splitmix64), so that patches that repeat with any period
// are drawn alike.
std::uint64_t mixed(std::uint64_t x) {
  x += 0x9e3779b97f4a7c15u;
  x = (x ^ (x >> 30)) * 0xbf58476d1ce4e5b9u;
  x = (x ^ (x >> 27)) * 0x94d049bb133111ebu;
  return x ^ (x >> 31);
}

bool read(std::span<const std::byte> block, PatchSurface& to) {
  BlockReader in(block);
  return in.open(BlockKind::kPatchSurface) && in.get_array(to.patches) &&
         in.get_array(to.numbers) && in.get_array(to.materials) && in.get_array(to.loop_counts) &&
         in.get_array(to.segment_counts) && in.get_array(to.degrees) &&
         in.get_array(to.trim_points) && in.get_array(to.trim_widths) && in.is_finished();
}

// Appends `count` of the numbers from `first` on. Returns: false where there are fewer.
template <class T>
bool append(const std::vector<T>& from, std::size_t first, std::size_t count, std::vector<T>& to) {
  if (first > from.size() || count > from.size() - first) return false;
  const auto begin = from.begin() + static_cast<std::ptrdiff_t>(first);
  to.insert(to.end(), begin, begin + static_cast<std::ptrdiff_t>(count));
  return true;
}

// Walks through a surface whose arrays need not fit each other.
class Drawer {
 public:
  Drawer(const PatchSurface& from, PatchSurface& to) : from_(from), to_(to) {}

  // Takes the next patch, or passes it by. Returns: false where an array ends too early.
  bool next(std::size_t patch, bool is_drawn) {
    const std::size_t numbers = from_.patches[patch].number_count();
    if (is_drawn) {
      to_.patches.push_back(from_.patches[patch]);
      if (!append(from_.numbers, number_, numbers, to_.numbers)) return false;
    }
    number_ += numbers;
    if (from_.loop_counts.empty()) return true;
    if (patch >= from_.loop_counts.size()) return false;
    if (is_drawn) to_.loop_counts.push_back(from_.loop_counts[patch]);
    for (std::uint32_t loop = 0; loop < from_.loop_counts[patch]; ++loop) {
      if (!next_loop(is_drawn)) return false;
    }
    return true;
  }

 private:
  bool next_loop(bool is_drawn) {
    if (loop_ >= from_.segment_counts.size()) return false;
    const std::size_t segments = from_.segment_counts[loop_++];
    if (segments > from_.degrees.size() - segment_) return false;
    std::size_t points = 0;
    for (std::size_t s = segment_; s < segment_ + segments; ++s) points += from_.degrees[s];
    const bool has_widths = !from_.trim_widths.empty();
    const bool is_there = !is_drawn || (append(from_.degrees, segment_, segments, to_.degrees) &&
                                        append(from_.trim_points, point_, points, to_.trim_points));
    if (!is_there) return false;
    if (is_drawn) to_.segment_counts.push_back(static_cast<std::uint32_t>(segments));
    if (is_drawn && has_widths && !append(from_.trim_widths, segment_, segments, to_.trim_widths))
      return false;
    segment_ += segments;
    point_ += points;
    return true;
  }

  const PatchSurface& from_;
  PatchSurface& to_;
  std::size_t number_ = 0, loop_ = 0, segment_ = 0, point_ = 0;
};

}  // namespace

std::uint64_t patches_of_surface(std::span<const std::byte> block) {
  BlockReader in(block);
  return in.open(BlockKind::kPatchSurface) ? in.get_count(sizeof(PatchForm)) : 0;
}

std::uint64_t form_of_surface(std::span<const std::byte> block) {
  PatchSurface surface;
  if (!read(block, surface)) return 0;
  std::uint64_t form = 1;
  const auto mix = [&form](const auto& numbers) {
    form = mixed(form ^ numbers.size());
    for (const std::byte b : std::as_bytes(std::span(numbers)))
      form = (form ^ static_cast<std::uint64_t>(b)) * 0x100000001b3u;
  };
  mix(surface.patches);
  mix(surface.loop_counts);
  mix(surface.segment_counts);
  mix(surface.degrees);
  mix(surface.trim_points);
  return mixed(form);
}

std::optional<SurfaceSample> sample_surface(std::span<const std::byte> block,
                                            std::uint64_t wanted) {
  PatchSurface whole;
  if (!read(block, whole) || whole.patches.empty()) return std::nullopt;
  const std::uint64_t count = whole.patches.size();
  SurfaceSample sample;
  sample.patch_count = count;
  sample.surface.materials = {0};
  Drawer drawer(whole, sample.surface);
  for (std::uint64_t patch = 0; patch < count; ++patch) {
    const bool is_drawn = count <= wanted || mixed(patch) % count < wanted;
    if (!drawer.next(patch, is_drawn)) return std::nullopt;
  }
  if (sample.surface.patches.empty()) return std::nullopt;
  if (!validate_surface(sample.surface, "sample", 1).is_ok()) return std::nullopt;
  return sample;
}

}  // namespace tessera
