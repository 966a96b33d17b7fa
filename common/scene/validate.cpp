// SPDX-License-Identifier: Apache-2.0
#include "common/scene/validate.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <string>
#include <utility>

#include "common/base/limits.h"
#include "common/base/work_gate.h"
#include "common/math/transform_checks.h"
#include "common/scene/animation.h"
#include "common/scene/flattened_counts.h"
#include "common/scene/validate_animation.h"
#include "common/scene/validate_material.h"
#include "common/scene/validate_mesh.h"
#include "common/scene/validate_surface.h"

namespace tessera {
namespace {

std::string numbered(const char* what, std::size_t index) {
  return std::string(what) + " " + std::to_string(index);
}

Status validate_environment_map(const EnvironmentMap& map) {
  if (map.width_px < 1 || map.height_px < 1 || map.width_px > kEnvironmentSideMaxPx ||
      map.height_px > kEnvironmentSideMaxPx) {
    return Status::invalid_argument("the environment's sides must be 1 to " +
                                    std::to_string(kEnvironmentSideMaxPx) + " pixels");
  }
  if (map.rgb.size() !=
      3 * static_cast<std::size_t>(map.width_px) * static_cast<std::size_t>(map.height_px)) {
    return Status::invalid_argument("the environment's texels do not fit its size");
  }
  for (const float x : map.rgb) {
    if (!(x >= 0 && x <= kEnvironmentRadianceMax))
      return Status::invalid_argument("the environment's texels must lie in [0, 1e12]");
  }
  return Status::ok();
}

}  // namespace

Status validate_light(const Light& l, const std::string& name) {
  if (!is_finite(l.position) || !is_finite(l.direction) || !is_radiance(l.intensity)) {
    return Status::invalid_argument(
        name + ": position, direction and intensity must be finite, intensity >= 0");
  }
  if (l.kind != LightKind::kPoint && !(length(l.direction) > 0))
    return Status::invalid_argument(name + ": direction is zero");
  if (!(l.cos_inner >= -1 && l.cos_inner <= 1 && l.cos_outer >= -1 && l.cos_outer <= l.cos_inner)) {
    return Status::invalid_argument(name + ": cone needs -1 <= cos_outer <= cos_inner <= 1");
  }
  return Status::ok();
}

namespace {

Status validate_cameras(const Scene& scene) {
  for (const NamedCamera& named : scene.cameras) {
    const Status status = validate_camera(named.camera);
    if (!status.is_ok())
      return Status::invalid_argument("camera '" + named.name + "': " + status.message());
  }
  return scene.camera ? validate_camera(*scene.camera) : Status::ok();
}

Status validate_counts(const Scene& scene) {
  if (block_count_max(scene) > kSceneBlocksMax) {
    return Status::resource_exhausted("more than " + std::to_string(kSceneBlocksMax) +
                                      " meshes, surfaces and textures");
  }
  if (scene.materials.empty()) return Status::invalid_argument("the scene has no material");
  if (scene.materials.size() > kMaterialsMax)
    return Status::resource_exhausted("too many materials");
  if (scene.instances.size() > kInstancesMax)
    return Status::resource_exhausted("too many instances");
  if (scene.lights.size() > kLightsMax) return Status::resource_exhausted("too many lights");
  if (scene.cameras.size() > kCamerasMax) return Status::resource_exhausted("too many cameras");
  return Status::ok();
}

// Requires: the name is asked for only where something is wrong.
template <class Name>
Status validate_instance(const Scene& scene, const Instance& instance, const Name& name) {
  const bool is_mesh = instance.kind == ObjectKind::kMesh;
  if (!is_mesh && instance.kind != ObjectKind::kPatchSurface)
    return Status::invalid_argument(name() + ": is of no kind that there is");
  const std::size_t count = is_mesh ? scene.meshes.size() : scene.surfaces.size();
  if (instance.mesh >= count) {
    return Status::invalid_argument(name() + (is_mesh ? ": mesh " : ": surface ") +
                                    std::to_string(instance.mesh) + " of " + std::to_string(count));
  }
  if (!is_finite(instance.object_to_world))
    return Status::invalid_argument(name() + ": matrix is not finite");
  return Status::ok();
}

// Checks how much the instances make of meshes and surfaces.
Status validate_all_flattened(const Scene& scene) {
  FlattenedCounts counts;
  for (const Instance& instance : scene.instances) {
    counts += flattened_counts(scene, instance);
    TESSERA_RETURN_IF_ERROR(validate_flattened(counts));
  }
  return Status::ok();
}

// Whether all of a box lies where differences of its points are finite, too. Each coordinate of a
// mapped point is a sum of products, each monotone however it is rounded: so no point of
// the box lies outside of its mapped corners.
bool maps_within_range(const Bounds3f& box, const Transform& map, Bounds3f& all) {
  for (int corner = 0; corner < 8; ++corner) {
    const Vec3f p =
        map.point({corner & 1 ? box.upper.x : box.lower.x, corner & 2 ? box.upper.y : box.lower.y,
                   corner & 4 ? box.upper.z : box.lower.z});
    if (!is_finite(p)) return false;
    all.grow(p);
  }
  return is_finite(all.extent());
}

// Whether the box may lie where differences between it and another one that does not are infinite.
bool may_be_far(const Bounds3f& box, const Transform& map) {
  constexpr float kNear = 1e37f;
  if (box.is_empty()) return false;
  Bounds3f mapped;
  if (!maps_within_range(box, map, mapped)) return true;
  for (int a = 0; a < 3; ++a) {
    if (!(mapped.lower[a] >= -kNear && mapped.upper[a] <= kNear)) return true;
  }
  return false;
}

Bounds3f box_of(const Mesh& mesh) {
  Bounds3f box;
  SmallSteps steps;
  for (const auto& triangle : mesh.triangles) {
    steps.next();
    for (const std::uint32_t vertex : triangle) box.grow(mesh.positions[vertex]);
  }
  return box;
}

Bounds3f box_of(const PatchSurface& surface) {
  Bounds3f box;
  for (PatchCursor patch(surface); patch.is_any(); patch.advance()) {
    for (std::size_t i = 0; i < patch.form().point_count(); ++i) box.grow(patch.point(i));
  }
  return box;
}

std::size_t materials_of(const std::vector<std::uint32_t>& materials) {
  return materials.empty() ? 0
                           : std::size_t{*std::max_element(materials.begin(), materials.end())} + 1;
}

}  // namespace

template <class Object, class Check>
Status SceneValidator::look_at(const std::shared_ptr<const Object>& object, const std::string& name,
                               std::size_t material_count, Check check) {
  if (!object) return Status::invalid_argument(name + " is missing");
  Good& good = good_[object.get()];
  // Another object may have come to lie where one that is gone was.
  const bool is_known = good.object.lock() == object;
  if (is_known && good.materials_needed <= material_count) return Status::ok();
  good = {};
  TESSERA_RETURN_IF_ERROR(check(*object, name));
  if constexpr (requires { object->materials; }) {
    good.materials_needed = materials_of(object->materials);
    good.box = box_of(*object);
  }
  good.object = object;
  return Status::ok();
}

template <class Object, class Check>
Status SceneValidator::look_at_all(const std::vector<std::shared_ptr<const Object>>& objects,
                                   const char* what, std::size_t material_count,
                                   std::vector<Place>& places, const Check& check) {
  places.resize(objects.size());
  for (std::size_t i = 0; i < objects.size(); ++i) {
    const auto& object = objects[i];
    Place& place = places[i];
    place.has_changed = !place.is(object) || place.good.materials_needed > material_count;
    if (!place.has_changed) continue;
    // The name of one in thousands is made where something is wrong with it.
    if (!look_at(object, {}, material_count, check).is_ok())
      return look_at(object, numbered(what, i), material_count, check);
    place.address = object.get();
    place.good = good_.at(object.get());
  }
  return Status::ok();
}

Status SceneValidator::validate_objects(const Scene& scene) {
  const std::size_t count = scene.materials.size();
  const auto is_mesh_good = [&](const Mesh& m, const std::string& name) {
    return validate_mesh(m, name, count);
  };
  const auto is_surface_good = [&](const PatchSurface& s, const std::string& name) {
    return validate_surface(s, name, count);
  };
  TESSERA_RETURN_IF_ERROR(look_at_all(scene.meshes, "mesh", count, meshes_, is_mesh_good));
  TESSERA_RETURN_IF_ERROR(
      look_at_all(scene.surfaces, "surface", count, surfaces_, is_surface_good));
  TESSERA_RETURN_IF_ERROR(
      look_at_all(scene.textures, "texture", count, textures_, validate_texture));
  if (!scene.environment_map) return Status::ok();
  return look_at(
      scene.environment_map, "", count,
      [](const EnvironmentMap& map, const std::string&) { return validate_environment_map(map); });
}

const SceneValidator::Place* SceneValidator::place_of(const Instance& instance) const {
  const std::vector<Place>& places = instance.kind == ObjectKind::kMesh ? meshes_ : surfaces_;
  return instance.mesh < places.size() ? &places[instance.mesh] : nullptr;
}

Status SceneValidator::validate_instances(const Scene& scene, Seen seen) {
  const std::size_t count = scene.instances.size(), before = seen.instances.size();
  bool are_counts_known = count == before;
  const auto has_changed = [](const Place& place) { return place.has_changed; };
  const bool are_same = seen.mesh_count == meshes_.size() &&
                        seen.surface_count == surfaces_.size() &&
                        std::none_of(meshes_.begin(), meshes_.end(), has_changed) &&
                        std::none_of(surfaces_.begin(), surfaces_.end(), has_changed);
  seen.instances.resize(count);
  seen.is_far.resize(count);
  seen.mesh_count = meshes_.size();
  seen.surface_count = surfaces_.size();
  for (std::size_t i = 0; i < count; ++i) {
    const Instance& instance = scene.instances[i];
    Instance& known = seen.instances[i];
    if (are_same && i < before && std::memcmp(&known, &instance, sizeof known) == 0) continue;
    const Place* const place = place_of(instance);
    const bool is_of_same = i < before && place != nullptr && !place->has_changed &&
                            known.kind == instance.kind && known.mesh == instance.mesh;
    if (is_of_same && known.object_to_world == instance.object_to_world) continue;
    TESSERA_RETURN_IF_ERROR(
        validate_instance(scene, instance, [i] { return numbered("instance", i); }));
    are_counts_known = are_counts_known && is_of_same;
    seen.is_far[i] = may_be_far(place->good.box, instance.object_to_world) ? 1 : 0;
    known = instance;
  }
  if (!are_counts_known) TESSERA_RETURN_IF_ERROR(validate_all_flattened(scene));
  seen_ = std::move(seen);
  return Status::ok();
}

Status SceneValidator::validate_size(const Scene& scene) const {
  if (std::count(seen_.is_far.begin(), seen_.is_far.end(), 1) == 0) return Status::ok();
  Bounds3f all;
  for (const Instance& instance : scene.instances) {
    const Bounds3f& box = place_of(instance)->good.box;
    if (box.is_empty() || maps_within_range(box, instance.object_to_world, all)) continue;
    // The corners of the box are further out than what is in it, so all of it is looked at.
    const Bounds3f bounds = scene_bounds(scene);
    if (is_finite(bounds.lower) && is_finite(bounds.upper) && is_finite(bounds.extent())) break;
    return Status::invalid_argument("the scene is too large: its box overflows");
  }
  return Status::ok();
}

Status SceneValidator::validate(const Scene& scene) {
  Seen seen = std::exchange(seen_, {});  // forgotten where anything is wrong
  // What is gone of thousands is looked for now and then, so that this costs each scene little; of
  // few, at once, since what is left of each keeps the heap around it from being given back.
  const std::size_t objects = scene.meshes.size() + scene.surfaces.size() + scene.textures.size();
  if (good_.size() > objects + objects / 8)
    std::erase_if(good_, [](const auto& entry) { return entry.second.object.expired(); });
  TESSERA_RETURN_IF_ERROR(validate_counts(scene));
  TESSERA_RETURN_IF_ERROR(validate_objects(scene));
  for (std::size_t i = 0; i < scene.materials.size(); ++i) {
    TESSERA_RETURN_IF_ERROR(
        validate_material(scene.materials[i], numbered("material", i), scene.textures.size()));
  }
  for (std::size_t i = 0; i < scene.lights.size(); ++i) {
    TESSERA_RETURN_IF_ERROR(validate_light(scene.lights[i], numbered("light", i)));
  }
  if (!is_radiance(scene.environment))
    return Status::invalid_argument("the environment must be finite and >= 0");
  if (!is_radiance(scene.background.low) || !is_radiance(scene.background.high))
    return Status::invalid_argument("the background must be finite and >= 0");
  TESSERA_RETURN_IF_ERROR(validate_instances(scene, std::move(seen)));
  TESSERA_RETURN_IF_ERROR(validate_size(scene));
  TESSERA_RETURN_IF_ERROR(validate_cameras(scene));
  return scene.animation ? validate_animation(*scene.animation, scene) : Status::ok();
}

Status validate_scene(const Scene& scene) { return SceneValidator().validate(scene); }

Status validate_camera(const Camera& camera) {
  if (!is_finite(camera.eye) || !is_finite(camera.target) || !is_finite(camera.up)) {
    return Status::invalid_argument("camera: eye, target and up must be finite");
  }
  if (!(camera.vfov_degrees > 0 && camera.vfov_degrees < 180)) {
    return Status::invalid_argument("camera: the opening angle must lie between 0 and 180 degrees");
  }
  const Vec3f view = normalize(camera.target - camera.eye);
  if (!(length(camera.target - camera.eye) > 0) || !is_finite(view)) {
    return Status::invalid_argument("camera: eye and target are the same point");
  }
  // This is the sine of the angle between view and up; below a thousandth of a degree the picture's
  // roll is rounding noise.
  if (!(length(cross(view, normalize(camera.up))) > 1.7e-5f)) {
    return Status::invalid_argument("camera: up is zero or parallel to the view direction");
  }
  return Status::ok();
}

Bounds3f scene_bounds(const Scene& scene) {
  Bounds3f bounds;
  for (const Instance& instance : scene.instances) {
    const auto grow = [&](Vec3f p) { bounds.grow(instance.object_to_world.point(p)); };
    if (instance.kind == ObjectKind::kPatchSurface) {
      for (PatchCursor patch(*scene.surfaces[instance.mesh]); patch.is_any(); patch.advance()) {
        for (std::size_t i = 0; i < patch.form().point_count(); ++i) grow(patch.point(i));
      }
      continue;
    }
    const Mesh& mesh = *scene.meshes[instance.mesh];
    for (const auto& triangle : mesh.triangles) {
      for (const std::uint32_t vertex : triangle) grow(mesh.positions[vertex]);
    }
  }
  return bounds;
}

}  // namespace tessera
