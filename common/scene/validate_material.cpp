// SPDX-License-Identifier: Apache-2.0
#include "common/scene/validate_material.h"

#include <algorithm>
#include <cmath>

#include "common/base/limits.h"

namespace tessera {
namespace {

bool is_color(Vec3f c) { return is_share(c.x) && is_share(c.y) && is_share(c.z); }

// One rule of a material; `rule` names the field and what it must be.
struct Rule {
  bool is_kept;
  const char* rule;
};

Status check(std::initializer_list<Rule> rules, const std::string& name) {
  for (const Rule& rule : rules) {
    if (!rule.is_kept) return Status::invalid_argument(name + ": " + rule.rule);
  }
  return Status::ok();
}

Status validate_texture_ref(const TextureRef& t, const std::string& name,
                            std::size_t texture_count) {
  if (!t.is_set()) return Status::ok();
  if (t.index >= texture_count) {
    return Status::invalid_argument(name + ": texture " + std::to_string(t.index) + " of " +
                                    std::to_string(texture_count));
  }
  const bool is_placed =
      std::all_of(t.uv_map.begin(), t.uv_map.end(), [](float x) { return std::isfinite(x); });
  return check({{t.uv_set <= 1, "texture coordinates must be of set 0 or 1"},
                {is_placed, "the place of a texture must be finite"}},
               name);
}

Status validate_lobes(const Material& m, const std::string& name) {
  return check(
      {{is_share(m.specular_f90), "specular at grazing incidence must lie in [0, 1]"},
       {is_share(m.clearcoat.weight) && is_share(m.clearcoat.roughness),
        "clearcoat and its roughness must lie in [0, 1]"},
       {std::isfinite(m.clearcoat.normal_scale), "the scale of clearcoat normals must be finite"},
       {is_color(m.sheen.color) && is_share(m.sheen.roughness),
        "sheen colour and roughness must lie in [0, 1]"},
       {is_share(m.transmission.weight), "transmission must lie in [0, 1]"},
       {is_color(m.transmission.attenuation_color), "attenuation colour must lie in [0, 1]"},
       {m.transmission.attenuation_distance >= 0 &&
            std::isfinite(m.transmission.attenuation_distance),
        "attenuation distance must be finite and >= 0"},
       {is_share(m.anisotropy.strength) && std::isfinite(m.anisotropy.rotation),
        "anisotropy must lie in [0, 1] and its rotation be finite"},
       {m.alpha.mode <= AlphaMode::kBlend, "unknown alpha mode"},
       {is_share(m.alpha.value), "opacity must lie in [0, 1]"},
       {m.alpha.cutoff >= 0 && std::isfinite(m.alpha.cutoff), "alpha cutoff must be >= 0"},
       {m.alpha.channel <= 3, "the channel of opacity must be 0 to 3"}},
      name);
}

Status validate_scattering(const Material& m, const std::string& name) {
  TESSERA_RETURN_IF_ERROR(
      check({{is_known(m.bsdf), "unknown BSDF"},
             {is_color(m.specular), "specular must lie in [0, 1]"},
             {std::isfinite(m.normal_scale), "the scale of normals must be finite"},
             {is_share(m.roughness) && is_share(m.metalness),
              "roughness and metalness must lie in [0, 1]"},
             {m.ior >= kIorMin && m.ior <= kIorMax, "the index of refraction must lie in [1, 4]"}},
            name));
  const SurfaceProgramShape* program = find_surface_program(m.surface.kind);
  if (program == nullptr) return Status::invalid_argument(name + ": unknown surface program");
  if (const char* parameter = first_bad_parameter(*program, m.surface)) {
    return Status::invalid_argument(name + ": surface " + program->name + ": '" + parameter +
                                    "' is out of range");
  }
  return validate_lobes(m, name);
}

}  // namespace

Status validate_texture(const Texture& t, const std::string& name) {
  if (t.width_px < 1 || t.height_px < 1 || t.width_px > kTextureSideMaxPx ||
      t.height_px > kTextureSideMaxPx) {
    return Status::invalid_argument(name + ": sides must be 1 to " +
                                    std::to_string(kTextureSideMaxPx) + " pixels");
  }
  const std::size_t values =
      4 * static_cast<std::size_t>(t.width_px) * static_cast<std::size_t>(t.height_px);
  const bool is_one = t.rgba.empty() != t.rgba16.empty();
  return check(
      {{is_one && std::max(t.rgba.size(), t.rgba16.size()) == values, "texels do not fit its size"},
       {t.wrap_u <= TextureWrap::kClamp && t.wrap_v <= TextureWrap::kClamp, "unknown wrapping"}},
      name);
}

Status validate_material(const Material& m, const std::string& number, std::size_t texture_count) {
  const std::string name = number + " '" + m.name + "'";
  TESSERA_RETURN_IF_ERROR(check({{is_color(m.albedo), "albedo must lie in [0, 1]"},
                                 {is_radiance(m.emission), "emission must be finite and >= 0"}},
                                name));
  for (const TextureRef* texture : textures_of(m))
    TESSERA_RETURN_IF_ERROR(validate_texture_ref(*texture, name, texture_count));
  return validate_scattering(m, name);
}

}  // namespace tessera
