// SPDX-License-Identifier: Apache-2.0
#include "common/scene/validate.h"

#include <cmath>
#include <string>

#include "common/base/limits.h"
#include "common/math/transform_checks.h"
#include "common/scene/animation.h"
#include "common/scene/validate_animation.h"
#include "common/scene/validate_material.h"
#include "common/scene/validate_surface.h"

namespace tessera {
namespace {

std::string numbered(const char* what, std::size_t index) {
  return std::string(what) + " " + std::to_string(index);
}

// Checks an array that either all vertices have or none.
template <typename T>
Status validate_array(const std::vector<T>& values, const std::string& name, const char* what,
                      std::size_t vertex_count) {
  if (values.empty()) return Status::ok();
  if (values.size() != vertex_count) {
    return Status::invalid_argument(name + ": " + what + "s and vertices differ in number");
  }
  for (std::size_t i = 0; i < values.size(); ++i) {
    if (!is_finite(values[i]))
      return Status::invalid_argument(name + ", " + numbered(what, i) + " is not finite");
  }
  return Status::ok();
}

Status validate_mesh(const Mesh& mesh, const std::string& name, std::size_t material_count) {
  const std::size_t vertex_count = mesh.positions.size();
  if (vertex_count > 0xffffffffu)
    return Status::resource_exhausted(name + ": more than 2^32 - 1 vertices");
  for (std::size_t i = 0; i < vertex_count; ++i) {
    if (!is_finite(mesh.positions[i]))
      return Status::invalid_argument(name + ", " + numbered("vertex", i) + " is not finite");
  }
  TESSERA_RETURN_IF_ERROR(validate_array(mesh.normals, name, "normal", vertex_count));
  TESSERA_RETURN_IF_ERROR(validate_array(mesh.uvs, name, "texture coordinate", vertex_count));
  TESSERA_RETURN_IF_ERROR(
      validate_array(mesh.uvs1, name, "second texture coordinate", vertex_count));
  TESSERA_RETURN_IF_ERROR(validate_array(mesh.tangents, name, "tangent", vertex_count));
  TESSERA_RETURN_IF_ERROR(validate_array(mesh.colors, name, "colour", vertex_count));
  for (std::size_t i = 0; i < mesh.colors.size(); ++i) {
    const Vec4f& c = mesh.colors[i];
    if (!is_share(c.x) || !is_share(c.y) || !is_share(c.z) || !is_share(c.w)) {
      return Status::invalid_argument(name + ", " + numbered("colour", i) + " must lie in [0, 1]");
    }
  }
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
    for (const std::uint32_t vertex : mesh.triangles[i]) {
      if (vertex >= vertex_count) {
        return Status::invalid_argument(name + ", " + numbered("triangle", i) + ": vertex " +
                                        std::to_string(vertex) + " of " +
                                        std::to_string(vertex_count));
      }
    }
  }
  if (mesh.materials.size() != 1 && mesh.materials.size() != mesh.triangles.size()) {
    return Status::invalid_argument(name + ": needs one material, or one for each triangle");
  }
  for (const std::uint32_t material : mesh.materials) {
    if (material >= material_count) {
      return Status::invalid_argument(name + ": material " + std::to_string(material) + " of " +
                                      std::to_string(material_count));
    }
  }
  return Status::ok();
}

Status validate_environment(const Scene& scene) {
  if (!is_radiance(scene.environment))
    return Status::invalid_argument("the environment must be finite and >= 0");
  if (!scene.environment_map) return Status::ok();
  const EnvironmentMap& map = *scene.environment_map;
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

Status validate_cameras(const Scene& scene) {
  for (const NamedCamera& named : scene.cameras) {
    const Status status = validate_camera(named.camera);
    if (!status.is_ok())
      return Status::invalid_argument("camera '" + named.name + "': " + status.message());
  }
  return scene.camera ? validate_camera(*scene.camera) : Status::ok();
}

Status validate_counts(const Scene& scene) {
  if (scene.meshes.size() + scene.surfaces.size() + scene.textures.size() + 3 > kSceneBlocksMax) {
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

Status validate_instance(const Scene& scene, const Instance& instance, const std::string& name) {
  const bool is_mesh = instance.kind == ObjectKind::kMesh;
  if (!is_mesh && instance.kind != ObjectKind::kPatchSurface)
    return Status::invalid_argument(name + ": is of no kind that there is");
  const std::size_t count = is_mesh ? scene.meshes.size() : scene.surfaces.size();
  if (instance.mesh >= count) {
    return Status::invalid_argument(name + (is_mesh ? ": mesh " : ": surface ") +
                                    std::to_string(instance.mesh) + " of " + std::to_string(count));
  }
  if (!is_finite(instance.object_to_world))
    return Status::invalid_argument(name + ": matrix is not finite");
  return Status::ok();
}

// Checks the instances, and how much they make of meshes and surfaces.
Status validate_instances(const Scene& scene) {
  std::uint64_t triangle_count = 0, patch_count = 0, segment_count = 0;
  for (std::size_t i = 0; i < scene.instances.size(); ++i) {
    const Instance& instance = scene.instances[i];
    TESSERA_RETURN_IF_ERROR(validate_instance(scene, instance, numbered("instance", i)));
    if (instance.kind == ObjectKind::kMesh) {
      triangle_count += scene.meshes[instance.mesh]->triangles.size();
    } else {
      patch_count += scene.surfaces[instance.mesh]->patches.size();
      segment_count += scene.surfaces[instance.mesh]->degrees.size();
    }
    if (patch_count > kPatchesMax) return Status::resource_exhausted("more than 2^24 patches");
    if (segment_count > kTrimSegmentsMax)
      return Status::resource_exhausted("more than 2^26 segments of loops");
    if (triangle_count + patch_count > kTrianglesMax)
      return Status::resource_exhausted("more than 2^30 triangles and patches");
  }
  return Status::ok();
}

}  // namespace

Status validate_scene(const Scene& scene) {
  TESSERA_RETURN_IF_ERROR(validate_counts(scene));
  for (std::size_t i = 0; i < scene.meshes.size(); ++i) {
    if (!scene.meshes[i]) return Status::invalid_argument(numbered("mesh", i) + " is missing");
    TESSERA_RETURN_IF_ERROR(
        validate_mesh(*scene.meshes[i], numbered("mesh", i), scene.materials.size()));
  }
  for (std::size_t i = 0; i < scene.surfaces.size(); ++i) {
    if (!scene.surfaces[i]) return Status::invalid_argument(numbered("surface", i) + " is missing");
    TESSERA_RETURN_IF_ERROR(
        validate_surface(*scene.surfaces[i], numbered("surface", i), scene.materials.size()));
  }
  for (std::size_t i = 0; i < scene.textures.size(); ++i) {
    if (!scene.textures[i]) return Status::invalid_argument(numbered("texture", i) + " is missing");
    TESSERA_RETURN_IF_ERROR(validate_texture(*scene.textures[i], numbered("texture", i)));
  }
  for (std::size_t i = 0; i < scene.materials.size(); ++i) {
    TESSERA_RETURN_IF_ERROR(
        validate_material(scene.materials[i], numbered("material", i), scene.textures.size()));
  }
  for (std::size_t i = 0; i < scene.lights.size(); ++i) {
    TESSERA_RETURN_IF_ERROR(validate_light(scene.lights[i], numbered("light", i)));
  }
  TESSERA_RETURN_IF_ERROR(validate_environment(scene));
  if (!is_radiance(scene.background.low) || !is_radiance(scene.background.high))
    return Status::invalid_argument("the background must be finite and >= 0");
  TESSERA_RETURN_IF_ERROR(validate_instances(scene));
  const Bounds3f bounds = scene_bounds(scene);
  if (!bounds.is_empty() &&
      !(is_finite(bounds.lower) && is_finite(bounds.upper) && is_finite(bounds.extent()))) {
    return Status::invalid_argument("the scene is too large: its box overflows");
  }
  TESSERA_RETURN_IF_ERROR(validate_cameras(scene));
  return scene.animation ? validate_animation(*scene.animation, scene) : Status::ok();
}

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
