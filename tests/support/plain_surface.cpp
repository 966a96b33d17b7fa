// SPDX-License-Identifier: Apache-2.0
#include "tests/support/plain_surface.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "slave/core/surface/texture.h"

namespace tessera::test {
namespace {

using core::Surface;

struct Triangle {
  std::uint32_t number = 0;
  Vec3f edge_b, edge_c;  // B - A, C - A, world units
  const Instance* instance = nullptr;
  const Mesh* mesh = nullptr;
  std::size_t local = 0;  // of the mesh
  float u = 0, v = 0;     // the place
};

std::uint32_t vertex_of(const Triangle& t, std::size_t k) { return t.mesh->triangles[t.local][k]; }

Vec3f mixed(Vec3f a, Vec3f b, Vec3f c, const Triangle& t) {
  return a * (1 - t.u - t.v) + b * t.u + c * t.v;
}

Triangle triangle_at(const core::PreparedScene::Impl& scene, std::uint32_t number, float u,
                     float v) {
  const std::uint32_t instance = scene.triangles.instance_of(number);
  const Vec3f a = scene.triangles.vertex(number, 0);
  return {number,
          scene.triangles.vertex(number, 1) - a,
          scene.triangles.vertex(number, 2) - a,
          &scene.instances[instance],
          scene.meshes[scene.instances[instance].mesh].get(),
          number - scene.triangles.instance_first[instance],
          u,
          v};
}

const Material& material_of(const core::PreparedScene::Impl& scene, const Triangle& t) {
  const auto& materials = t.mesh->materials;
  return scene.materials[materials.size() == 1 ? materials[0] : materials[t.local]];
}

void interpolate_normal(const Triangle& t, Surface& s) {
  const auto normal = [&](std::size_t k) { return t.mesh->normals[vertex_of(t, k)]; };
  const Vec3f local = mixed(normal(0), normal(1), normal(2), t);
  const Transform& to_world = t.instance->object_to_world;
  const Vec3f n = normalize(to_world.is_identity() ? local : to_world.normal(local));
  const float side = dot(n, s.normal);
  if (side > 0) s.shading_normal = n;
  if (side < 0) s.shading_normal = -n;  // NaN or zero: stays flat
}

// Width of the footprint: that of the cone over the cosine (Akenine-Moeller et al. 2021, section
// 3).
float footprint_of(const Surface& s, Vec3f direction) {
  if (!(s.cone.width > 0)) return 0;
  return s.cone.width * length(direction) / std::fabs(dot(s.normal, direction));
}

float twice_area_of(const Triangle& t) { return length(cross(t.edge_b, t.edge_c)); }

struct Uvs {
  Vec2f at, along_b, along_c;
};

// Texture coordinates of the picture, and their differences along the edges.
Uvs uvs_of(const Triangle& t, const TextureRef& ref) {
  const auto& of_mesh = ref.uv_set == 0 ? t.mesh->uvs : t.mesh->uvs1;
  const auto& m = ref.uv_map;
  const auto uv = [&](std::size_t k) {
    const Vec2f c = of_mesh[vertex_of(t, k)];
    if (m == std::array<float, 6>{1, 0, 0, 0, 1, 0}) return c;
    return Vec2f{m[0] * c.x + m[1] * c.y + m[2], m[3] * c.x + m[4] * c.y + m[5]};
  };
  const Vec2f p = uv(0), q = uv(1), r = uv(2);
  const Vec3f at = mixed({p.x, p.y, 0}, {q.x, q.y, 0}, {r.x, r.y, 0}, t);
  return {{at.x, at.y}, {q.x - p.x, q.y - p.y}, {r.x - p.x, r.y - p.y}};
}

// Normal mapping as in glTF 2.0, section 3.9.3.
void turn_normal(const Triangle& t, const Uvs& uvs, Vec3f texel, float scale, Surface& s) {
  const Vec3f outward = s.is_front ? s.shading_normal : -s.shading_normal;
  const Vec2f b = uvs.along_b, c = uvs.along_c;
  const float side = b.x * c.y < c.x * b.y ? -1.0f : 1.0f;
  const Vec3f along_u = (t.edge_b * c.y - t.edge_c * b.y) * side;
  const Vec3f along_v = (t.edge_c * b.x - t.edge_b * c.x) * side;
  const Vec3f tangent = normalize(along_u - outward * dot(outward, along_u));
  const Vec3f across = cross(outward, tangent);
  const Vec3f bitangent = across * (dot(across, along_v) < 0 ? -1.0f : 1.0f);
  const Vec3f v = texel * 2 - Vec3f{1, 1, 1};
  const Vec3f turned =
      normalize(tangent * (v.x * scale) + bitangent * (v.y * scale) + outward * v.z);
  const Vec3f seen = s.is_front ? turned : -turned;
  if (dot(seen, s.normal) > 0) s.shading_normal = seen;
}

void apply_textures(const core::PreparedScene::Impl& scene, const Triangle& t, Vec3f direction,
                    Surface& s) {
  const Material& m = *s.material;
  const float footprint = footprint_of(s, direction);
  const auto is_shown = [&](const TextureRef& ref) {
    return ref.is_set() && !(ref.uv_set == 0 ? t.mesh->uvs : t.mesh->uvs1).empty();
  };
  const auto look_up = [&](const TextureRef& ref) {
    const Uvs uvs = uvs_of(t, ref);
    const float uv_area = std::fabs(uvs.along_b.x * uvs.along_c.y - uvs.along_c.x * uvs.along_b.y);
    const float images = footprint > 0 ? footprint * std::sqrt(uv_area / twice_area_of(t)) : 0;
    const core::MipMap& map = *scene.textures[ref.index];
    const float texels =
        static_cast<float>(map.base->width_px) * static_cast<float>(map.base->height_px);
    return plain_mip_map_sample(map, uvs.at, images * std::sqrt(texels));
  };
  if (is_shown(m.normal_texture))
    turn_normal(t, uvs_of(t, m.normal_texture), look_up(m.normal_texture), m.normal_scale, s);
  if (is_shown(m.albedo_texture)) s.albedo = s.albedo * look_up(m.albedo_texture);
  if (is_shown(m.emission_texture)) s.emission = s.emission * look_up(m.emission_texture);
  if (!is_shown(m.roughness_metalness_texture)) return;
  const Vec3f factor = look_up(m.roughness_metalness_texture);
  s.roughness *= factor.y;
  s.metalness *= factor.z;
}

void apply_program(const Triangle& t, Vec3f direction, Surface& s) {
  const auto position = [&](std::size_t k) { return t.mesh->positions[vertex_of(t, k)]; };
  const Vec3f a = position(0), b = position(1) - a, c = position(2) - a;
  const Vec3f point = a + b * t.u + c * t.v, normal = cross(b, c);
  const float shrunk = std::sqrt(length(normal) / twice_area_of(t));
  const float seen = footprint_of(s, direction) * shrunk;
  const float footprint = seen > 0 ? std::min(seen, 1e12f) : 0;
  Surface* const surface = &s;
  const auto axes = [](const Vec3f& p) {
    return core::SurfacePlaces::Axes{{{&p.x, 1}, {&p.y, 1}, {&p.z, 1}}};
  };
  core::apply_surface_program(s.material->surface,
                              core::Noise(core::kernels_for(Isa::kScalar).noise),
                              {axes(point), axes(normal), {&footprint, 1}, {&surface, 1}});
}

}  // namespace

PlainPoint plain_point(const core::TriangleStore& triangles, std::uint32_t triangle, float u,
                       float v, Vec3f direction) {
  const Vec3f a = triangles.vertex(triangle, 0);
  const Vec3f b = triangles.vertex(triangle, 1) - a, c = triangles.vertex(triangle, 2) - a;
  const Vec3f outward = normalize(cross(b, c));
  const bool is_front = dot(outward, direction) < 0;
  const Vec3f normal = is_front ? outward : -outward;
  return {core::surface_point(a, b, c, normal, u, v), normal, is_front};
}

Vec3f plain_mip_map_sample(const core::MipMap& map, Vec2f uv, float texels) {
  if (texels <= 1 || map.levels.empty()) return core::sample_texture(*map.base, uv);
  const int last = static_cast<int>(map.levels.size());
  const auto level = [&](int i) -> const Texture& {
    return i == 0 ? *map.base : map.levels[static_cast<std::size_t>(i - 1)];
  };
  if (!(texels < static_cast<float>(1 << last))) return core::sample_texture(level(last), uv);
  int exponent = 0;
  const float mantissa = std::frexp(texels, &exponent);  // texels = mantissa 2^exponent
  const int lower = exponent - 1;
  const float weight = 2 * mantissa - 1;
  return core::sample_texture(level(lower), uv) * (1 - weight) +
         core::sample_texture(level(lower + 1), uv) * weight;
}

core::Surface plain_surface(const core::PreparedScene::Impl& scene, std::uint32_t triangle, float u,
                            float v, Vec3f direction, core::RayCone cone) {
  const PlainPoint plain = plain_point(scene.triangles, triangle, u, v, direction);
  const Triangle t = triangle_at(scene, triangle, u, v);
  const Material& m = material_of(scene, t);
  Surface s;
  s.point = plain.at.point;
  s.offset = plain.at.offset;
  s.normal = s.shading_normal = plain.normal;
  s.material = &m;
  s.albedo = m.albedo;
  s.is_front = plain.is_front;
  if (s.is_front) s.emission = m.emission;
  if (!scene.features.is_diffuse()) {
    s.bsdf = m.bsdf;
    s.roughness = m.roughness;
    s.metalness = m.metalness;
    s.instance = scene.triangles.instance_of(triangle);
  }
  if (scene.features.has_normals && !t.mesh->normals.empty()) interpolate_normal(t, s);
  if (scene.features.needs_cones()) s.cone = cone;
  if (core::has_texture(m)) apply_textures(scene, t, direction, s);
  if (s.bsdf != BsdfKind::kDiffuse) {
    s.to_viewer = -normalize(direction);
    if (!(dot(s.shading_normal, s.to_viewer) > 0)) s.shading_normal = s.normal;
  }
  if (m.surface.kind != SurfaceKind::kConstant) apply_program(t, direction, s);
  return s;
}

}  // namespace tessera::test
