// SPDX-License-Identifier: Apache-2.0
#include "common/scene_io/mtl_material.h"

#include <cmath>
#include <numbers>

namespace tessera {
namespace {

constexpr Vec3f kWhite{1, 1, 1};
// Greatest Kd of a mirror, whose diffuse part is left out.
constexpr float kMirrorDiffuseMax = 0.05f;

class MaterialMaker {
 public:
  MaterialMaker(const MtlLines& lines, ScenePictures& pictures, WarningGroup& warnings,
                Material& material)
      : lines_(lines), pictures_(pictures), warnings_(warnings), material_(material) {}

  void make() {
    set_color();
    set_opacity();
    set_scattering();
    if (material_.bsdf == BsdfKind::kGlossy) set_lobes();
    set_detail();
    name_what_is_not_drawn();
  }

 private:
  const PictureUse* picture(const std::string& key) const {
    const auto known = lines_.pictures.find(key);
    return known == lines_.pictures.end() ? nullptr : &known->second;
  }
  bool is_illum(int a, int b) const { return lines_.illum == a || lines_.illum == b; }
  void warn(const std::string& kind, const std::string& text) {
    warnings_.add(kind, "material '" + material_.name + "': " + text);
  }

  // A picture multiplies the colour; without a colour it is shown as it is.
  void set_color() {
    if (const PictureUse* map = picture("map_Kd")) {
      material_.albedo_texture = pictures_.color(*map);
      if (material_.albedo_texture.is_set()) material_.albedo = kWhite;
    }
    if (lines_.kd) material_.albedo = *lines_.kd;
    if (lines_.ke) material_.emission = *lines_.ke;
    if (const PictureUse* map = picture("map_Ke")) {
      material_.emission_texture = pictures_.color(*map);
      if (!lines_.ke && material_.emission_texture.is_set()) material_.emission = kWhite;
      // Most of such a picture is dark, as a rule, so that without it there is no lamp.
      if (!material_.emission_texture.is_set()) material_.emission = {};
    }
  }

  float opacity() const { return lines_.d ? *lines_.d : lines_.tr ? 1 - *lines_.tr : 1.0f; }

  void set_opacity() {
    if (lines_.d && lines_.tr && std::abs(*lines_.d + *lines_.tr - 1) > 0.001f)
      warn("d and Tr", "'d' and 'Tr' contradict each other; 'd' counts");
    Alpha& alpha = material_.alpha;
    if (const PictureUse* map = picture("map_d"))
      alpha.texture = pictures_.opacity(*map, alpha.channel);
    is_refracting_ = is_illum(6, 7) || (lines_.illum < 0 && opacity() < 1 && lines_.ni &&
                                        *lines_.ni > 1 && !alpha.texture.is_set());
    // illum 4 and 9 do not bend light, unless a picture says where there is nothing at all.
    is_thin_ = is_illum(4, 9) && !alpha.texture.is_set();
    // For a named BSDF other than glass, d is opacity.
    if (lines_.bsdf && *lines_.bsdf != BsdfKind::kGlass) is_refracting_ = is_thin_ = false;
    if (is_refracting_ || is_thin_) {
      if (alpha.texture.is_set()) alpha.mode = AlphaMode::kBlend;
      return;
    }
    alpha.value = opacity();
    if (alpha.value < 1 || alpha.texture.is_set()) alpha.mode = AlphaMode::kBlend;
    if (alpha.value == 0 && !alpha.texture.is_set())
      warn("invisible",
           std::string("it is wholly transparent by '") + (lines_.d ? "d" : "Tr") + "'");
  }

  void set_scattering() {
    const bool has_highlight = lines_.ks ? largest(*lines_.ks) > 0 : picture("map_Ks") != nullptr;
    const bool is_dark =
        largest(material_.albedo) <= kMirrorDiffuseMax && !material_.albedo_texture.is_set();
    const bool has_pbr = lines_.pr || lines_.pm || picture("map_Pr") || picture("map_Pm");
    if (lines_.bsdf) {
      make_named(*lines_.bsdf);
    } else if (is_refracting_ && !(lines_.pr && *lines_.pr > 0)) {
      make_glass();
    } else if (is_refracting_ || is_thin_) {
      make_sheet(!is_refracting_);
    } else if (is_illum(3, 5) && has_highlight && is_dark && !has_pbr) {
      material_.bsdf = BsdfKind::kMirror;
      material_.specular = lines_.ks.value_or(kWhite);
    } else if (has_pbr) {
      make_physical();
    } else if (has_highlight && !is_illum(0, 1) && (lines_.ns || is_illum(3, 5))) {
      make_highlight();
    } else if (lines_.ps || lines_.pc) {
      material_.bsdf = BsdfKind::kGlossy;
    }
  }

  void make_named(BsdfKind kind) {
    material_.bsdf = kind;
    const bool is_delta = scattering_of(kind) == Scattering::kDelta;
    material_.specular = lines_.ks.value_or(is_delta ? kWhite : material_.specular);
    material_.ior = lines_.ni.value_or(material_.ior);
    material_.metalness = lines_.pm.value_or(material_.metalness);
    if (lines_.ns) material_.roughness = roughness_of_exponent(*lines_.ns);
    material_.roughness = lines_.pr.value_or(material_.roughness);
  }

  void make_glass() {
    const Vec3f body = lines_.tf.value_or(kWhite);
    material_.bsdf = BsdfKind::kGlass;
    material_.ior = lines_.ni.value_or(1.5f);
    material_.specular = {std::sqrt(body.x), std::sqrt(body.y), std::sqrt(body.z)};
    if (!(largest(body) > 0)) warn("Tf", "glass that lets nothing through, by 'Tf 0 0 0'");
  }

  // A sheet of the scene tints what passes by its albedo, which takes the value of Tf.
  void make_sheet(bool is_thin) {
    material_.bsdf = BsdfKind::kGlossy;
    material_.ior = lines_.ni.value_or(1.5f);
    const float root = (material_.ior - 1) / (material_.ior + 1);
    material_.specular = Vec3f{root, root, root} * root;
    material_.roughness = lines_.pr.value_or(0);
    material_.transmission.is_thin = is_thin;
    material_.transmission.weight = is_thin && opacity() < 1 ? 1 - opacity() : 1;
    if (lines_.tf || material_.transmission.weight == 1) {
      material_.albedo = lines_.tf.value_or(kWhite);
      if (!lines_.tf && material_.albedo_texture.is_set())
        material_.albedo = lines_.kd.value_or(kWhite);
    }
  }

  void make_physical() {
    material_.bsdf = BsdfKind::kGlossy;
    material_.roughness = lines_.pr.value_or(1);
    material_.metalness = lines_.pm.value_or(picture("map_Pm") ? 1.0f : 0.0f);
    material_.roughness_metalness_texture =
        pictures_.roughness_metalness(picture("map_Pr"), picture("map_Pm"));
  }

  void make_highlight() {
    material_.bsdf = BsdfKind::kGlossy;
    material_.specular = lines_.ks.value_or(kWhite);
    material_.roughness = lines_.ns ? roughness_of_exponent(*lines_.ns) : 0;
    if (const PictureUse* map = picture("map_Ks"))
      material_.specular_color_texture = pictures_.color(*map);
    const PictureUse* exponents = picture("map_Ns");
    if (exponents == nullptr || !lines_.ns) return;
    material_.roughness_metalness_texture =
        pictures_.roughness_of_exponents(*exponents, *lines_.ns);
    if (material_.roughness_metalness_texture.is_set()) material_.roughness = 1;
  }

  void set_lobes() {
    if (lines_.ps) {
      material_.sheen.color = kWhite * *lines_.ps;
      material_.sheen.roughness = 0.5f;
    }
    if (const PictureUse* map = picture("map_Ps")) {
      material_.sheen.color_texture = pictures_.color(*map);
      if (!lines_.ps && material_.sheen.color_texture.is_set()) material_.sheen.color = kWhite;
      material_.sheen.roughness = 0.5f;
    }
    material_.clearcoat.weight = lines_.pc.value_or(0);
    material_.clearcoat.roughness = lines_.pcr.value_or(0);
    material_.anisotropy.strength = lines_.aniso.value_or(0);
    material_.anisotropy.rotation = lines_.anisor.value_or(0) * 2 * std::numbers::pi_v<float>;
  }

  void set_detail() {
    const PictureUse* normals = picture("norm");
    const PictureUse* heights = picture("bump");
    if (normals != nullptr) {
      material_.normal_texture = pictures_.normal(*normals);
      material_.normal_scale = normals->bump;
    } else if (heights != nullptr) {
      material_.normal_texture = pictures_.bump(*heights, material_.normal_scale);
    }
    if (normals != nullptr && heights != nullptr)
      warn("norm and bump", "has 'norm' and 'bump'; 'norm' is drawn");
  }

  // Warns of lines for which the material that came out of them has no place.
  void name_what_is_not_drawn() {
    const bool is_glossy = material_.bsdf == BsdfKind::kGlossy;
    const auto has = [this](const char* key) { return picture(key) != nullptr; };
    const auto name = [this](const char* key) {
      warn(key, std::string("'") + key + "' has no place in a material of its kind (illum " +
                    (lines_.illum < 0 ? "not given" : std::to_string(lines_.illum)) +
                    ") and is not drawn");
    };
    if (has("map_Ks") && !material_.specular_color_texture.is_set() &&
        !(lines_.ks && !(largest(*lines_.ks) > 0))) {
      name("map_Ks");
    }
    if (has("map_Ns") && !material_.roughness_metalness_texture.is_set()) name("map_Ns");
    if ((has("map_Pr") || has("map_Pm")) && !material_.roughness_metalness_texture.is_set())
      name(has("map_Pr") ? "map_Pr" : "map_Pm");
    if (!is_glossy && has("map_Ps")) name("map_Ps");
    const bool is_varnished = lines_.pc && *lines_.pc > 0;
    if (!is_glossy && lines_.ps && *lines_.ps > 0) name("Ps");
    if (!is_glossy && is_varnished) name("Pc");
    if (lines_.pcr && !is_varnished && *lines_.pcr > 0)
      warn("Pcr", "'Pcr' is the roughness of a varnish, of which there is none ('Pc')");
    if (!is_glossy && lines_.aniso && *lines_.aniso > 0) name("aniso");
    if (material_.bsdf == BsdfKind::kMirror && lines_.tf && *lines_.tf != kWhite) name("Tf");
    if (material_.emission_texture.is_set() && !(largest(material_.emission) > 0))
      warn("map_Ke", "'map_Ke' is multiplied by 'Ke 0 0 0': it shows nothing");
    const PictureUse* color = picture("map_Kd");
    if (material_.albedo_texture.is_set() && !(largest(material_.albedo) > 0))
      warn("map_Kd", "'map_Kd' is multiplied by 'Kd 0 0 0': it shows nothing");
    if (color != nullptr && material_.alpha.mode == AlphaMode::kOpaque &&
        material_.transmission.weight == 0 && pictures_.has_alpha(*color)) {
      warn("alpha",
           "the picture " + color->name +
               " has an alpha channel, but no 'map_d' says that it is opacity; it is drawn "
               "opaque");
    }
  }

  const MtlLines& lines_;
  ScenePictures& pictures_;
  WarningGroup& warnings_;
  Material& material_;
  bool is_refracting_ = false, is_thin_ = false;
};

}  // namespace

void apply_mtl_lines(const MtlLines& lines, ScenePictures& pictures, WarningGroup& warnings,
                     Material& material) {
  MaterialMaker(lines, pictures, warnings, material).make();
}

}  // namespace tessera
