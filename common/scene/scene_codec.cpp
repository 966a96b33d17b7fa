// SPDX-License-Identifier: Apache-2.0
#include "common/scene/scene_codec.h"

#include <string>
#include <type_traits>
#include <utility>

#include "common/base/limits.h"
#include "common/scene/animation.h"
#include "common/scene/block_bytes.h"
#include "common/scene/material_bytes.h"
#include "common/scene/mesh_block.h"
#include "common/scene/picture_blocks.h"
#include "common/scene/surface_copies.h"
#include "common/scene/validate.h"

namespace tessera {
namespace {

// Calls f with the arrays of an object that is nothing but arrays, in the order of its block.
// Object: a PatchSurface or a SceneAnimation, constant or not. Returns: what f returns.
template <class Object, class F>
auto with_arrays(Object& object, const F& f) {
  if constexpr (std::is_same_v<std::remove_const_t<Object>, SceneAnimation>) {
    return f(object.nodes, object.weights, object.clips, object.names, object.channels,
             object.key_seconds, object.key_values, object.instances, object.lights, object.cameras,
             object.joints, object.meshes, object.influences, object.deltas);
  } else {
    return f(object.patches, object.numbers, object.materials, object.loop_counts,
             object.segment_counts, object.degrees, object.trim_points, object.trim_widths);
  }
}

template <class Object>
SceneBlock encode_arrays(BlockKind kind, const Object& object) {
  BlockWriter out(kind);
  with_arrays(object, [&](const auto&... arrays) { (out.put_array(arrays), ...); });
  return make_scene_block(out.finish());
}

// Returns: null for malformed bytes.
template <class Object, BlockKind kKind>
std::shared_ptr<const Object> decode_arrays(std::span<const std::byte> bytes) {
  BlockReader in(bytes);
  auto object = std::make_shared<Object>();
  const bool is_good = in.open(kKind) && with_arrays(*object, [&](auto&... arrays) {
                         return (in.get_array(arrays) && ...);
                       });
  return is_good && in.is_finished() ? object : nullptr;
}

PrimitiveCounts surface_counts(std::span<const std::byte> bytes) {
  BlockReader in(bytes);
  PrimitiveCounts counts;
  const auto skip = [&](std::uint64_t bytes_each, std::uint64_t& count) {
    BlockReader ahead = in;
    count = ahead.get_count(bytes_each);
    return in.skip_array(bytes_each);
  };
  std::uint64_t passed = 0;
  const bool is_good =
      in.open(BlockKind::kPatchSurface) && skip(sizeof(PatchForm), counts.patches) &&
      skip(sizeof(float), counts.numbers) && skip(sizeof(std::uint32_t), passed) &&
      skip(sizeof(std::uint32_t), passed) && skip(sizeof(std::uint32_t), passed) &&
      skip(sizeof(std::uint8_t), passed) && skip(sizeof(TrimPoint), counts.trim_points);
  return is_good ? counts : PrimitiveCounts{};
}

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

SceneBlock encode_root(const Scene& scene) {
  BlockWriter out(BlockKind::kRoot);
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
  return make_scene_block(out.finish());
}

constexpr std::uint64_t kCameraBytes = 3 * sizeof(Vec3f) + sizeof(float);
constexpr std::uint64_t kLightBytes = 4 + 3 * 12 + 2 * 4;

// How many blocks follow the root, in this order.
struct BlockCounts {
  std::uint64_t meshes = 0, surfaces = 0, textures = 0;
  bool has_environment_map = false, has_animation = false;

  // Whether these are all blocks but the root. Counts may be any numbers.
  bool are(std::uint64_t blocks) const {
    for (const std::uint64_t count : {meshes, surfaces, textures}) {
      if (count > blocks) return false;
      blocks -= count;
    }
    return blocks == (has_environment_map ? 1u : 0u) + (has_animation ? 1u : 0u);
  }
};

// Decodes everything but what has blocks of its own.
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

template <typename T>
std::shared_ptr<const T> cached(
    std::unordered_map<Digest, std::weak_ptr<const T>, DigestHash>& cache, const SceneBlock& block,
    std::shared_ptr<const T> (*decode)(std::span<const std::byte>)) {
  std::weak_ptr<const T>& entry = cache[block.digest];
  if (auto known = entry.lock()) return known;
  auto fresh = decode(*block.bytes);
  entry = fresh;
  return fresh;
}

Status malformed(const char* what, std::size_t index) {
  return Status::data_loss("scene block " + std::to_string(index) + " (" + what + ") is malformed");
}

}  // namespace

BlockBytes block_bytes_of(std::vector<std::byte> bytes) {
  auto held = std::make_shared<const std::vector<std::byte>>(std::move(bytes));
  const std::span<const std::byte> span = *held;
  return shared_block_bytes(std::move(held), span);
}

BlockBytes shared_block_bytes(std::shared_ptr<const void> owner, std::span<const std::byte> bytes) {
  struct Held {
    std::shared_ptr<const void> owner;
    std::span<const std::byte> bytes;
  };
  auto held = std::make_shared<const Held>(Held{std::move(owner), bytes});
  return {held, &held->bytes};
}

SceneBlock make_scene_block(std::vector<std::byte> bytes) {
  SceneBlock block;
  if (is_one_chunk(bytes.size())) {
    block.digest = sha256(bytes);
  } else {
    auto chunks = std::make_shared<const ChunkDigests>(chunk_digests(bytes));
    block.digest = block_digest(bytes.size(), *chunks);
    block.chunks = std::move(chunks);
  }
  block.bytes = block_bytes_of(std::move(bytes));
  return block;
}

std::uint64_t EncodedScene::total_bytes() const {
  std::uint64_t total = 0;
  for (const SceneBlock& block : blocks) total += block.bytes->size();
  return total;
}

PrimitiveCounts primitive_counts_of(const EncodedScene& encoded) {
  Scene root;
  BlockCounts counts;
  if (encoded.blocks.empty() || !decode_root(*encoded.blocks[0].bytes, root, counts) ||
      !counts.are(encoded.blocks.size() - 1)) {
    return {};
  }
  std::vector<PrimitiveCounts> objects;  // meshes, then surfaces
  for (std::uint64_t i = 1; i <= counts.meshes + counts.surfaces; ++i) {
    const std::span<const std::byte> bytes = *encoded.blocks[i].bytes;
    objects.push_back(i <= counts.meshes ? PrimitiveCounts{mesh_triangles(bytes), 0, 0, 0}
                                         : surface_counts(bytes));
  }
  PrimitiveCounts total;
  for (const Instance& instance : root.instances) {
    const bool is_mesh = instance.kind == ObjectKind::kMesh;
    if (instance.mesh >= (is_mesh ? counts.meshes : counts.surfaces)) continue;
    const PrimitiveCounts& object = objects[instance.mesh + (is_mesh ? 0 : counts.meshes)];
    total.triangles += object.triangles;
    total.patches += object.patches;
    total.numbers += object.numbers;
    total.trim_points += object.trim_points;
  }
  return total;
}

std::vector<SurfaceCopies> surface_copies_of(const EncodedScene& encoded) {
  Scene root;
  BlockCounts counts;
  if (encoded.blocks.empty() || !decode_root(*encoded.blocks[0].bytes, root, counts) ||
      !counts.are(encoded.blocks.size() - 1)) {
    return {};
  }
  std::vector<SurfaceCopies> all(counts.surfaces);
  for (std::size_t i = 0; i < all.size(); ++i) all[i].block = 1 + counts.meshes + i;
  for (const Instance& instance : root.instances) {
    if (instance.kind == ObjectKind::kPatchSurface && instance.mesh < all.size())
      ++all[instance.mesh].copies;
  }
  std::erase_if(all, [](const SurfaceCopies& surface) { return surface.copies == 0; });
  return all;
}

std::uint64_t texture_bytes_of(const EncodedScene& encoded) {
  std::uint64_t total = 0;
  for (const SceneBlock& block : encoded.blocks) {
    if (BlockReader(*block.bytes).open(BlockKind::kTexture) ||
        BlockReader(*block.bytes).open(BlockKind::kEnvironment)) {
      total += block.bytes->size();
    }
  }
  return total;
}

bool EncodedScene::is_animated() const {
  return !blocks.empty() && BlockReader(*blocks.back().bytes).open(BlockKind::kAnimation);
}

Digest EncodedScene::digest() const {
  Sha256 hash;
  for (const SceneBlock& block : blocks) hash.update(std::as_bytes(std::span(block.digest.bytes)));
  return hash.finish();
}

EncodedScene SceneEncoder::encode(const Scene& scene) {
  EncodedScene encoded;
  encoded.blocks.reserve(known_.size() + 1);
  encoded.blocks.push_back(encode_root(scene));
  std::unordered_map<const void*, Known> all;  // filled where an object is not at its place
  std::size_t place = 0;
  const auto add = [&](const std::shared_ptr<const void>& object, auto make) {
    if (place == known_.size()) known_.emplace_back();
    Known& here = known_[place++];
    if (here.object != object) {
      if (all.empty()) {
        for (const Known& known : known_) all.try_emplace(known.object.get(), known);
      }
      const auto found = all.find(object.get());
      here = found != all.end() ? found->second : Known{object, make()};
      all.try_emplace(object.get(), here);
    }
    encoded.blocks.push_back(here.block);
  };
  for (const auto& mesh : scene.meshes)
    add(mesh, [&] { return make_scene_block(encode_mesh(*mesh)); });
  for (const auto& surface : scene.surfaces)
    add(surface, [&] { return encode_arrays(BlockKind::kPatchSurface, *surface); });
  for (const auto& texture : scene.textures)
    add(texture, [&] { return make_scene_block(encode_texture(*texture)); });
  if (const auto& map = scene.environment_map)
    add(map, [&] { return make_scene_block(encode_environment(*map)); });
  if (const auto& motion = scene.animation)
    add(motion, [&] { return encode_arrays(BlockKind::kAnimation, *motion); });
  known_.resize(place);  // what this version does not use is forgotten
  return encoded;
}

std::shared_ptr<const Mesh> SceneDecoder::mesh_of(const SceneBlock& block, PlacedMesh& before) {
  if (before.digest == block.digest) {
    if (auto known = before.mesh.lock()) return known;
  }
  auto mesh = cached<Mesh>(meshes_, block, &decode_mesh);
  before = {block.digest, mesh};
  return mesh;
}

Result<Scene> SceneDecoder::decode(const EncodedScene& encoded) {
  const auto forget = [](auto& cache) {
    std::erase_if(cache, [](const auto& entry) { return entry.second.expired(); });
  };
  // Of thousands of objects, few are gone, which are looked for now and then; of few, at once,
  // since what is left of each keeps the heap around it from being given back.
  if (meshes_.size() > placed_.size() + placed_.size() / 8) forget(meshes_);
  forget(surfaces_);
  forget(textures_);
  forget(environments_);
  forget(animations_);
  Scene scene;
  BlockCounts counts;
  if (encoded.blocks.empty() || encoded.blocks.size() > kSceneBlocksMax ||
      !decode_root(*encoded.blocks[0].bytes, scene, counts)) {
    return malformed("root", 0);
  }
  const std::uint64_t others = encoded.blocks.size() - 1;
  if (!counts.are(others)) return malformed("root", 0);
  scene.meshes.reserve(counts.meshes);
  placed_.resize(counts.meshes);
  const std::uint64_t last_surface = counts.meshes + counts.surfaces;
  const std::uint64_t last_texture = last_surface + counts.textures;
  for (std::size_t i = 1; i <= others; ++i) {
    const SceneBlock& block = encoded.blocks[i];
    if (i <= counts.meshes) {
      scene.meshes.push_back(mesh_of(block, placed_[i - 1]));
      if (!scene.meshes.back()) return malformed("mesh", i);
    } else if (i <= last_surface) {
      scene.surfaces.push_back(cached<PatchSurface>(
          surfaces_, block, &decode_arrays<PatchSurface, BlockKind::kPatchSurface>));
      if (!scene.surfaces.back()) return malformed("surface", i);
    } else if (i <= last_texture) {
      scene.textures.push_back(cached<Texture>(textures_, block, &decode_texture));
      if (!scene.textures.back()) return malformed("texture", i);
    } else if (counts.has_animation && i == others) {
      scene.animation = cached<SceneAnimation>(
          animations_, block, &decode_arrays<SceneAnimation, BlockKind::kAnimation>);
      if (!scene.animation) return malformed("animation", i);
    } else {
      scene.environment_map = cached<EnvironmentMap>(environments_, block, &decode_environment);
      if (!scene.environment_map) return malformed("environment", i);
    }
  }
  TESSERA_RETURN_IF_ERROR(validator_.validate(scene));
  return scene;
}

}  // namespace tessera
