// SPDX-License-Identifier: Apache-2.0
#include "slave/core/light/light_set.h"

#include <algorithm>
#include <utility>
#include <vector>

#include "common/math/rounding.h"
#include "slave/core/light/emitter_texture.h"
#include "slave/core/light/patch_emitter.h"
#include "slave/core/surface/opacity.h"

namespace tessera::core {
namespace {

const std::vector<Vec2f>& uvs_of(const Mesh& mesh, const TextureRef& ref) {
  return ref.uv_set == 0 ? mesh.uvs : mesh.uvs1;
}

// Returns: false when the triangle sheds no light.
bool add_texture(const Mesh& mesh, std::size_t triangle, const TextureRef& ref,
                 std::shared_ptr<const MipMap> map, Emitter& e, LightSet& set) {
  const auto& t = mesh.triangles[triangle];
  const auto& uvs = uvs_of(mesh, ref);
  const auto uv = [&](std::size_t k) {
    return is_moved(ref) ? mapped_uv(ref, uvs[t[k]]) : uvs[t[k]];
  };
  EmitterTexture at{uv(0), uv(1), uv(2), e.emission, std::move(map)};
  e.emission = e.emission * mean_over(*at.map, at);
  if (is_black(e.emission)) return false;
  e.texture = static_cast<std::int32_t>(set.emitter_textures.size());
  set.emitter_textures.push_back(std::move(at));
  return true;
}

// By mesh, whether any of its triangles may shed light. Most meshes are left at this, however often
// they stand.
std::vector<bool> lamps_of(const Scene& scene) {
  std::vector<bool> is_lamp;
  for (const auto& mesh : scene.meshes) {
    is_lamp.push_back(std::any_of(
        mesh->materials.begin(), mesh->materials.end(),
        [&](std::uint32_t material) { return !is_black(scene.materials[material].emission); }));
  }
  return is_lamp;
}

// The same triangle seen from behind, with B and C exchanged.
Emitter other_side(const Emitter& of, LightSet& set) {
  Emitter e = of;
  std::swap(e.edge_b, e.edge_c);
  e.normal = -of.normal;
  if (of.texture < 0) return e;
  EmitterTexture at = set.emitter_textures[static_cast<std::size_t>(of.texture)];
  std::swap(at.uv_b, at.uv_c);
  e.texture = static_cast<std::int32_t>(set.emitter_textures.size());
  set.emitter_textures.push_back(std::move(at));
  return e;
}

void add_emitters(const Mesh& mesh, const Scene& scene, std::uint64_t first,
                  const TriangleStore& triangles, std::span<const std::uint64_t> left_out,
                  std::span<const std::shared_ptr<const MipMap>> textures, LightSet& set) {
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
    const Material& material =
        scene.materials[mesh.materials.size() == 1 ? mesh.materials[0] : mesh.materials[i]];
    if (is_black(material.emission) ||
        std::binary_search(left_out.begin(), left_out.end(), first + i))
      continue;
    Emitter e;
    e.triangle = static_cast<std::uint32_t>(first + i);
    e.a = triangles.vertex(first + i, 0);
    e.edge_b = triangles.vertex(first + i, 1) - e.a;
    e.edge_c = triangles.vertex(first + i, 2) - e.a;
    const Vec3f normal = cross(e.edge_b, e.edge_c);
    const float twice_area = length(normal);
    if (!(twice_area > 0))
      continue;  // too small for float32: sheds no light that could be measured
    e.normal = normal * (1 / twice_area);
    e.area = twice_area / 2;
    const std::optional<float> opacity = even_opacity(material, mesh);
    if (!opacity) {  // its opacity varies: its light is left to rays that hit it
      set.has_partial_emission = true;
      continue;
    }
    e.opacity = *opacity;
    e.emission = material.emission * e.opacity;
    if (is_black(e.emission)) continue;
    const TextureRef& ref = material.emission_texture;
    if (ref.is_set() && !uvs_of(mesh, ref).empty() &&
        !add_texture(mesh, i, ref, textures[ref.index], e, set))
      continue;
    set.emitters.push_back(e);
    if (material.is_double_sided) set.emitters.push_back(other_side(e, set));
  }
}

// Returns: how many of the sums are at most x. Samples are random, so that no branch may depend on
// them. Shape: rising.
std::size_t count_up_to(float x, std::span<const float> sums) {
  const float* from = sums.data();
  std::size_t left = sums.size();
  for (; left > 1; left -= left / 2) from += from[left / 2 - 1] <= x ? left / 2 : 0;
  const std::size_t last = left == 1 && *from <= x ? 1 : 0;
  return static_cast<std::size_t>(from - sums.data()) + last;
}

// Rec. 709 luminance.
double luminance(Vec3f c) { return 0.2126 * c.x + 0.7152 * c.y + 0.0722 * c.z; }

void share_out(LightSet& set) {
  double power = 0;
  for (const Emitter& e : set.emitters) power += luminance(e.emission) * e.area;
  double sum = 0;
  for (const Emitter& e : set.emitters) {
    sum += luminance(e.emission) * e.area / power;
    set.cumulative.push_back(static_cast<float>(sum));
  }
  set.cumulative.back() = 1;
  // A share is the chance that pick() really gives, so that rounding of the sums does not bias the
  // mean.
  float below = 0;
  for (std::size_t i = 0; i < set.emitters.size(); ++i) {
    set.emitters[i].share = set.cumulative[i] - below;
    below = set.cumulative[i];
  }
}

void set_environment(const Scene& scene, const LightSet* other, LightSet& set) {
  set.environment = scene.environment;
  set.has_environment = !is_black(scene.environment);
  if (!scene.environment_map || !set.has_environment) return;
  const bool is_known =
      other != nullptr && other->sky_map && other->sky_map->map() == scene.environment_map;
  set.sky_map = is_known ? other->sky_map : std::make_shared<const SkyMap>(scene.environment_map);
  if (set.sky_map->power() > 0) return;
  set.sky_map = nullptr;  // the map is black
  set.environment = {};
  set.has_environment = false;
}

}  // namespace

const Emitter& LightSet::pick(float x, float& rest) const {
  const std::size_t number = count_up_to(x, {cumulative.data(), cumulative.size() - 1});
  const Emitter& e = emitters[number];
  const float below = number == 0 ? 0 : cumulative[number - 1];
  rest = std::clamp((x - below) / e.share, 0.0f, 1 - kUnitRoundoff);
  return e;
}

Vec3f LightSet::emission_at(const Emitter& emitter, float u, float v) const {
  if (emitter.texture < 0) return emitter.emission;
  const EmitterTexture& t = emitter_textures[static_cast<std::size_t>(emitter.texture)];
  const float w = 1 - u - v;
  return t.emission * sample_texture(*t.map->base, {t.uv_a.x * w + t.uv_b.x * u + t.uv_c.x * v,
                                                    t.uv_a.y * w + t.uv_b.y * u + t.uv_c.y * v});
}

float LightSet::area_at(const Emitter& emitter, float u, float v) const {
  return emitter.is_patch() ? point_on_patch(*patches, emitter, u, v).area : emitter.area;
}

const Emitter* LightSet::emitter_of(std::uint32_t triangle) const {
  const auto it =
      std::lower_bound(emitters.begin(), emitters.end(), triangle,
                       [](const Emitter& e, std::uint32_t wanted) { return e.triangle < wanted; });
  return it != emitters.end() && it->triangle == triangle ? &*it : nullptr;
}

LightSet make_light_set(const Scene& scene, const TriangleStore& triangles,
                        std::shared_ptr<const PatchStore> patches,
                        std::span<const std::uint64_t> left_out,
                        std::span<const std::shared_ptr<const MipMap>> textures,
                        const LightSet* other) {
  LightSet set;
  set.patches = std::move(patches);
  set.lights = scene.lights;
  set_environment(scene, other, set);
  set.background = scene.background;
  for (Light& light : set.lights) light.direction = normalize(light.direction);
  bool has_emission = false;
  for (const Material& material : scene.materials) has_emission |= !is_black(material.emission);
  if (!has_emission) return set;
  const std::vector<bool> is_lamp = lamps_of(scene);
  for (std::size_t i = 0; i < scene.instances.size(); ++i) {
    if (scene.instances[i].kind == ObjectKind::kPatchSurface) {
      set.has_partial_emission |= !add_patch_emitters(scene, i, *set.patches, textures,
                                                      {set.emitters, set.emitter_textures});
      continue;
    }
    if (!is_lamp[scene.instances[i].mesh]) continue;
    add_emitters(*scene.meshes[scene.instances[i].mesh], scene, triangles.instance_first[i],
                 triangles, left_out, textures, set);
  }
  if (!set.emitters.empty()) share_out(set);
  return set;
}

}  // namespace tessera::core
