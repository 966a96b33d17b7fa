// SPDX-License-Identifier: Apache-2.0
#include "master/import/gltf/lobes.h"

#include <algorithm>

namespace tessera::import {
namespace {

Vec3f vec(const std::array<float, 3>& v) { return {v[0], v[1], v[2]}; }

}  // namespace

void read_reflectance(const GltfObject& material, GltfTextures& textures, Material& surface) {
  const GltfObject refraction = material.extension("KHR_materials_ior");
  refraction.check_keys({"ior"}, {});
  float f0 = 0.04f;
  // Zero is the extension's word for "reflects all that the specular colour says".
  const double ior = refraction.number("ior", 1.5, {0, kIorMax});
  if (refraction.is_there() && ior == 0) {
    f0 = 1;
  } else if (refraction.is_there()) {
    surface.ior = ior >= kIorMin ? static_cast<float>(ior)
                                 : refraction.real("ior", 1.5f, {double{kIorMin}, double{kIorMax}});
    const float root = (surface.ior - 1) / (surface.ior + 1);
    f0 = root * root;
  }
  const GltfObject specular = material.extension("KHR_materials_specular");
  specular.check_keys(
      {"specularFactor", "specularTexture", "specularColorFactor", "specularColorTexture"}, {});
  const float weight = specular.real("specularFactor", 1, kShare);
  const Vec3f color = vec(specular.reals<3>("specularColorFactor", {1, 1, 1}, kFromZero));
  surface.specular = weight * min(f0 * color, Vec3f{1, 1, 1});
  surface.specular_f90 = weight;
  // The weight is in alpha, which no encoding touches, so one texture serves weight and colour
  // where both are one picture.
  surface.specular_texture = textures.read(specular.object("specularTexture"), Encoding::kColour);
  surface.specular_color_texture =
      textures.read(specular.object("specularColorTexture"), Encoding::kColour);
}

void read_clearcoat(const GltfObject& material, GltfTextures& textures, Clearcoat& clearcoat) {
  const GltfObject source = material.extension("KHR_materials_clearcoat");
  if (!source.is_there()) return;
  source.check_keys({"clearcoatFactor", "clearcoatTexture", "clearcoatRoughnessFactor",
                     "clearcoatRoughnessTexture", "clearcoatNormalTexture"},
                    {});
  clearcoat.weight = source.real("clearcoatFactor", 0, kShare);
  clearcoat.roughness = source.real("clearcoatRoughnessFactor", 0, kShare);
  if (clearcoat.weight == 0) return;
  clearcoat.weight_texture = textures.read(source.object("clearcoatTexture"), Encoding::kPlain);
  clearcoat.roughness_texture =
      textures.read(source.object("clearcoatRoughnessTexture"), Encoding::kPlain);
  const GltfObject normal = source.object("clearcoatNormalTexture");
  clearcoat.normal_texture = textures.read(normal, Encoding::kPlain, {"scale"});
  clearcoat.normal_scale = normal.real("scale", 1, kAnyNumber);
}

void read_sheen(const GltfObject& material, GltfTextures& textures, Sheen& sheen) {
  const GltfObject source = material.extension("KHR_materials_sheen");
  if (!source.is_there()) return;
  source.check_keys(
      {"sheenColorFactor", "sheenColorTexture", "sheenRoughnessFactor", "sheenRoughnessTexture"},
      {});
  sheen.color = vec(source.reals<3>("sheenColorFactor", {0, 0, 0}, kShare));
  sheen.roughness = source.real("sheenRoughnessFactor", 0, kShare);
  if (sheen.color == Vec3f{0, 0, 0}) return;
  sheen.color_texture = textures.read(source.object("sheenColorTexture"), Encoding::kColour);
  sheen.roughness_texture =
      textures.read(source.object("sheenRoughnessTexture"), Encoding::kColour);  // its alpha
}

void read_transmission(const GltfObject& material, GltfTextures& textures,
                       Transmission& transmission) {
  const GltfObject source = material.extension("KHR_materials_transmission");
  source.check_keys({"transmissionFactor", "transmissionTexture"}, {});
  const GltfObject volume = material.extension("KHR_materials_volume");
  volume.check_keys(
      {"thicknessFactor", "thicknessTexture", "attenuationDistance", "attenuationColor"}, {});
  const float thickness = volume.real("thicknessFactor", 0, kFromZero);
  const float distance =
      volume.has("attenuationDistance") ? volume.real("attenuationDistance", 0, kPositive) : 0;
  const Vec3f color = vec(volume.reals<3>("attenuationColor", {1, 1, 1}, kShare));
  transmission.weight = source.real("transmissionFactor", 0, kShare);
  if (transmission.weight == 0) return;
  transmission.weight_texture =
      textures.read(source.object("transmissionTexture"), Encoding::kPlain);
  // The solid is as thick as its mesh; thicknessTexture is for renderers that cannot measure that.
  if (!(thickness > 0)) return;
  transmission.is_thin = false;
  transmission.attenuation_distance = distance;
  transmission.attenuation_color = color;
}

void read_anisotropy(const GltfObject& material, GltfTextures& textures, Anisotropy& anisotropy) {
  const GltfObject source = material.extension("KHR_materials_anisotropy");
  if (!source.is_there()) return;
  source.check_keys({"anisotropyStrength", "anisotropyRotation", "anisotropyTexture"}, {});
  anisotropy.strength = source.real("anisotropyStrength", 0, kShare);
  anisotropy.rotation = source.real("anisotropyRotation", 0, kAnyNumber);
  if (anisotropy.strength > 0)
    anisotropy.texture = textures.read(source.object("anisotropyTexture"), Encoding::kPlain);
}

// A dielectric whose reflectance at normal incidence is the specular colour itself is what
// KHR_materials_specular (with an ior of 0) says of this extension, so nothing is approximated.
float read_specular_glossiness(const GltfObject& extension, GltfTextures& textures,
                               Material& surface) {
  extension.check_keys({"diffuseFactor", "diffuseTexture", "specularFactor", "glossinessFactor",
                        "specularGlossinessTexture"},
                       {});
  const auto diffuse = extension.reals<4>("diffuseFactor", {1, 1, 1, 1}, kShare);
  surface.albedo = {diffuse[0], diffuse[1], diffuse[2]};
  surface.albedo_texture = textures.read(extension.object("diffuseTexture"), Encoding::kColour);
  surface.specular = vec(extension.reals<3>("specularFactor", {1, 1, 1}, kShare));
  surface.specular_f90 = 1;
  surface.metalness = 0;
  const float glossiness = extension.real("glossinessFactor", 1, kShare);
  surface.roughness = 1 - glossiness;
  const TextureRef both =
      textures.read(extension.object("specularGlossinessTexture"), Encoding::kColour);
  if (both.is_set()) {
    surface.specular_color_texture = both;
    surface.roughness = 1;
    surface.roughness_metalness_texture = textures.roughness_of_glossiness(both, glossiness);
  }
  return diffuse[3];
}

void name_what_is_not_drawn(const GltfObject& material) {
  const auto name = [&material](const char* extension, const char* instead) {
    if (material.extension(extension).is_there())
      material.warn(extension, std::string("is not drawn; ") + instead);
  };
  name("KHR_materials_iridescence", "what it reflects has no colours of a thin film");
  name("KHR_materials_dispersion", "light of every colour is refracted alike");
  name("KHR_materials_diffuse_transmission", "no light passes it diffusely");
}

}  // namespace tessera::import
