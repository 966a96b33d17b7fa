// SPDX-License-Identifier: Apache-2.0
#include "common/scene/root_block.h"

#include "common/scene/block_bytes.h"
#include "common/scene/material_bytes.h"

namespace tessera {
namespace {

void put_camera(BlockWriter& out, const Camera& camera) {
  for (const Vec3f v : {camera.eye, camera.target, camera.up}) out.put(v);
  out.put(camera.vfov_degrees);
}

Camera get_camera(BlockReader& in) {
  Camera camera;
  camera.eye = in.get<Vec3f>();
  camera.target = in.get<Vec3f>();
  camera.up = in.get<Vec3f>();
  camera.vfov_degrees = in.get<float>();
  return camera;
}

constexpr std::uint64_t kInstanceBytes = 4 + 4 + sizeof(Transform);
constexpr std::uint64_t kCameraBytes = 3 * sizeof(Vec3f) + sizeof(float);
constexpr std::uint64_t kLightBytes = 4 + 3 * 12 + 2 * 4;

}  // namespace

std::vector<std::byte> encode_root(const Scene& scene) {
  BlockWriter out(BlockKind::kRoot);
  // Each chunk has up to a record of padding.
  out.reserve((scene.instances.size() * kInstanceBytes / kSceneChunkBytes + 2) * kSceneChunkBytes);
  out.put(std::uint64_t{scene.meshes.size()});
  out.put(std::uint64_t{scene.surfaces.size()});
  out.put(std::uint64_t{scene.textures.size()});
  out.put(std::uint64_t{scene.materials.size()});
  for (const Material& m : scene.materials) put_material(out, m);
  out.put(std::uint64_t{scene.instances.size()});
  for (const Instance& instance : scene.instances) {
    out.begin_record(kInstanceBytes);
    out.put(static_cast<std::uint32_t>(instance.kind));
    out.put(instance.mesh);
    out.put(instance.object_to_world);
  }
  out.put(std::uint64_t{scene.lights.size()});
  for (const Light& light : scene.lights) {
    out.put(static_cast<std::uint32_t>(light.kind));
    for (const Vec3f v : {light.position, light.direction, light.intensity}) out.put(v);
    out.put(light.cos_inner);
    out.put(light.cos_outer);
  }
  out.put(scene.environment);
  out.put(std::uint32_t{scene.environment_map ? 1u : 0u});
  out.put(std::uint32_t{scene.animation ? 1u : 0u});
  out.put(static_cast<std::uint32_t>(scene.background.kind));
  out.put(scene.background.low);
  out.put(scene.background.high);
  out.put(std::uint32_t{scene.camera ? 1u : 0u});
  if (scene.camera) put_camera(out, *scene.camera);
  out.put(std::uint64_t{scene.cameras.size()});
  for (const NamedCamera& named : scene.cameras) {
    out.put_text(named.name);
    put_camera(out, named.camera);
  }
  return out.finish();
}

bool decode_root(std::span<const std::byte> bytes, Scene& scene, BlockCounts& counts) {
  BlockReader in(bytes);
  if (!in.open(BlockKind::kRoot)) return false;
  counts.meshes = in.get<std::uint64_t>();
  counts.surfaces = in.get<std::uint64_t>();
  counts.textures = in.get<std::uint64_t>();
  scene.materials.resize(in.get_count(material_bytes_min()));
  for (Material& m : scene.materials) {
    if (!get_material(in, m)) return false;
  }
  scene.instances.resize(in.get_count(kInstanceBytes));
  for (Instance& instance : scene.instances) {
    if (!in.begin_record(kInstanceBytes)) return false;
    if (!get_enum(in, instance.kind, ObjectKind::kPatchSurface)) return false;
    instance.mesh = in.get<std::uint32_t>();
    instance.object_to_world = in.get<Transform>();
  }
  scene.lights.resize(in.get_count(kLightBytes));
  for (Light& light : scene.lights) {
    const auto kind = in.get<std::uint32_t>();
    if (kind > static_cast<std::uint32_t>(LightKind::kDirectional)) return false;
    light.kind = static_cast<LightKind>(kind);
    light.position = in.get<Vec3f>();
    light.direction = in.get<Vec3f>();
    light.intensity = in.get<Vec3f>();
    light.cos_inner = in.get<float>();
    light.cos_outer = in.get<float>();
  }
  scene.environment = in.get<Vec3f>();
  counts.has_environment_map = in.get<std::uint32_t>() != 0;
  counts.has_animation = in.get<std::uint32_t>() != 0;
  if (!get_enum(in, scene.background.kind, BackgroundKind::kGradient)) return false;
  scene.background.low = in.get<Vec3f>();
  scene.background.high = in.get<Vec3f>();
  if (in.get<std::uint32_t>() != 0) scene.camera = get_camera(in);
  scene.cameras.resize(in.get_count(8 + kCameraBytes));
  for (NamedCamera& named : scene.cameras) {
    if (!in.get_text(named.name)) return false;
    named.camera = get_camera(in);
  }
  return in.is_finished();
}

}  // namespace tessera
