// SPDX-License-Identifier: Apache-2.0
#include "common/scene/scene_codec.h"

#include <cstring>
#include <string>
#include <type_traits>
#include <utility>

#include "common/base/limits.h"
#include "common/scene/animation.h"
#include "common/scene/block_bytes.h"
#include "common/scene/mesh_block.h"
#include "common/scene/picture_blocks.h"
#include "common/scene/root_block.h"
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

// The block of a root of which most bytes are those of the one before: chunks that are the same are
// not hashed again.
SceneBlock root_block_after(const SceneBlock& before, std::vector<std::byte> bytes) {
  if (!before.bytes || !before.chunks || is_one_chunk(bytes.size()))
    return make_scene_block(std::move(bytes));
  const std::span<const std::byte> now = bytes, then = *before.bytes;
  ChunkDigests chunks;
  for (std::uint32_t i = 0; i < chunk_count(now.size()); ++i) {
    const std::size_t at = std::size_t{i} * kSceneChunkBytes;
    const auto chunk = now.subspan(at, chunk_bytes(now.size(), i));
    const bool is_same = i < before.chunks->size() && chunk.size() == chunk_bytes(then.size(), i) &&
                         std::memcmp(chunk.data(), then.data() + at, chunk.size()) == 0;
    chunks.push_back(is_same ? (*before.chunks)[i] : sha256(chunk));
  }
  SceneBlock block;
  block.digest = block_digest(bytes.size(), chunks);
  block.chunks = std::make_shared<const ChunkDigests>(std::move(chunks));
  block.bytes = block_bytes_of(std::move(bytes));
  return block;
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

bool EncodedScene::is_animated() const {
  return !blocks.empty() && BlockReader(*blocks.back().bytes).open(BlockKind::kAnimation);
}

EncodedScene SceneEncoder::encode(const Scene& scene) {
  // Both are forgotten together where memory runs out on the way.
  std::vector<Known> known = std::exchange(known_, {});
  BlockTable::Editor blocks(std::exchange(before_, {}));
  blocks.resize(1 + scene.meshes.size() + scene.surfaces.size() + scene.textures.size() +
                (scene.environment_map ? 1 : 0) + (scene.animation ? 1 : 0));
  blocks.edit(0) = root_block_after(blocks[0], encode_root(scene));
  std::unordered_map<const void*, Known> all;  // filled where an object is not at its place
  std::size_t place = 0;
  const auto add = [&](const std::shared_ptr<const void>& object, auto make) {
    if (place == known.size()) known.emplace_back();
    Known& here = known[place++];
    if (here.object == object) return;
    if (all.empty()) {
      for (const Known& other : known) all.try_emplace(other.object.get(), other);
    }
    const auto found = all.find(object.get());
    here = found != all.end() ? found->second : Known{object, make()};
    all.try_emplace(object.get(), here);
    blocks.edit(place) = here.block;
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
  known.resize(place);  // what this version does not use is forgotten
  known_ = std::move(known);
  EncodedScene encoded;
  encoded.blocks = before_ = blocks.finish();
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

Status SceneDecoder::decode_meshes(const EncodedScene& encoded, std::size_t count,
                                   const Scene* before, Scene& scene) {
  if (before != nullptr) scene.meshes = before->meshes;
  scene.meshes.resize(count);
  placed_.resize(count);
  std::size_t malformed_at = 0;
  const auto decode_one = [&](std::size_t i) {
    if (i == 0 || i > count || malformed_at != 0) return;
    scene.meshes[i - 1] = mesh_of(encoded.blocks[i], placed_[i - 1]);
    if (!scene.meshes[i - 1]) malformed_at = i;
  };
  if (before != nullptr) {
    newest_blocks_.for_each_apart(encoded.blocks, decode_one);
    // A block of a shared chunk was no mesh where the scene before had fewer of them.
    for (std::size_t i = before->meshes.size() + 1; i <= count; ++i) decode_one(i);
  } else {
    for (std::size_t i = 1; i <= count; ++i) decode_one(i);
  }
  return malformed_at != 0 ? malformed("mesh", malformed_at) : Status::ok();
}

void SceneDecoder::forget_expired() {
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
}

Result<Scene> SceneDecoder::decode(const EncodedScene& encoded) {
  Scene scene;
  TESSERA_RETURN_IF_ERROR(decode_into(encoded, nullptr, scene));
  return scene;
}

Result<std::shared_ptr<const Scene>> SceneDecoder::decode_shared(const EncodedScene& encoded) {
  auto scene = std::make_shared<Scene>();
  TESSERA_RETURN_IF_ERROR(decode_into(encoded, newest_.lock().get(), *scene));
  newest_ = scene;
  newest_blocks_ = BlockTable::Trace(encoded.blocks);
  return std::shared_ptr<const Scene>(std::move(scene));
}

Status SceneDecoder::decode_into(const EncodedScene& encoded, const Scene* before, Scene& scene) {
  forget_expired();
  BlockCounts counts;
  if (encoded.blocks.empty() || encoded.blocks.size() > kSceneBlocksMax ||
      !decode_root(*encoded.blocks[0].bytes, scene, counts)) {
    return malformed("root", 0);
  }
  const std::uint64_t others = encoded.blocks.size() - 1;
  if (!counts.are(others)) return malformed("root", 0);
  TESSERA_RETURN_IF_ERROR(decode_meshes(encoded, counts.meshes, before, scene));
  const std::uint64_t last_surface = counts.meshes + counts.surfaces;
  const std::uint64_t last_texture = last_surface + counts.textures;
  for (std::size_t i = 1 + counts.meshes; i <= others; ++i) {
    const SceneBlock& block = encoded.blocks[i];
    if (i <= last_surface) {
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
  return validator_.validate(scene);
}

}  // namespace tessera
