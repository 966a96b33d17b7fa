// SPDX-License-Identifier: Apache-2.0
#include "master/import/gltf/materials.h"

#include <algorithm>
#include <vector>

#include "master/import/gltf/lobes.h"

namespace tessera::import {
namespace {

constexpr std::size_t kNameBytesMax = 256;

// Whether BsdfKind::kGlass, which knows ior, one colour and absorption, draws the same.
bool is_smooth_glass(const Material& m) {
  const bool is_clear = m.transmission.weight == 1 && !m.transmission.is_thin &&
                        !m.transmission.weight_texture.is_set() && m.metalness == 0;
  const bool is_plain = m.roughness == 0 && !m.albedo_texture.is_set() &&
                        !m.normal_texture.is_set() && m.alpha.mode == AlphaMode::kOpaque &&
                        !m.is_unlit;
  const bool is_dielectric =
      m.specular_f90 == 1 && !m.specular_texture.is_set() && !m.specular_color_texture.is_set();
  return is_clear && is_plain && is_dielectric && m.clearcoat.weight == 0 &&
         m.sheen.color == Vec3f{0, 0, 0};
}

bool has_own_specular(const GltfObject& source) {
  return source.extension("KHR_materials_specular").has("specularColorFactor");
}

std::array<TextureRef*, 14> all_textures(Material& m) {
  std::array<TextureRef*, 14> refs{};
  const auto found = textures_of(m);
  for (std::size_t i = 0; i < refs.size(); ++i) refs[i] = const_cast<TextureRef*>(found[i]);
  return refs;
}

}  // namespace

const GltfMaterial& GltfMaterials::read(std::optional<std::uint32_t> index) {
  const auto known = known_.find(index);
  if (known != known_.end()) return known->second;
  const GltfObject source = index ? document_.at("materials", *index) : GltfObject();
  source.check_keys(
      {"pbrMetallicRoughness", "normalTexture", "occlusionTexture", "emissiveTexture",
       "emissiveFactor", "alphaMode", "alphaCutoff", "doubleSided"},
      {"KHR_materials_unlit", "KHR_materials_emissive_strength", "KHR_materials_ior",
       "KHR_materials_transmission", "KHR_materials_volume", "KHR_materials_clearcoat",
       "KHR_materials_sheen", "KHR_materials_specular", "KHR_materials_anisotropy",
       "KHR_materials_pbrSpecularGlossiness", "KHR_materials_iridescence",
       "KHR_materials_dispersion", "KHR_materials_diffuse_transmission", "KHR_xmp_json_ld"});
  Material surface;
  surface.name = source.text("name").substr(0, kNameBytesMax);
  read_core(source, surface);
  read_emission(source, surface);
  name_what_is_not_drawn(source);
  if (is_smooth_glass(surface) && !has_own_specular(source)) {
    surface.bsdf = BsdfKind::kGlass;
    surface.specular = surface.albedo;
    surface.transmission.weight = 0;  // kGlass implies it
  }
  GltfMaterial& made = known_[index];
  made = place_coordinates(source, surface);
  made.index = static_cast<std::uint32_t>(scene_.materials.size());
  scene_.materials.push_back(std::move(surface));
  return made;
}

void GltfMaterials::read_core(const GltfObject& source, Material& surface) {
  surface.bsdf = BsdfKind::kGlossy;
  const GltfObject pbr = source.object("pbrMetallicRoughness");
  pbr.check_keys({"baseColorFactor", "baseColorTexture", "metallicFactor", "roughnessFactor",
                  "metallicRoughnessTexture"},
                 {});
  const GltfObject glossiness = source.extension("KHR_materials_pbrSpecularGlossiness");
  float opacity = 1;
  if (glossiness.is_there()) {
    opacity = read_specular_glossiness(glossiness, textures_, surface);
  } else {
    const auto base = pbr.reals<4>("baseColorFactor", {1, 1, 1, 1}, kShare);
    surface.albedo = {base[0], base[1], base[2]};
    opacity = base[3];
    surface.albedo_texture = textures_.read(pbr.object("baseColorTexture"), Encoding::kColour);
    surface.metalness = pbr.real("metallicFactor", 1, kShare);
    surface.roughness = pbr.real("roughnessFactor", 1, kShare);
    surface.roughness_metalness_texture =
        textures_.read(pbr.object("metallicRoughnessTexture"), Encoding::kPlain);
    read_reflectance(source, textures_, surface);
  }
  read_alpha(source, opacity, surface);
  surface.is_double_sided = source.flag("doubleSided", false);
  surface.is_unlit = source.extension("KHR_materials_unlit").is_there();
  const GltfObject normal = source.object("normalTexture");
  surface.normal_texture = textures_.read(normal, Encoding::kPlain, {"scale"});
  surface.normal_scale = normal.real("scale", 1, kAnyNumber);
  read_clearcoat(source, textures_, surface.clearcoat);
  read_sheen(source, textures_, surface.sheen);
  read_transmission(source, textures_, surface.transmission);
  read_anisotropy(source, textures_, surface.anisotropy);
}

void GltfMaterials::read_alpha(const GltfObject& source, float value, Material& surface) {
  const float cutoff = source.real("alphaCutoff", 0.5f, kFromZero);
  const std::string mode = source.has("alphaMode") ? source.text("alphaMode") : "OPAQUE";
  if (mode == "MASK") {
    surface.alpha.mode = AlphaMode::kMask;
    surface.alpha.cutoff = cutoff;
  } else if (mode == "BLEND") {
    surface.alpha.mode = AlphaMode::kBlend;
  } else {
    if (mode != "OPAQUE")
      source.warn("alphaMode",
                  "is '" + printable(mode) + "'; it must be OPAQUE, MASK or BLEND; OPAQUE is used");
    return;
  }
  surface.alpha.value = value;
  surface.alpha.texture = surface.albedo_texture;
}

void GltfMaterials::read_emission(const GltfObject& source, Material& surface) {
  const GltfObject extension = source.extension("KHR_materials_emissive_strength");
  extension.check_keys({"emissiveStrength"}, {});
  const float strength = extension.real("emissiveStrength", 1, kFromZero);
  const auto factor = source.reals<3>("emissiveFactor", {0, 0, 0}, kShare);
  const Vec3f emission = strength * Vec3f{factor[0], factor[1], factor[2]};
  const GltfObject picture = source.object("emissiveTexture");
  if (emission == Vec3f{0, 0, 0}) return;
  surface.emission_texture = textures_.read(picture, Encoding::kColour);
  // Most of an emissive texture is dark, as a rule: where it cannot be read, nothing is emitted.
  if (!picture.is_there() || surface.emission_texture.is_set()) surface.emission = emission;
}

// A mesh of the scene has two sets of texture coordinates, a mesh of the file any number. Where the
// material uses a set above 1, the first two sets that its textures use become those of the mesh.
GltfMaterial GltfMaterials::place_coordinates(const GltfObject& source, Material& surface) {
  std::vector<std::uint32_t> used;
  for (const TextureRef* ref : textures_of(surface)) {
    const bool is_new = std::find(used.begin(), used.end(), ref->uv_set) == used.end();
    if (ref->is_set() && is_new) used.push_back(ref->uv_set);
  }
  GltfMaterial made;
  if (std::any_of(used.begin(), used.end(), [](std::uint32_t set) { return set > 1; })) {
    made.uv_sets[0] = used[0];
    // Where the material uses one set only, no texture refers to the second, whatever it is.
    made.uv_sets[1] = used.size() > 1 ? used[1] : 0;
  }
  for (TextureRef* ref : all_textures(surface)) {
    if (!ref->is_set()) {
      ref->uv_set = 0;
    } else if (ref->uv_set == made.uv_sets[0]) {
      ref->uv_set = 0;
    } else if (ref->uv_set == made.uv_sets[1]) {
      ref->uv_set = 1;
      made.uses_second_set = true;
    } else {
      source.warn("texCoord",
                  "names a third set of texture coordinates, and two are read; the "
                  "first is used");
      ref->uv_set = 0;
    }
  }
  const std::pair<bool, const TextureRef*> needs[] = {
      {surface.normal_texture.is_set(), &surface.normal_texture},
      {surface.clearcoat.normal_texture.is_set(), &surface.clearcoat.normal_texture},
      {surface.anisotropy.strength > 0, &surface.anisotropy.texture}};
  for (const auto& [is_needed, ref] : needs) {
    if (is_needed && !made.tangent_set) made.tangent_set = ref->uv_set;
  }
  return made;
}

}  // namespace tessera::import
