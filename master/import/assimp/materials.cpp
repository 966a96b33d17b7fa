// SPDX-License-Identifier: Apache-2.0
#include "master/import/assimp/materials.h"

#include <algorithm>
#include <cmath>
#include <optional>

namespace tessera::import {
namespace {

// Reflectance of dielectrics at normal incidence. Neither format says it in a way that programs
// agree on.
constexpr float kDielectric = 0.04f;

class Maker {
 public:
  Maker(const aiMaterial& from, ScenePictures& pictures, WarningGroup& warnings)
      : from_(from), pictures_(pictures), warnings_(warnings) {}

  Material make() {
    aiString name;
    if (from_.Get(AI_MATKEY_NAME, name) == aiReturn_SUCCESS) material_.name = name.C_Str();
    set_color();
    set_gloss();
    set_emission();
    set_opacity();
    set_normals();
    int two_sided = 0;
    if (from_.Get(AI_MATKEY_TWOSIDED, two_sided) == aiReturn_SUCCESS)
      material_.is_double_sided = two_sided != 0;
    return std::move(material_);
  }

 private:
  // The value of a key. The arguments come from one of Assimp's AI_MATKEY macros, which are three.
  std::optional<float> number(const char* key, unsigned type, unsigned index) const {
    float value = 0;
    if (from_.Get(key, type, index, value) != aiReturn_SUCCESS || !std::isfinite(value))
      return std::nullopt;
    return value;
  }
  std::optional<Vec3f> color(const char* key, unsigned type, unsigned index) const {
    aiColor3D value;
    if (from_.Get(key, type, index, value) != aiReturn_SUCCESS) return std::nullopt;
    const Vec3f c{value.r, value.g, value.b};
    if (!is_finite(c)) return std::nullopt;
    return c;
  }
  static Vec3f reflectance(Vec3f c) {
    return {std::clamp(c.x, 0.0f, 1.0f), std::clamp(c.y, 0.0f, 1.0f), std::clamp(c.z, 0.0f, 1.0f)};
  }

  // The picture of the first of `types` that the material has.
  std::optional<PictureUse> picture(std::initializer_list<aiTextureType> types) {
    for (const aiTextureType type : types) {
      aiString file;
      aiTextureMapMode wrap[2] = {aiTextureMapMode_Wrap, aiTextureMapMode_Wrap};
      unsigned set = 0;
      if (from_.GetTexture(type, 0, &file, nullptr, &set, nullptr, nullptr, wrap) !=
              aiReturn_SUCCESS ||
          file.length == 0)
        continue;
      PictureUse use;
      use.where = "material '" + material_.name + "'";
      use.name = file.C_Str();
      use.wrap_u = wrap_of(wrap[0]);
      use.wrap_v = wrap_of(wrap[1]);
      aiUVTransform move;
      if (from_.Get(AI_MATKEY_UVTRANSFORM(type, 0), move) == aiReturn_SUCCESS) {
        use.scale = {move.mScaling.x, move.mScaling.y};
        use.offset = {move.mTranslation.x, move.mTranslation.y};
        if (move.mRotation != 0) use.not_drawn.push_back("rotation of a picture");
      }
      if (!is_finite(Vec3f{use.scale.x, use.scale.y, 0}) ||
          !is_finite(Vec3f{use.offset.x, use.offset.y, 0})) {
        use.scale = {1, 1};
        use.offset = {0, 0};
      }
      if (set > 1) use.not_drawn.push_back("coordinates of set " + std::to_string(set));
      set_ = std::min(set, 1u);
      return use;
    }
    return std::nullopt;
  }
  static TextureWrap wrap_of(aiTextureMapMode mode) {
    if (mode == aiTextureMapMode_Mirror) return TextureWrap::kMirror;
    return mode == aiTextureMapMode_Wrap ? TextureWrap::kRepeat : TextureWrap::kClamp;
  }
  // `ref` with the set of coordinates of the picture that was found last.
  TextureRef placed(TextureRef ref) const {
    ref.uv_set = set_;
    return ref;
  }

  void set_color() {
    auto base = color(AI_MATKEY_BASE_COLOR);
    if (!base) base = color(AI_MATKEY_COLOR_DIFFUSE);
    if (base) material_.albedo = reflectance(*base);
    if (const auto use = picture({aiTextureType_BASE_COLOR, aiTextureType_DIFFUSE})) {
      material_.albedo_texture = placed(pictures_.color(*use));
      // Programs write black beside a picture and mean the picture.
      const bool is_dark =
          !(material_.albedo.x > 0 || material_.albedo.y > 0 || material_.albedo.z > 0);
      if (material_.albedo_texture.is_set() && is_dark) material_.albedo = {1, 1, 1};
    }
  }

  void set_gloss() {
    const auto roughness = number(AI_MATKEY_ROUGHNESS_FACTOR);
    const auto metalness = number(AI_MATKEY_METALLIC_FACTOR);
    const auto rough = picture({aiTextureType_DIFFUSE_ROUGHNESS});
    const auto metal = picture({aiTextureType_METALNESS});
    const float exponent = number(AI_MATKEY_SHININESS).value_or(0);
    const Vec3f shine = color(AI_MATKEY_COLOR_SPECULAR).value_or(Vec3f{});
    const bool is_shiny = exponent > 0 && (shine.x > 0 || shine.y > 0 || shine.z > 0);
    if (!roughness && !metalness && !rough && !metal && !is_shiny) return;
    material_.bsdf = BsdfKind::kGlossy;
    material_.specular = {kDielectric, kDielectric, kDielectric};
    material_.roughness = std::clamp(roughness.value_or(rough      ? 1
                                                        : is_shiny ? roughness_of_exponent(exponent)
                                                                   : 1),
                                     0.0f, 1.0f);
    material_.metalness = std::clamp(metalness.value_or(metal ? 1.0f : 0.0f), 0.0f, 1.0f);
    if (rough || metal) {
      material_.roughness_metalness_texture = placed(
          pictures_.roughness_metalness(rough ? &*rough : nullptr, metal ? &*metal : nullptr));
    }
  }

  void set_emission() {
    const float strength = number(AI_MATKEY_EMISSIVE_INTENSITY).value_or(1);
    if (const auto c = color(AI_MATKEY_COLOR_EMISSIVE); c && strength >= 0) {
      const Vec3f light = *c * strength;
      material_.emission = {std::max(light.x, 0.0f), std::max(light.y, 0.0f),
                            std::max(light.z, 0.0f)};
      if (!is_finite(material_.emission)) material_.emission = {};
    }
    const auto use = picture({aiTextureType_EMISSION_COLOR, aiTextureType_EMISSIVE});
    if (!use) return;
    material_.emission_texture = placed(pictures_.color(*use));
    const bool is_dark =
        !(material_.emission.x > 0 || material_.emission.y > 0 || material_.emission.z > 0);
    if (material_.emission_texture.is_set() && is_dark) material_.emission = {1, 1, 1};
  }

  void set_opacity() {
    float opacity = std::clamp(number(AI_MATKEY_OPACITY).value_or(1), 0.0f, 1.0f);
    const auto use = picture({aiTextureType_OPACITY});
    // Some programs write opacity into this key and others transparency. Nobody means a surface
    // that cannot be seen at all.
    if (opacity == 0) {
      warnings_.add("opacity 0", "material '" + material_.name +
                                     "': its opacity is 0; it is drawn as if that were 1");
      opacity = 1;
    }
    if (use) {
      std::uint32_t channel = 3;
      const TextureRef ref = placed(pictures_.opacity(*use, channel));
      if (ref.is_set()) {
        material_.alpha = {AlphaMode::kBlend, opacity, 0.5f, ref, channel};
        return;
      }
    }
    if (opacity < 1) material_.alpha = {AlphaMode::kBlend, opacity, 0.5f, {}, 3};
  }

  void set_normals() {
    if (const auto use = picture({aiTextureType_NORMALS, aiTextureType_NORMAL_CAMERA})) {
      material_.normal_texture = placed(pictures_.normal(*use));
      return;
    }
    if (const auto use = picture({aiTextureType_HEIGHT}))
      material_.normal_texture = placed(pictures_.bump(*use, material_.normal_scale));
  }

  const aiMaterial& from_;
  ScenePictures& pictures_;
  WarningGroup& warnings_;
  Material material_;
  unsigned set_ = 0;
};

}  // namespace

Material material_of(const aiMaterial& from, ScenePictures& pictures, WarningGroup& warnings) {
  return Maker(from, pictures, warnings).make();
}

}  // namespace tessera::import
