// SPDX-License-Identifier: Apache-2.0
#include "slave/core/primitive/freeform/patch_store.h"

#include <span>

#include "slave/core/primitive/patch/patch_input.h"
#include "slave/core/primitive/patch/patch_preparation.h"

namespace tessera::core {
namespace {

// The patch's numbers with its points in world space.
std::vector<float> placed(std::span<const float> numbers, std::size_t stride,
                          const Transform& to_world) {
  std::vector<float> to(numbers.begin(), numbers.end());
  if (to_world.is_identity()) return to;
  for (std::size_t at = 0; at < to.size(); at += stride) {
    const Vec3f p = to_world.point({to[at], to[at + 1], to[at + 2]});
    to[at] = p.x;
    to[at + 1] = p.y;
    to[at + 2] = p.z;
  }
  return to;
}

class Filler {
 public:
  Filler(PatchStore& store, std::vector<Bounds3f>& boxes) : store_(store), boxes_(boxes) {}

  void add(const PatchSurface& surface, const Transform& to_world) {
    std::size_t first = 0;
    for (const PatchForm& form : surface.patches) {
      const std::size_t count = form.number_count();
      add(form, std::span(surface.numbers).subspan(first, count), to_world);
      first += count;
    }
  }

 private:
  // A patch that has no extent, or that a transform sends beyond float32, keeps its number and has
  // no parts.
  void add(const PatchForm& form, std::span<const float> numbers, const Transform& to_world) {
    const bool is_rational = form.is_rational != 0;
    const std::vector<float> world = placed(numbers, is_rational ? 4 : 3, to_world);
    const Result<CheckedPatch> checked =
        checked_patch({form.degree_u, form.degree_v, is_rational, world});
    const auto number = static_cast<std::uint32_t>(store_.patches.size());
    if (!checked.is_ok()) {
      ++store_.degenerate_count;
      store_.patches.push_back({nullptr, 0, form.degree_u, form.degree_v, is_rational});
      return;
    }
    SubPatches parts;
    split_patch(checked->patch(), number, PatchSplitting{}, parts);
    store_.parts.insert(store_.parts.end(), parts.parts.begin(), parts.parts.end());
    boxes_.insert(boxes_.end(), parts.boxes.begin(), parts.boxes.end());
    store_.patches.push_back(checked->patch());
    store_.points.insert(store_.points.end(), checked->points.begin(), checked->points.end());
  }

  PatchStore& store_;
  std::vector<Bounds3f>& boxes_;
};

}  // namespace

std::uint64_t PatchStore::memory_bytes() const {
  return points.capacity() * sizeof(PatchPoint) + patches.capacity() * sizeof(Patch) +
         parts.capacity() * sizeof(SubPatch) +
         (first_patch.capacity() + first_part.capacity()) * sizeof(std::uint64_t);
}

PatchStore make_patch_store(const Scene& scene, std::vector<Bounds3f>& boxes) {
  PatchStore store;
  if (scene.surfaces.empty()) return store;
  Filler filler(store, boxes);
  for (const Instance& instance : scene.instances) {
    store.first_patch.push_back(store.patches.size());
    store.first_part.push_back(store.parts.size());
    if (instance.kind == ObjectKind::kPatchSurface)
      filler.add(*scene.surfaces[instance.mesh], instance.object_to_world);
  }
  store.first_patch.push_back(store.patches.size());
  store.first_part.push_back(store.parts.size());
  const PatchPoint* points = store.points.data();  // they have their place now
  for (Patch& patch : store.patches) {
    if (patch.points == nullptr) continue;
    patch.points = points;
    points += (patch.degree_u + 1) * (patch.degree_v + 1);
  }
  return store;
}

}  // namespace tessera::core
