// SPDX-License-Identifier: Apache-2.0
#include "slave/core/primitive/placed/surface_places.h"

#include <algorithm>
#include <memory>
#include <optional>
#include <unordered_map>
#include <utility>
#include <vector>

#include "common/scene/scene_footprint.h"
#include "common/scene/surface_sharing.h"
#include "slave/core/primitive/freeform/placed_parts.h"
#include "slave/core/primitive/instance/instance_placement.h"

namespace tessera::core {
namespace {

using Surfaces = std::vector<std::shared_ptr<const SharedSurface>>;

bool is_lamp(const PatchSurface& surface, const Scene& scene) {
  return std::any_of(surface.materials.begin(), surface.materials.end(),
                     [&](std::uint32_t m) { return scene.materials[m].emission != Vec3f{}; });
}

bool is_worth_sharing(const PatchSurface& surface, std::uint64_t copies, Instancing instancing) {
  if (copies == 0 || surface.patches.empty() || !surface.loop_counts.empty()) return false;
  if (instancing == Instancing::kNever) return false;
  return instancing == Instancing::kAlways ||
         (copies - 1) * surface.patches.size() >= kSharedPatchesMin;
}

// Returns: nothing where the place is flattened.
//
// Extent. Two control points of a patch that differ by its extent along an axis come back from the
// world within the pad of where they are, by that axis. So they differ in the world where the
// extent is more than two pads; may_share() asks for more, but knows the inverse only nearly.
std::optional<InstanceBlock> place_of(const SharedSurface& surface, const Transform& to_world) {
  if (!may_share(surface.reach, to_world)) return std::nullopt;
  const std::optional<InstanceBlock> block = place_instance(to_world, surface.points);
  if (!block) return std::nullopt;
  const float pad = std::max({block->pad[0], block->pad[1], block->pad[2]});
  return surface.reach.least_extent > 2 * double{pad} ? block : std::nullopt;
}

Surfaces surfaces_of(const Scene& scene, const std::vector<bool>& is_shareable,
                     const PatchSplitting& splitting, const SharedPlaces* known) {
  std::unordered_map<const PatchSurface*, std::shared_ptr<const SharedSurface>> have;
  for (std::size_t s = 0; known != nullptr && s < known->surfaces.size(); ++s) {
    const auto& shared = known->surfaces[s];
    if (shared && shared->radius == splitting.radius) have[shared->surface.get()] = shared;
  }
  Surfaces surfaces(scene.surfaces.size());
  for (std::size_t s = 0; s < surfaces.size(); ++s) {
    const auto& surface = scene.surfaces[s];
    if (!is_shareable[s]) continue;
    std::shared_ptr<const SharedSurface>& shared = have[surface.get()];
    if (!shared) shared = std::make_shared<const SharedSurface>(shared_surface(surface, splitting));
    if (!shared->parts.empty()) surfaces[s] = shared;
  }
  return surfaces;
}

}  // namespace

std::vector<bool> shareable_surfaces(const Scene& scene, Instancing instancing) {
  std::vector<std::uint64_t> copies(scene.surfaces.size(), 0);
  for (std::size_t i = 0; i < scene.instances.size() && !copies.empty(); ++i) {
    const Instance& instance = scene.instances[i];
    if (instance.kind == ObjectKind::kPatchSurface) ++copies[instance.mesh];
  }
  std::vector<bool> is_shareable;
  for (std::size_t s = 0; s < copies.size(); ++s) {
    const PatchSurface& surface = *scene.surfaces[s];
    is_shareable.push_back(is_worth_sharing(surface, copies[s], instancing) &&
                           !is_lamp(surface, scene));
  }
  return is_shareable;
}

SharedPlaces place_surfaces(const Scene& scene, const std::vector<bool>& is_shareable,
                            const PatchSplitting& splitting, const SharedPlaces* known) {
  SharedPlaces places;
  const Surfaces surfaces = surfaces_of(scene, is_shareable, splitting, known);
  const auto is_shared = [](const auto& surface) { return surface != nullptr; };
  if (std::none_of(surfaces.begin(), surfaces.end(), is_shared)) return places;
  places.of_instance.assign(scene.instances.size(), SharedPlaces::kFlattened);
  Surfaces that_stand(surfaces.size());
  for (std::size_t i = 0; i < scene.instances.size(); ++i) {
    const Instance& instance = scene.instances[i];
    if (instance.kind != ObjectKind::kPatchSurface || !surfaces[instance.mesh]) continue;
    std::optional<InstanceBlock> block =
        place_of(*surfaces[instance.mesh], instance.object_to_world);
    if (!block) continue;
    block->mesh = instance.mesh;
    that_stand[instance.mesh] = surfaces[instance.mesh];
    places.of_instance[i] = static_cast<std::uint32_t>(places.places.size());
    places.places.push_back(*block);
  }
  if (places.places.empty()) return {};
  places.places.shrink_to_fit();
  places.surfaces = std::move(that_stand);
  places.first_number = new_place_numbers(places.places.size());
  return places;
}

}  // namespace tessera::core
