// SPDX-License-Identifier: Apache-2.0
#include "slave/core/light/patch_emitter.h"

#include <utility>

#include "common/math/vec3d.h"
#include "slave/core/light/emitter_texture.h"
#include "slave/core/primitive/freeform/patch_point.h"
#include "slave/core/primitive/patch/fat_border.h"
#include "slave/core/primitive/patch/patch_answer_abi.h"
#include "slave/core/primitive/patch/patch_evaluation.h"
#include "slave/core/primitive/patch/sub_patch_range.h"
#include "slave/core/surface/opacity.h"

namespace tessera::core {
namespace {

PatchEmitterPoint point_at(const PatchStore& patches, const Emitter& emitter, double u, double v) {
  const SubPatch& part = patches.parts[static_cast<std::size_t>(emitter.part)];
  const SubPatchRange range(part);
  const PatchJet jet = evaluate(patches.patches[part.patch], u, v);
  const Vec3d across =
      cross(Vec3d{jet.du[0], jet.du[1], jet.du[2]}, Vec3d{jet.dv[0], jet.dv[1], jet.dv[2]});
  const double size = length(across);
  PatchEmitterPoint on;
  on.point = rounded(Vec3d{jet.point[0], jet.point[1], jet.point[2]});
  on.u = static_cast<float>(u);
  on.v = static_cast<float>(v);
  if (!(size > 0)) return on;
  if (part.is_trimmed && !is_kept(patches.patches[part.patch], u, v)) return on;
  on.normal = rounded((emitter.is_back ? -1 / size : 1 / size) * across);
  on.area = static_cast<float>(size * 4 * range.half_u * range.half_v);
  return on;
}

// About its area, for its share: what it is sampled with is exact in any case.
float area_of(const PatchStore& patches, const Emitter& emitter) {
  constexpr int kSide = 3;
  float sum = 0;
  for (int i = 0; i < kSide; ++i) {
    for (int j = 0; j < kSide; ++j) {
      const auto middle = [](int k) { return (static_cast<float>(k) + 0.5f) / kSide; };
      sum += sample_on_patch(patches, emitter, {middle(i), middle(j)}).area;
    }
  }
  return sum / (kSide * kSide);
}

// Returns: false when what the part shows of the texture is black.
bool add_texture(const TextureRef& ref, std::shared_ptr<const MipMap> map,
                 const SubPatchRange& range, Emitter& e, std::vector<EmitterTexture>& textures) {
  const auto low_u = static_cast<float>(range.middle_u - range.half_u);
  const auto low_v = static_cast<float>(range.middle_v - range.half_v);
  const auto wide_u = static_cast<float>(2 * range.half_u);
  const auto wide_v = static_cast<float>(2 * range.half_v);
  const auto uv = [&](float u, float v) {
    return is_moved(ref) ? mapped_uv(ref, {u, v}) : Vec2f{u, v};
  };
  const EmitterTexture part{uv(low_u, low_v), uv(low_u + wide_u, low_v), uv(low_u, low_v + wide_v),
                            e.emission, map};
  e.emission = e.emission * mean_over(*map, part);
  if (is_black(e.emission)) return false;
  e.texture = static_cast<std::int32_t>(textures.size());
  textures.push_back({uv(0, 0), uv(1, 0), uv(0, 1), part.emission, std::move(map)});
  return true;
}

}  // namespace

PatchEmitterPoint sample_on_patch(const PatchStore& patches, const Emitter& emitter, Vec2f square) {
  const SubPatchRange range(patches.parts[static_cast<std::size_t>(emitter.part)]);
  return point_at(patches, emitter, range.middle_u + range.half_u * (2 * double{square.x} - 1),
                  range.middle_v + range.half_v * (2 * double{square.y} - 1));
}

PatchEmitterPoint point_on_patch(const PatchStore& patches, const Emitter& emitter, float u,
                                 float v) {
  return point_at(patches, emitter, double{u}, double{v});
}

bool add_patch_emitters(const Scene& scene, std::size_t instance, const PatchStore& patches,
                        std::span<const std::shared_ptr<const MipMap>> maps, EmitterList to) {
  bool is_whole = true;
  const std::vector<std::uint32_t>& materials =
      scene.surfaces[scene.instances[instance].mesh]->materials;
  for (std::uint64_t p = patches.first_part[instance]; p < patches.first_part[instance + 1]; ++p) {
    const SubPatch& part = patches.parts[p];
    if (is_fat_border(part)) continue;  // it has no area
    const std::uint64_t local = part.patch - patches.first_patch[instance];
    const Material& material = scene.materials[materials[materials.size() == 1 ? 0 : local]];
    if (is_black(material.emission)) continue;
    const std::optional<float> opacity = even_opacity(material, mesh_of_patches());
    if (!opacity) {  // its opacity varies: its light is left to rays that hit it
      is_whole = false;
      continue;
    }
    Emitter e;
    e.opacity = *opacity;
    e.triangle = part.primitive;
    e.part = static_cast<std::int64_t>(p);
    e.emission = material.emission * e.opacity;
    if (is_black(e.emission)) continue;
    e.area = area_of(patches, e);
    const PatchEmitterPoint middle = sample_on_patch(patches, e, {0.5f, 0.5f});
    e.a = middle.point;
    e.normal = middle.normal;
    if (!(e.area > 0)) continue;  // its light is left to rays that hit it
    const TextureRef& ref = material.emission_texture;
    if (ref.is_set() && ref.uv_set == 0 &&
        !add_texture(ref, maps[ref.index], SubPatchRange(part), e, to.textures))
      continue;
    to.emitters.push_back(e);
    if (!material.is_double_sided) continue;
    e.is_back = true;
    e.normal = -e.normal;
    to.emitters.push_back(e);
  }
  return is_whole;
}

}  // namespace tessera::core
