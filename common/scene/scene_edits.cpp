// SPDX-License-Identifier: Apache-2.0
#include "common/scene/scene_edits.h"

#include <algorithm>
#include <cstddef>
#include <string>
#include <utility>

#include "common/base/limits.h"
#include "common/math/transform_checks.h"
#include "common/scene/animation.h"
#include "common/scene/validate.h"
#include "common/scene/validate_animation.h"
#include "common/scene/validate_material.h"
#include "common/scene/validate_mesh.h"
#include "common/scene/validate_surface.h"

namespace tessera {
namespace {

std::string numbered(const char* what, std::uint64_t number) {
  return std::string(what) + " " + std::to_string(number);
}

Status not_there(const std::string& name, std::uint64_t count) {
  return Status::not_found(name + " is not there: the scene has " + std::to_string(count));
}

Status check_transform(const Transform& t, const std::string& name) {
  if (!is_finite(t)) return Status::invalid_argument(name + ": the matrix is not finite");
  if (is_singular(t))
    return Status::invalid_argument(name +
                                    ": the matrix has no inverse; remove the object instead");
  return Status::ok();
}

Status check_range(const std::vector<Vec3f>& into, std::size_t first, std::span<const Vec3f> values,
                   const std::string& name, const char* what) {
  if (first > into.size() || values.size() > into.size() - first) {
    return Status::invalid_argument(name + ": " + std::to_string(values.size()) + " from " +
                                    numbered(what, first) + " on do not fit a mesh that has " +
                                    std::to_string(into.size()));
  }
  for (std::size_t i = 0; i < values.size(); ++i) {
    if (!is_finite(values[i]))
      return Status::invalid_argument(name + ": " + numbered(what, first + i) + " is not finite");
  }
  return Status::ok();
}

Status validate_object(const Mesh& mesh, std::size_t material_count) {
  return validate_mesh(mesh, "the mesh", material_count);
}
Status validate_object(const PatchSurface& surface, std::size_t material_count) {
  return validate_surface(surface, "the surface", material_count);
}

}  // namespace

SceneEdits::SceneEdits() { scene_.materials.resize(1); }

Result<SceneEdits> SceneEdits::of(Scene scene) {
  TESSERA_RETURN_IF_ERROR(validate_scene(scene));
  SceneEdits edits;
  for (const Instance& instance : scene.instances) {
    edits.names_.push_back(edits.next_name_++);
    edits.counts_ += flattened_counts(scene, instance);
  }
  edits.scene_ = std::move(scene);
  return edits;
}

const Scene& SceneEdits::scene() {
  unread_.clear();
  return scene_;
}

Result<std::size_t> SceneEdits::place_of(ObjectName object) const {
  const auto found = std::lower_bound(names_.begin(), names_.end(), object);
  if (found == names_.end() || *found != object)
    return not_there(numbered("object", object), names_.size());
  return static_cast<std::size_t>(found - names_.begin());
}

Status SceneEdits::write(ObjectName object, std::vector<Vec3f> Mesh::*array, const char* what,
                         std::size_t first, std::span<const Vec3f> values) {
  const auto place = place_of(object);
  if (!place.is_ok()) return place.status();
  const std::string name = numbered("object", object);
  const Instance& instance = scene_.instances[*place];
  if (instance.kind != ObjectKind::kMesh)
    return Status::invalid_argument(name + " shows a surface, not a mesh");
  const std::shared_ptr<const Mesh>& mesh = scene_.meshes[instance.mesh];
  TESSERA_RETURN_IF_ERROR(check_range((*mesh).*array, first, values, name, what));
  std::copy(values.begin(), values.end(),
            (writable_mesh(instance.mesh).*array).begin() + static_cast<std::ptrdiff_t>(first));
  return Status::ok();
}

Mesh& SceneEdits::writable_mesh(std::uint32_t index) {
  std::shared_ptr<const Mesh>& mesh = scene_.meshes[index];
  if (const auto own = unread_.find(mesh.get()); own != unread_.end()) return *own->second;
  auto copy = std::make_shared<Mesh>(*mesh);
  mesh = copy;
  return *unread_.emplace(copy.get(), copy).first->second;
}

Status SceneEdits::set_transform(ObjectName object, const Transform& object_to_world) {
  const auto place = place_of(object);
  if (!place.is_ok()) return place.status();
  TESSERA_RETURN_IF_ERROR(check_transform(object_to_world, numbered("object", object)));
  scene_.instances[*place].object_to_world = object_to_world;
  return Status::ok();
}

Status SceneEdits::set_positions(ObjectName object, std::size_t first,
                                 std::span<const Vec3f> positions) {
  return write(object, &Mesh::positions, "vertex", first, positions);
}

Status SceneEdits::set_normals(ObjectName object, std::size_t first,
                               std::span<const Vec3f> normals) {
  return write(object, &Mesh::normals, "normal", first, normals);
}

Status SceneEdits::set_material(std::size_t material, const Material& value) {
  const std::string name = numbered("material", material);
  if (material >= scene_.materials.size()) return not_there(name, scene_.materials.size());
  TESSERA_RETURN_IF_ERROR(validate_material(value, name, scene_.textures.size()));
  scene_.materials[material] = value;
  return Status::ok();
}

Status SceneEdits::set_light(std::size_t light, const Light& value) {
  const std::string name = numbered("light", light);
  if (light >= scene_.lights.size()) return not_there(name, scene_.lights.size());
  TESSERA_RETURN_IF_ERROR(validate_light(value, name));
  scene_.lights[light] = value;
  return Status::ok();
}

Status SceneEdits::set_environment(Vec3f radiance) {
  if (!is_radiance(radiance))
    return Status::invalid_argument("the environment must be finite and >= 0");
  scene_.environment = radiance;
  return Status::ok();
}

Status SceneEdits::set_animation(std::shared_ptr<const SceneAnimation> animation) {
  if (animation) TESSERA_RETURN_IF_ERROR(validate_animation(*animation, scene_));
  scene_.animation = std::move(animation);
  return Status::ok();
}

template <class Object>
Result<ObjectName> SceneEdits::add(std::vector<std::shared_ptr<const Object>>& objects,
                                   ObjectKind kind, std::shared_ptr<const Object> object,
                                   const Transform& object_to_world) {
  TESSERA_RETURN_IF_ERROR(check_transform(object_to_world, "the new object"));
  if (!object) return Status::invalid_argument("the new object shows nothing");
  if (scene_.instances.size() >= kInstancesMax)
    return Status::resource_exhausted("the new object is one too many");
  const auto known = std::find(objects.begin(), objects.end(), object);
  const auto index = static_cast<std::uint32_t>(known - objects.begin());
  if (known == objects.end()) {
    if (block_count_max(scene_) >= kSceneBlocksMax)
      return Status::resource_exhausted("the new object's mesh or surface is one too many");
    TESSERA_RETURN_IF_ERROR(validate_object(*object, scene_.materials.size()));
  }
  FlattenedCounts counts = counts_;
  counts += flattened_counts(*object);
  TESSERA_RETURN_IF_ERROR(validate_flattened(counts));
  counts_ = counts;
  if (known == objects.end()) objects.push_back(std::move(object));
  scene_.instances.push_back({index, object_to_world, kind});
  names_.push_back(next_name_);
  return next_name_++;
}

Result<ObjectName> SceneEdits::add_object(std::shared_ptr<const Mesh> mesh,
                                          const Transform& object_to_world) {
  return add(scene_.meshes, ObjectKind::kMesh, std::move(mesh), object_to_world);
}

Result<ObjectName> SceneEdits::add_object(std::shared_ptr<const PatchSurface> surface,
                                          const Transform& object_to_world) {
  return add(scene_.surfaces, ObjectKind::kPatchSurface, std::move(surface), object_to_world);
}

Status SceneEdits::refuse_removal(const char* what) const {
  if (!scene_.animation) return Status::ok();
  return Status::invalid_argument(
      std::string(what) +
      " of an animated scene cannot be removed: its animation names them by number");
}

Status SceneEdits::remove_object(ObjectName object) {
  const auto place = place_of(object);
  if (!place.is_ok()) return place.status();
  TESSERA_RETURN_IF_ERROR(refuse_removal("objects"));
  const Instance gone = scene_.instances[*place];
  counts_ -= flattened_counts(scene_, gone);
  const auto offset = static_cast<std::ptrdiff_t>(*place);
  scene_.instances.erase(scene_.instances.begin() + offset);
  names_.erase(names_.begin() + offset);
  drop_unused(gone.kind, gone.mesh);
  return Status::ok();
}

// Forgets a mesh or surface that no object shows. Those behind it move up.
void SceneEdits::drop_unused(ObjectKind kind, std::uint32_t index) {
  for (const Instance& instance : scene_.instances) {
    if (instance.kind == kind && instance.mesh == index) return;
  }
  const auto offset = static_cast<std::ptrdiff_t>(index);
  if (kind == ObjectKind::kMesh) {
    unread_.erase(scene_.meshes[index].get());
    scene_.meshes.erase(scene_.meshes.begin() + offset);
  } else {
    scene_.surfaces.erase(scene_.surfaces.begin() + offset);
  }
  for (Instance& instance : scene_.instances)
    instance.mesh -= instance.kind == kind && instance.mesh > index ? 1 : 0;
}

Result<std::size_t> SceneEdits::add_material(const Material& value) {
  if (scene_.materials.size() >= kMaterialsMax)
    return Status::resource_exhausted("the new material is one too many");
  TESSERA_RETURN_IF_ERROR(validate_material(value, "the new material", scene_.textures.size()));
  scene_.materials.push_back(value);
  return scene_.materials.size() - 1;
}

Result<std::size_t> SceneEdits::add_light(const Light& value) {
  if (scene_.lights.size() >= kLightsMax)
    return Status::resource_exhausted("the new light is one too many");
  TESSERA_RETURN_IF_ERROR(validate_light(value, "the new light"));
  scene_.lights.push_back(value);
  return scene_.lights.size() - 1;
}

Status SceneEdits::remove_light(std::size_t light) {
  if (light >= scene_.lights.size())
    return not_there(numbered("light", light), scene_.lights.size());
  TESSERA_RETURN_IF_ERROR(refuse_removal("lights"));
  scene_.lights.erase(scene_.lights.begin() + static_cast<std::ptrdiff_t>(light));
  return Status::ok();
}

}  // namespace tessera
