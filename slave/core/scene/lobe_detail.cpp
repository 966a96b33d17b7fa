// SPDX-License-Identifier: Apache-2.0
#include "slave/core/scene/lobe_detail.h"

#include <cmath>

#include "slave/core/sampling/hemisphere.h"
#include "slave/core/simd/axis_arrays.h"

namespace tessera::core {
namespace {

class LobeDetail {
 public:
  LobeDetail(const Surface& s, const DetailGroup& group, const DetailPoints& points, int i)
      : surface_(s), material_(*s.material), group_(group), points_(points), i_(i) {}

  SurfaceLobes lobes() const {
    SurfaceLobes lobes;
    const float weight = alpha_of(kSpecularTexture);
    lobes.specular = material_.specular * texel_of(kSpecularColorTexture) * weight;
    lobes.specular_f90 = material_.specular_f90 * weight;
    put_coat(lobes);
    lobes.sheen = material_.sheen.color * texel_of(kSheenColorTexture);
    lobes.sheen_roughness = material_.sheen.roughness * alpha_of(kSheenRoughnessTexture);
    if (group_.is_stretched) put_stretch(lobes);
    return lobes;
  }

  float transmission() const {
    return material_.transmission.weight * texel_of(kTransmissionTexture).x;
  }

 private:
  bool has(TextureUse use) const { return (group_.uses >> use & 1u) != 0; }
  Vec3f texel_of(TextureUse use) const {
    return has(use) ? vector_at(points_.texel[use], i_) : Vec3f{1, 1, 1};
  }
  float alpha_of(TextureUse use) const { return has(use) ? points_.texel_alpha[use][i_] : 1; }

  void put_coat(SurfaceLobes& lobes) const {
    lobes.coat_normal = surface_.shading_normal;
    if (!group_.has_coat) return;
    const Clearcoat& coat = material_.clearcoat;
    lobes.coat = coat.weight * texel_of(kClearcoatTexture).x;
    lobes.coat_roughness = coat.roughness * texel_of(kClearcoatRoughnessTexture).y;
    lobes.coat_normal = vector_at(points_.coat_normal, i_);
  }

  // The texture turns the direction, then `rotation` does.
  void put_stretch(SurfaceLobes& lobes) const {
    const Anisotropy& a = material_.anisotropy;
    const Vec3f along_u = vector_at(points_.along_u, i_), along_v = vector_at(points_.along_v, i_);
    Vec2f way{1, 0};
    float strength = a.strength;
    if (has(kAnisotropyTexture)) {
      const Vec3f texel = texel_of(kAnisotropyTexture);
      way = {2 * texel.x - 1, 2 * texel.y - 1};
      strength *= texel.z;
    }
    constexpr float kTurn = 6.28318531f;
    const float turns = a.rotation / kTurn;
    const SinCos t = sin_cos_whole_turn(turns - std::floor(turns));
    const Vec2f turned{way.x * t.cos - way.y * t.sin, way.x * t.sin + way.y * t.cos};
    const Vec3f tangent = normalize(along_u * turned.x + along_v * turned.y);
    // A triangle without area in the texture has no such direction.
    if (!is_finite(tangent) || is_black(tangent)) return;
    lobes.stretch = strength;
    lobes.tangent = tangent;
  }

  const Surface& surface_;
  const Material& material_;
  const DetailGroup& group_;
  const DetailPoints& points_;
  const int i_;
};

}  // namespace

SurfaceLobes lobes_of(const Surface& s, const DetailGroup& group, const DetailPoints& points,
                      int i) {
  return LobeDetail(s, group, points, i).lobes();
}

float transmission_of(const Surface& s, const DetailGroup& group, const DetailPoints& points,
                      int i) {
  return LobeDetail(s, group, points, i).transmission();
}

}  // namespace tessera::core
