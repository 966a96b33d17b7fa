// SPDX-License-Identifier: Apache-2.0
#include "tests/sim/picture.h"

#include <array>
#include <map>
#include <unordered_map>
#include <utility>

#include "common/base/check.h"
#include "common/scene/animation.h"
#include "tests/sim/edited_scenes.h"
#include "tests/sim/random.h"

namespace tessera::sim {
namespace {

constexpr int kHeavyTextureSide = 896;  // 896 * 896 * 4 bytes: 3 MiB
constexpr int kChangingTextureSide = 544;
constexpr std::size_t kChangingTextures = 8;   // different ones; the next tag has the first again
constexpr std::size_t kChangingChunksOwn = 2;  // of each of them

std::shared_ptr<const Mesh> triangle_at(float x) {
  auto mesh = std::make_shared<Mesh>();
  mesh->positions = {{x, 0, 0}, {x + 1, 0, 0}, {x, 1, 0}};
  mesh->triangles = {{0, 1, 2}};
  mesh->materials = {0};
  return mesh;
}

// Noise, of which a stretch depends on the number. The stretches of two numbers do not overlap
// wholly, so that each change brings two to four chunks.
std::shared_ptr<const Texture> changing_texture(std::size_t number) {
  static std::array<std::shared_ptr<const Texture>, kChangingTextures> made;
  if (made[number]) return made[number];
  auto texture = std::make_shared<Texture>();
  texture->width_px = texture->height_px = kChangingTextureSide;
  texture->rgba.resize(std::size_t{4} * kChangingTextureSide * kChangingTextureSide);
  const std::size_t begin = number * kSceneChunkBytes;
  const std::size_t end = begin + kChangingChunksOwn * kSceneChunkBytes;
  for (std::size_t i = 0; i < texture->rgba.size(); ++i) {
    const std::uint64_t own = i >= begin && i < end ? number + 1 : 0;
    texture->rgba[i] = static_cast<std::uint8_t>(mix(i ^ own << 32));
  }
  made[number] = texture;
  return texture;
}

// Moves the first instance along x.
std::shared_ptr<const SceneAnimation> motion() {
  static const std::shared_ptr<const SceneAnimation> made = [] {
    SceneAnimation a;
    a.nodes.resize(1);
    MotionChannel channel;
    channel.key_count = 2;
    a.channels = {channel};
    a.clips = {{1, 0}};
    a.key_seconds = {0, 1};
    a.key_values = {0, 0, 0, 1, 0, 0};
    a.instances = {{0, 0, {}}};
    return std::make_shared<const SceneAnimation>(std::move(a));
  }();
  return made;
}

Scene make_scene(int tag, SceneWeight weight) {
  static const std::shared_ptr<const Mesh> shared = triangle_at(-10);
  static const std::shared_ptr<const Texture> heavy = [] {
    auto texture = std::make_shared<Texture>();
    texture->width_px = texture->height_px = kHeavyTextureSide;
    texture->rgba.assign(std::size_t{4} * kHeavyTextureSide * kHeavyTextureSide, 7);
    return texture;
  }();
  Scene scene;
  scene.meshes = {triangle_at(static_cast<float>(tag)), shared};
  scene.materials.emplace_back();
  scene.instances = {{0, {}}, {1, {}}};
  if (weight == SceneWeight::kHeavy) scene.textures = {heavy};
  if (weight == SceneWeight::kChanging) {
    scene.textures = {changing_texture(static_cast<std::size_t>(tag) % kChangingTextures)};
  }
  if (!scene.textures.empty()) scene.materials[0].albedo_texture = 0;
  if (weight == SceneWeight::kMoving) scene.animation = motion();
  return scene;
}

struct Prepared {
  std::map<Shown, std::shared_ptr<const core::PreparedScene>> scenes;
  std::map<const core::PreparedScene*, Shown> shown;
};
Prepared& prepared() {
  static Prepared all;
  return all;
}

std::unordered_map<Digest, BlockBytes, DigestHash>& known_blocks() {
  static std::unordered_map<Digest, BlockBytes, DigestHash> all;
  return all;
}

}  // namespace

const EncodedScene& scene_of_tag(int tag, SceneWeight weight) {
  TESSERA_CHECK_LT(tag, kSceneTagsMax);
  static std::map<std::pair<int, SceneWeight>, EncodedScene> made;
  static SceneEncoder encoder;
  const auto [scene, is_new] = made.try_emplace({tag, weight});
  if (is_new) {
    scene->second = encoder.encode(weight == SceneWeight::kEdited ? edited_scene(tag)
                                                                  : make_scene(tag, weight));
    for (const SceneBlock& block : scene->second.blocks) known_blocks()[block.digest] = block.bytes;
  }
  return scene->second;
}

const std::span<const std::byte>* bytes_of(const Digest& digest) {
  const auto found = known_blocks().find(digest);
  return found == known_blocks().end() ? nullptr : found->second.get();
}

Result<Shown> shown_by(const EncodedScene& encoded) {
  static SceneDecoder decoder;
  static Scene newest;  // is kept, as by a slave, so that the next one may share what it has
  Result<Scene> scene = decoder.decode(encoded);
  if (!scene.is_ok()) return scene.status();
  newest = *std::move(scene);
  return Shown{static_cast<int>(newest.meshes[0]->positions[0].x), encoded.time_seconds};
}

std::shared_ptr<const core::PreparedScene> prepared_for(const Shown& shown) {
  Prepared& all = prepared();
  auto& scene = all.scenes[shown];
  if (!scene) {
    auto built =
        core::PreparedScene::build(make_scene(shown.tag, SceneWeight::kLight), {1, nullptr, {}});
    TESSERA_CHECK(built.is_ok());
    scene = *built;
    all.shown[scene.get()] = shown;
  }
  return scene;
}

Shown shown_by(const core::PreparedScene& scene) {
  const auto known = prepared().shown.find(&scene);
  return known != prepared().shown.end() ? known->second : Shown{0, 0, met_by_rays(scene)};
}

Shown shown_of_edited(int tag) {
  static std::map<int, Shown> all;
  const auto [shown, is_new] = all.try_emplace(tag);
  if (is_new) {
    const auto built = core::PreparedScene::build(edited_scene(tag), {1, nullptr, {}});
    TESSERA_CHECK(built.is_ok());
    shown->second.met = met_by_rays(**built);
  }
  return shown->second;
}

void draw(const Shown& shown, const FrameSettings& settings, const TileRect& rect,
          std::span<std::byte> bytes) {
  const auto time = static_cast<std::uint64_t>(shown.seconds * 1024);
  const std::uint64_t picture = mix((time << 8 | static_cast<std::uint64_t>(shown.tag)) << 32 ^
                                    settings.seed ^ 0x7069637475726500u ^ shown.met);
  std::size_t at = 0;
  for (int y = rect.y_px; y < rect.y_px + rect.height_px; ++y) {
    std::uint64_t value = mix(picture + static_cast<std::uint64_t>(y) * 0x10001) +
                          static_cast<std::uint64_t>(rect.x_px) * 0x9e3779b97f4a7c15u;
    for (int x = 0; x < rect.width_px; ++x, value += 0x9e3779b97f4a7c15u) {
      for (const int shift : {20, 36, 52}) bytes[at++] = static_cast<std::byte>(value >> shift);
    }
  }
}

}  // namespace tessera::sim
