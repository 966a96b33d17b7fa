// SPDX-License-Identifier: Apache-2.0
#include "slave/core/primitive/freeform/shared_surface.h"

#include <algorithm>
#include <span>
#include <utility>

#include "slave/core/primitive/patch/patch_input.h"
#include "slave/core/primitive/patch/placed_sub_patch.h"

namespace tessera::core {

std::uint64_t SharedSurface::memory_bytes() const {
  return patches.capacity() * sizeof(Patch) + parts.capacity() * sizeof(SubPatch) +
         boxes.capacity() * sizeof(Bounds3f);
}

SharedSurface shared_surface(std::shared_ptr<const PatchSurface> surface,
                             const PatchSplitting& splitting) {
  SharedSurface shared;
  shared.radius = splitting.radius;
  shared.reach = reach_of(surface->patches, surface->numbers);
  SubPatches split;
  std::size_t first = 0;
  for (const PatchForm& form : surface->patches) {
    const auto numbers = std::span(surface->numbers).subspan(first, form.number_count());
    first += form.number_count();
    const auto number = static_cast<std::uint32_t>(shared.patches.size());
    const Result<CheckedPatch> checked =
        checked_patch({form.degree_u, form.degree_v, form.is_rational != 0, numbers});
    Patch patch{nullptr, 0, form.degree_u, form.degree_v, form.is_rational != 0};
    patch.trimmed_as = number;
    if (!checked.is_ok()) {
      ++shared.degenerate_count;
      shared.patches.push_back(patch);
      continue;
    }
    patch.numbers = numbers.data();
    patch.extent = checked->extent;
    const std::size_t width = patch.is_rational ? 4 : 3;
    for (std::size_t k = 0; k < numbers.size(); k += width)
      shared.points.grow(Vec3f{numbers[k], numbers[k + 1], numbers[k + 2]});
    split_patch(patch, number, splitting, split);
    shared.patches.push_back(patch);
  }
  // Parts overlap their neighbours, so that they reach beyond their patch by some of its size.
  const Vec3f beyond = shared.points.extent() * 0x1p-12f;
  shared.points = {shared.points.lower - beyond, shared.points.upper + beyond};
  shared.parts = std::move(split.parts);
  shared.boxes = std::move(split.boxes);
  for (std::size_t p = 0; p < shared.parts.size(); ++p)
    shared.parts[p].primitive = static_cast<std::uint32_t>(p);
  shared.parts.shrink_to_fit();
  shared.boxes.shrink_to_fit();
  shared.surface = std::move(surface);
  return shared;
}

Transform to_world_of(const InstanceBlock& place) {
  Transform t;
  for (std::size_t i = 0; i < 3; ++i) std::copy_n(place.to_world[i], 4, t.m[i].begin());
  return t;
}

void place_points(const Transform& to_world, bool is_rational, std::size_t number_count,
                  float* numbers, Bounds3f& box) {
  const std::size_t width = is_rational ? 4 : 3;
  for (std::size_t k = 0; k < number_count; k += width) {
    const Vec3f at = to_world.point({numbers[k], numbers[k + 1], numbers[k + 2]});
    for (int a = 0; a < 3; ++a) numbers[k + static_cast<std::size_t>(a)] = at[a];
    box.grow(at);
  }
}

std::size_t number_count_of(const Patch& patch) {
  return (patch.is_rational ? std::size_t{4} : std::size_t{3}) * (patch.degree_u + std::size_t{1}) *
         (patch.degree_v + std::size_t{1});
}

SubPatch place_part(const Transform& to_world, const SubPatch& part, Patch& patch, float* numbers,
                    Bounds3f& box) {
  const std::size_t count = number_count_of(patch);
  std::copy_n(patch.numbers, count, numbers);
  Bounds3f points;
  place_points(to_world, patch.is_rational, count, numbers, points);
  PatchPlacement placement(to_world);
  placement.take(patch, points);
  patch.numbers = numbers;
  patch.extent = 0;
  for (int a = 0; a < 3; ++a)
    patch.extent = std::max(patch.extent, double{points.upper[a]} - double{points.lower[a]});
  return placement.placed(part, box);
}

}  // namespace tessera::core
