// SPDX-License-Identifier: Apache-2.0
#include "slave/core/primitive/freeform/patch_store.h"

#include <optional>
#include <set>
#include <span>
#include <utility>

#include "slave/core/primitive/patch/fat_border.h"
#include "slave/core/primitive/patch/fat_borders_beside.h"
#include "slave/core/primitive/patch/patch_input.h"
#include "slave/core/primitive/patch/patch_preparation.h"
#include "slave/core/primitive/patch/placed_sub_patch.h"

namespace tessera::core {
namespace {

// A surface in its own place, split once for all of its instances.
struct SplitSurface {
  std::vector<CheckedPatch> patches;  // without numbers where a patch has no extent
  SubPatches parts;
  std::vector<std::size_t> first_number;  // [patch_count]: of its own among the surface's
  std::vector<std::size_t> first_part;    // [patch_count + 1]
  std::shared_ptr<const TrimSet> trims;   // null where nothing is trimmed

  // loops: that surfaces before it had.
  SplitSurface(const PatchSurface& surface, const PatchSplitting& splitting,
               TrimLoopLibrary& loops) {
    if (!surface.loop_counts.empty())
      trims = std::make_shared<const TrimSet>(surface, loops.of(surface), splitting.borders);
    std::size_t first = 0;
    for (const PatchForm& form : surface.patches) {
      const std::size_t count = form.number_count();
      first_number.push_back(first);
      const auto numbers = std::span(surface.numbers).subspan(first, count);
      first += count;
      Result<CheckedPatch> checked =
          checked_patch({form.degree_u, form.degree_v, form.is_rational != 0, numbers});
      first_part.push_back(parts.parts.size());
      CheckedPatch& patch = patches.emplace_back();
      patch.degree_u = form.degree_u;
      patch.degree_v = form.degree_v;
      if (!checked.is_ok()) continue;
      patch = std::move(*checked);
      split(static_cast<std::uint32_t>(patches.size() - 1), splitting);
    }
    first_part.push_back(parts.parts.size());
  }

  // Sub-patches of one instance, with those that stand for its borders.
  std::size_t part_count() const {
    return parts.parts.size() + (trims ? trims->borders().run_count() : 0);
  }

 private:
  void split(std::uint32_t number, const PatchSplitting& splitting) {
    Patch patch = patches[number].patch();
    if (!trims || !trims->is_trimmed(number)) return split_patch(patch, 0, splitting, parts);
    patch.trims = trims.get();
    patch.trimmed_as = number;
    split_trimmed_patch(patch, 0, splitting, parts);
  }
};

// The patch with its points in world space; nothing where the transform leaves it no extent, or
// sends it beyond float32. Shape: box holds its points.
std::optional<CheckedPatch> placed(const CheckedPatch& patch, const Transform& to_world,
                                   Bounds3f& box) {
  std::vector<float> numbers = patch.numbers;
  place_points(to_world, patch.is_rational, numbers.size(), numbers.data(), box);
  Result<CheckedPatch> checked =
      checked_patch({patch.degree_u, patch.degree_v, patch.is_rational, numbers});
  if (!checked.is_ok()) return std::nullopt;
  return std::move(*checked);
}

class Filler {
 public:
  Filler(PatchStore& store, std::vector<Bounds3f>& boxes) : store_(store), boxes_(boxes) {}

  // given: the surface as it is, which outlives the store where it is not moved.
  void add(const SplitSurface& surface, const PatchSurface& given, const Transform& to_world) {
    PatchPlacement placement(to_world);
    const FatPlacement borders(to_world);
    for (std::size_t i = 0; i < surface.patches.size(); ++i) {
      const CheckedPatch& patch = surface.patches[i];
      if (patch.numbers.empty()) {
        add_without_extent(patch);
      } else if (to_world.is_identity()) {
        add_parts(surface, i, nullptr);
        add_borders(surface, i, patch, borders);
        add_patch(surface, i, patch);
        store_.patches.back().numbers = given.numbers.data() + surface.first_number[i];
      } else {
        Bounds3f box;
        const std::optional<CheckedPatch> there = placed(patch, to_world, box);
        if (!there) {
          add_without_extent(patch);
          continue;
        }
        placement.take(patch.patch(), box);
        add_parts(surface, i, &placement);
        add_borders(surface, i, *there, borders);
        add_patch(surface, i, *there);
        store_.numbers.insert(store_.numbers.end(), there->numbers.begin(), there->numbers.end());
      }
    }
  }

 private:
  // It keeps its number and has no parts.
  void add_without_extent(const CheckedPatch& patch) {
    ++store_.degenerate_count;
    store_.patches.push_back({nullptr, 0, static_cast<std::uint8_t>(patch.degree_u),
                              static_cast<std::uint8_t>(patch.degree_v), patch.is_rational});
  }
  void add_patch(const SplitSurface& surface, std::size_t number, const CheckedPatch& patch) {
    store_.patches.push_back(patch.patch());
    store_.patches.back().trims = surface.trims.get();
    store_.patches.back().trimmed_as = static_cast<std::uint32_t>(number);
  }
  void add_parts(const SplitSurface& surface, std::size_t patch, const PatchPlacement* placement) {
    for (std::size_t p = surface.first_part[patch]; p < surface.first_part[patch + 1]; ++p) {
      Bounds3f box = surface.parts.boxes[p];
      const SubPatch& part = surface.parts.parts[p];
      store_.parts.push_back(placement == nullptr ? part : placement->placed(part, box));
      store_.parts.back().patch = static_cast<std::uint32_t>(store_.patches.size());
      boxes_.push_back(box);
    }
  }

  void add_borders(const SplitSurface& surface, std::size_t number, const CheckedPatch& checked,
                   const FatPlacement& placement) {
    if (!surface.trims) return;
    Patch patch = checked.patch();
    patch.trims = surface.trims.get();
    const FatBorders& borders = surface.trims->borders();
    const auto [begin, end] = borders.of_patch(static_cast<std::uint32_t>(number));
    for (std::uint32_t first = begin, next = begin; first < end; first = next) {
      next = borders.end_of_run(first, end);
      Bounds3f box;
      store_.parts.push_back(placement.placed(patch, {first, next}, box));
      store_.parts.back().patch = static_cast<std::uint32_t>(store_.patches.size());
      boxes_.push_back(box);
    }
  }

  PatchStore& store_;
  std::vector<Bounds3f>& boxes_;
};

// Points patches that were moved to their numbers, once these have their place.
void set_numbers(const std::vector<Instance>& instances, PatchStore& store) {
  const float* numbers = store.numbers.data();
  for (std::size_t i = 0; i < instances.size(); ++i) {
    if (instances[i].object_to_world.is_identity()) continue;
    for (std::uint64_t p = store.first_patch[i]; p < store.first_patch[i + 1]; ++p) {
      Patch& patch = store.patches[p];
      if (patch.numbers == nullptr) continue;
      patch.numbers = numbers;
      numbers += number_count_of(patch);
    }
  }
}

std::uint64_t patch_count(const Scene& scene) {
  std::uint64_t count = 0;
  for (const Instance& instance : scene.instances) {
    if (instance.kind == ObjectKind::kPatchSurface)
      count += scene.surfaces[instance.mesh]->patches.size();
  }
  return count;
}

}  // namespace

PatchSplitting splitting_for(std::uint64_t patch_count) {
  // Some 520, 310, 140, 30, 18 and 1.4 parts a patch of the teapot. Of a handful of patches, shadow
  // rays gain by more parts; of more, camera rays lose by them.
  if (patch_count <= 128) return {.radius = 0.27, .slope = 5, .trim_level_max = 4};
  if (patch_count <= 1024) {
    // Twice the usual cells take a quarter of what trims cost a ray, and 1 % more memory.
    return {.radius = 0.35, .slope = 4, .trim_level_max = 4, .cells = {.cells_per_piece = 8}};
  }
  if (patch_count <= 4096) return {.radius = 0.5, .slope = 3, .trim_level_max = 3};
  if (patch_count <= 16384) return {.radius = 0.7, .slope = 1, .trim_level_max = 2};
  if (patch_count <= 65536)
    return {.radius = 1, .slope = 1, .trim_level_max = 1, .borders = {.span_share = 0.5}};
  return {.radius = 3,
          .slope = 1,
          .borders = {.span_share = 4, .run_max = kFatRunMax},
          .cells = {.cells_per_piece = 1}};
}

std::uint64_t PatchStore::memory_bytes() const {
  std::uint64_t of_trims = 0, of_shared = 0;
  for (const auto& surface : shared.surfaces) {
    if (surface) of_shared += surface->memory_bytes();
  }
  of_shared += shared.places.capacity() * sizeof(InstanceBlock) +
               shared.of_instance.capacity() * sizeof(std::uint32_t);
  std::set<const TrimLoops*> loops;
  for (const auto& set : trims) {
    if (!set) continue;
    of_trims += set->borders().bytes();
    if (loops.insert(&set->loops()).second) of_trims += set->loops().bytes();
  }
  return of_trims + of_shared + numbers.capacity() * sizeof(float) +
         patches.capacity() * sizeof(Patch) + parts.capacity() * sizeof(SubPatch) +
         (first_patch.capacity() + first_part.capacity()) * sizeof(std::uint64_t);
}

PatchStore make_patch_store(const Scene& scene, std::vector<Bounds3f>& boxes) {
  return make_patch_store(scene, splitting_of(scene), boxes);
}

PatchSplitting splitting_of(const Scene& scene) { return splitting_for(patch_count(scene)); }

PartInWorld PatchStore::part_at(std::size_t instance, std::uint64_t part) const {
  if (!shared.has(instance)) {
    const SubPatch& stored = parts[first_part[instance] + part];
    return {&patches[stored.patch], &stored};
  }
  const SharedSurface& surface = shared.surface(instance);
  const SubPatch& own = surface.parts[part];
  return part_in_world(shared.place(instance), shared.first_number + shared.of_instance[instance],
                       surface.patches[own.patch], own);
}

PatchStore make_patch_store(const Scene& scene, const PatchSplitting& splitting,
                            std::vector<Bounds3f>& boxes, SharedPlaces shared) {
  PatchStore store;
  if (scene.surfaces.empty()) return store;
  const auto is_flattened = [&](std::size_t i) {
    return scene.instances[i].kind == ObjectKind::kPatchSurface && !shared.has(i);
  };
  std::vector<std::optional<SplitSurface>> split(scene.surfaces.size());
  TrimLoopLibrary loops(splitting.cells);
  std::size_t number_count = 0, patch_count = 0, part_count = 0;
  for (std::size_t i = 0; i < scene.instances.size(); ++i) {
    if (!is_flattened(i)) continue;
    const Instance& instance = scene.instances[i];
    std::optional<SplitSurface>& surface = split[instance.mesh];
    if (!surface) surface.emplace(*scene.surfaces[instance.mesh], splitting, loops);
    if (!instance.object_to_world.is_identity())
      number_count += scene.surfaces[instance.mesh]->numbers.size();
    patch_count += surface->patches.size();
    part_count += surface->part_count();
  }
  // Arrays that grow by doubling would take up to three times as much on their way.
  store.numbers.reserve(number_count);
  store.patches.reserve(patch_count);
  store.parts.reserve(part_count);
  boxes.reserve(boxes.size() + part_count);
  Filler filler(store, boxes);
  for (std::size_t i = 0; i < scene.instances.size(); ++i) {
    const Instance& instance = scene.instances[i];
    store.first_patch.push_back(store.patches.size());
    store.first_part.push_back(store.parts.size());
    if (is_flattened(i))
      filler.add(*split[instance.mesh], *scene.surfaces[instance.mesh], instance.object_to_world);
  }
  for (const std::optional<SplitSurface>& surface : split)
    store.trims.push_back(surface ? surface->trims : nullptr);
  store.surfaces = scene.surfaces;
  store.first_patch.push_back(store.patches.size());
  store.first_part.push_back(store.parts.size());
  store.numbers.shrink_to_fit();
  store.patches.shrink_to_fit();
  store.parts.shrink_to_fit();
  set_numbers(scene.instances, store);
  const std::size_t others = boxes.size() - store.parts.size();
  for (std::size_t i = 0; i < scene.instances.size(); ++i) {
    const std::size_t first = store.first_part[i], count = store.first_part[i + 1] - first;
    join_borders_beside(store.patches.data(), std::span(store.parts).subspan(first, count),
                        std::span(boxes).subspan(others + first, count));
  }
  store.shared = std::move(shared);
  for (std::size_t i = 0; i < store.shared.of_instance.size(); ++i) {
    if (store.shared.has(i)) store.degenerate_count += store.shared.surface(i).degenerate_count;
  }
  return store;
}

}  // namespace tessera::core
