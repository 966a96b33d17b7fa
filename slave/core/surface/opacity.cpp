// SPDX-License-Identifier: Apache-2.0
#include "slave/core/surface/opacity.h"

#include <algorithm>

namespace tessera::core {
namespace {

const std::vector<Vec2f>& uvs_of(const Material& material, const Mesh& mesh) {
  return material.alpha.texture.uv_set == 0 ? mesh.uvs : mesh.uvs1;
}

// A mesh without the coordinates that its picture asks for shows none of it.
bool has_texture(const Material& material, const Mesh& mesh) {
  return material.alpha.texture.is_set() && !uvs_of(material, mesh).empty();
}

float stopped(const Alpha& alpha, float opacity) {
  if (alpha.mode == AlphaMode::kMask) return opacity < alpha.cutoff ? 0.0f : 1.0f;
  return std::clamp(opacity, 0.0f, 1.0f);
}

}  // namespace

bool may_be_passed(const Material& material, const Mesh& mesh, MipMaps textures) {
  const Alpha& alpha = material.alpha;
  if (alpha.mode == AlphaMode::kOpaque) return false;
  if (stopped(alpha, alpha.value) < 1) return true;
  if (has_texture(material, mesh) && !is_full(*textures[alpha.texture.index]->base, alpha.channel))
    return true;
  return std::any_of(mesh.colors.begin(), mesh.colors.end(),
                     [](const Vec4f& c) { return c.w < 1; });
}

std::optional<float> even_opacity(const Material& material, const Mesh& mesh) {
  if (material.alpha.mode == AlphaMode::kOpaque) return 1.0f;
  if (has_texture(material, mesh) || !mesh.colors.empty()) return std::nullopt;
  return stopped(material.alpha, material.alpha.value);
}

float opacity_at(const Material& material, const Mesh& mesh, std::size_t triangle, MipMaps textures,
                 float u, float v) {
  const Alpha& alpha = material.alpha;
  if (alpha.mode == AlphaMode::kOpaque) return 1;
  const auto& corners = mesh.triangles[triangle];
  const float w = 1 - u - v;
  float opacity = alpha.value;
  if (has_texture(material, mesh)) {
    const auto& uvs = uvs_of(material, mesh);
    const Vec2f a = uvs[corners[0]], b = uvs[corners[1]], c = uvs[corners[2]];
    const Vec2f at{a.x * w + b.x * u + c.x * v, a.y * w + b.y * u + c.y * v};
    const Texture& texture = *textures[alpha.texture.index]->base;
    opacity *= sample_channel(texture, mapped_uv(alpha.texture, at), alpha.channel);
  }
  if (!mesh.colors.empty()) {
    opacity *= mesh.colors[corners[0]].w * w + mesh.colors[corners[1]].w * u +
               mesh.colors[corners[2]].w * v;
  }
  return stopped(alpha, opacity);
}

}  // namespace tessera::core
