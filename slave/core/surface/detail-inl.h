// SPDX-License-Identifier: Apache-2.0
// Surface detail of many points: normals of vertices and of maps, textures, footprints, and what
// programs ask for (see detail_layout.h).
//
// Threads. Works on the caller's memory.
#include "slave/core/surface/detail_layout.h"

#if defined(TESSERA_CORE_DETAIL_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef TESSERA_CORE_DETAIL_INL_H_
#undef TESSERA_CORE_DETAIL_INL_H_
#else
#define TESSERA_CORE_DETAIL_INL_H_
#endif

#include "slave/core/surface/texture-inl.h"

HWY_BEFORE_NAMESPACE();
namespace tessera::core {
namespace HWY_NAMESPACE {

class DetailKernel {
  using V = Floats;
  using V3 = Vec3<V>;

 public:
  DetailKernel(const DetailGroup& group, DetailPoints& points) : group_(group), p_(points) {}

  void run() {
    const auto count = static_cast<size_t>(p_.count);
    for (size_t at = 0; at < count; at += kLaneCount)
      detail(at, count - at < kLaneCount ? count - at : kLaneCount);
  }

 private:
  // Texture coordinates.
  struct Uv {
    V x, y;
  };
  static HWY_INLINE Uv minus(Uv a, Uv b) { return {a.x - b.x, a.y - b.y}; }

  // Greatest footprint: programs show nothing but means there, and its products with the factors of
  // patterns stay finite.
  static constexpr float kFootprintMax = 1e12f;

  HWY_INLINE void detail(size_t at, size_t lanes) {
    const V3 normal = load3<V>(p_.normal, at), direction = load3<V>(p_.direction, at);
    V3 shading = normal;
    if (group_.has_normals) shading = interpolated(at, normal);
    V3 coat = shading;
    if (group_.uses != 0 || group_.has_program || group_.is_stretched) {
      const V3 a = load3<V>(p_.corner[0], at);
      const V3 b = load3<V>(p_.corner[1], at) - a, c = load3<V>(p_.corner[2], at) - a;
      const V twice_area = length(cross(b, c)), footprint = footprint_at(at, normal, direction);
      const Textured points{at, lanes, b, c, twice_area, footprint, normal};
      if (group_.uses != 0) textures(points, shading, coat);
      if (group_.is_stretched) stretch(points, shading);
      if (group_.has_program) place(at, twice_area, footprint);
    }
    if (!group_.is_diffuse) {
      const V3 back = normalize(direction);
      const V3 to_viewer = -back;
      store3(to_viewer, p_.to_viewer, at);
      // A normal that looks away from the viewer cannot serve for reflection.
      shading = select(dot(shading, to_viewer) > 0, shading, normal);
      if (group_.has_coat) {
        coat = select(dot(coat, to_viewer) > 0, coat, normal);
        store3(coat, p_.coat_normal, at);
      }
    }
    store3(shading, p_.shading_normal, at);
  }

  HWY_INLINE V weight_a(size_t at) const { return 1 - load<V>(p_.u + at) - load<V>(p_.v + at); }

  // The interpolated normal, turned to the side of the geometric normal; the geometric normal where
  // the side cannot be told.
  HWY_INLINE V3 interpolated(size_t at, V3 normal) const {
    const auto& corner = p_.corner_normal;
    V3 own = load3<V>(corner[0], at) * weight_a(at) + load3<V>(corner[1], at) * load<V>(p_.u + at) +
             load3<V>(corner[2], at) * load<V>(p_.v + at);
    if (group_.is_moved) {
      own = {dot(same3<V>(group_.normal_map[0]), own), dot(same3<V>(group_.normal_map[1]), own),
             dot(same3<V>(group_.normal_map[2]), own)};
    }
    const V3 n = normalize(own);
    const V side = dot(n, normal);
    const V3 turned = negated_if(side < 0, n);
    return select(abs(side) > 0, turned, normal);  // false for NaN
  }

  // Width of the footprint of the cone on the surface: its width over the cosine (Akenine-Moeller
  // et al. 2021, section 3); infinite edge-on, 0 for a ray without a cone.
  HWY_INLINE V footprint_at(size_t at, V3 normal, V3 direction) const {
    const V width = load<V>(p_.cone_width + at);
    const V seen = width * length(direction) / abs(dot(normal, direction));
    return zero_unless(width > 0, seen);
  }

  // A register of points with textures.
  struct Textured {
    size_t at, lanes;
    V3 b, c;  // edges from A
    V twice_area, footprint;
    V3 normal;
  };

  HWY_INLINE void textures(const Textured& points, V3& shading, V3& coat) {
    const TextureTable& table = *group_.textures;
    for (int32_t k = 0; k < table.place_count; ++k) {
      const uint32_t uses = table.place[k].uses & group_.uses;
      if (uses != 0) look_up(table.place[k], uses, points, shading, coat);
    }
  }

  // Texture coordinates of a corner, for pictures that lie at `place`.
  HWY_INLINE Uv corner_uv(const TexturePlace& place, size_t k, size_t at) const {
    const auto& uv = p_.corner_uv[place.uv_set][k];
    const Uv of_mesh{load<V>(uv[0] + at), load<V>(uv[1] + at)};
    if (!place.is_moved) return of_mesh;
    const auto row = [&](const float* m) { return m[0] * of_mesh.x + m[1] * of_mesh.y + m[2]; };
    return {row(place.uv_map), row(place.uv_map + 3)};
  }

  // Looks up all textures that lie alike. The picture's area over the triangle's gives images per
  // length.
  HWY_INLINE void look_up(const TexturePlace& place, uint32_t uses, const Textured& points,
                          V3& shading, V3& coat) {
    const size_t at = points.at;
    const V u = load<V>(p_.u + at), v = load<V>(p_.v + at), w = weight_a(at);
    const Uv p = corner_uv(place, 0, at), q = corner_uv(place, 1, at), r = corner_uv(place, 2, at);
    const Uv uv_b = minus(q, p), uv_c = minus(r, p);
    const V uv_area = abs(uv_b.x * uv_c.y - uv_c.x * uv_b.y);
    const V images = points.footprint * sqrt(uv_area / points.twice_area);
    const auto inside = [&](V of_p, V of_q, V of_r) { return of_p * w + of_q * u + of_r * v; };
    const auto has_cone = points.footprint > 0;
    const TextureLookup lookup(inside(p.x, q.x, r.x), inside(p.y, q.y, r.y),
                               zero_unless(has_cone, images), points.lanes);
    for (; uses != 0; uses &= uses - 1) {
      const int use = __builtin_ctz(uses);
      const TextureView& texture = *group_.textures->texture[use];
      if (kUsesWithAlpha >> use & 1u) {
        const auto texel = lookup.template sample<4>(texture);
        store3(texel.rgb(), p_.texel[use], at);
        store(texel.channel[3], p_.texel_alpha[use] + at);
        continue;
      }
      const V3 texel = lookup.template sample<3>(texture).rgb();
      if (use != kNormalTexture && use != kClearcoatNormalTexture) {
        store3(texel, p_.texel[use], at);
        continue;
      }
      V3& turned = use == kNormalTexture ? shading : coat;
      const float scale = use == kNormalTexture ? group_.normal_scale : group_.coat_normal_scale;
      const V3 outward = outward_of(at, turned);
      const Tangents tangents = group_.has_tangents
                                    ? tangents_of_vertices(at, outward)
                                    : tangents_of_triangle(points, uv_b, uv_c, outward);
      turned = mapped(at, texel, tangents, {scale, points.normal, turned});
    }
  }

  // Unit vectors, perpendicular to each other and the outward normal.
  struct Tangents {
    V3 tangent, bitangent;
  };

  HWY_INLINE V3 outward_of(size_t at, V3 shading) const {
    return negated_if(mask_of<V>(static_cast<uint32_t>(~p_.front >> at)), shading);
  }

  // The tangent is the direction along which u rises and v does not. A triangle without area in the
  // texture has none; the result is then not finite, or zero.
  HWY_INLINE Tangents tangents_of_triangle(const Textured& points, Uv uv_b, Uv uv_c,
                                           V3 outward) const {
    const auto is_mirrored = uv_b.x * uv_c.y < uv_c.x * uv_b.y;
    const V3 along_u = negated_if(is_mirrored, points.b * uv_c.y - points.c * uv_b.y);
    const V3 along_v = negated_if(is_mirrored, points.c * uv_b.x - points.b * uv_c.x);
    const V3 tangent = normalize(along_u - outward * dot(outward, along_u));
    const V3 across = cross(outward, tangent);
    return {tangent, negated_if(dot(across, along_v) < 0, across)};
  }

  // Tangents as MikkTSpace means them (Mikkelsen, "Simulation of wrinkled surfaces revisited",
  // 2008): the tangent is interpolated, and the bitangent follows from it and the outward normal.
  // In a mirrored instance both directions are mirrored, and the outward normal is the transformed
  // triangle's: the product stays on its side.
  HWY_INLINE Tangents tangents_of_vertices(size_t at, V3 outward) const {
    const auto& corner = p_.corner_tangent;
    V3 own = load3<V>(corner[0], at) * weight_a(at) + load3<V>(corner[1], at) * load<V>(p_.u + at) +
             load3<V>(corner[2], at) * load<V>(p_.v + at);
    if (group_.is_moved) {
      own = {dot(same3<V>(group_.tangent_map[0]), own), dot(same3<V>(group_.tangent_map[1]), own),
             dot(same3<V>(group_.tangent_map[2]), own)};
    }
    const V3 tangent = normalize(own - outward * dot(outward, own));
    return {tangent, cross(outward, tangent) * load<V>(p_.handedness + at)};
  }

  HWY_INLINE void stretch(const Textured& points, V3 shading) {
    const size_t at = points.at;
    const V3 outward = outward_of(at, shading);
    Tangents t;
    if (group_.has_tangents) {
      t = tangents_of_vertices(at, outward);
    } else {
      const auto& uv = p_.corner_uv[0];
      const auto of = [&](size_t k) { return Uv{load<V>(uv[k][0] + at), load<V>(uv[k][1] + at)}; };
      t = tangents_of_triangle(points, minus(of(1), of(0)), minus(of(2), of(0)), outward);
    }
    store3(t.tangent, p_.along_u, at);
    store3(t.bitangent, p_.along_v, at);
  }

  struct Turned {
    float scale;
    V3 normal, shading;
  };

  // Normal mapping as in glTF 2.0, section 3.9.3. A normal stays as it was where it would turn the
  // surface away from the side that is seen, or where there is no tangent.
  HWY_INLINE V3 mapped(size_t at, V3 texel, const Tangents& of, const Turned& from) const {
    const V3 outward = outward_of(at, from.shading);
    const V3 t{texel.x + texel.x - 1, texel.y + texel.y - 1, texel.z + texel.z - 1};
    const V3 turned = normalize(of.tangent * (t.x * from.scale) +
                                of.bitangent * (t.y * from.scale) + outward * t.z);
    const V3 seen = outward_of(at, turned);
    // The comparison is false for NaN, too.
    return select(dot(seen, from.normal) > 0, seen, from.shading);
  }

  // Finds the place and the footprint that the program is told, in the object's space.
  HWY_INLINE void place(size_t at, V twice_area, V footprint) {
    const V3 a = load3<V>(p_.corner_of_mesh[0], at);
    const V3 b = load3<V>(p_.corner_of_mesh[1], at) - a, c = load3<V>(p_.corner_of_mesh[2], at) - a;
    const V3 across = cross(b, c);
    store3(a + b * load<V>(p_.u + at) + c * load<V>(p_.v + at), p_.place, at);
    store3(across, p_.place_normal, at);
    const V shrunk = sqrt(length(across) / twice_area);
    const V own = footprint * shrunk;
    // The footprint is bounded: edge-on it is infinite, and at next to no size NaN.
    const V kept = zero_unless(own > 0, min(own, kFootprintMax));
    store(kept, p_.footprint + at);
  }

  const DetailGroup& group_;
  DetailPoints& p_;
};

}  // namespace HWY_NAMESPACE
}  // namespace tessera::core
HWY_AFTER_NAMESPACE();

#endif  // per-target include guard
