#include "slave/core/render/surface.h"

#include <array>
#include <cmath>

#include "slave/core/geometry/surface_offset.h"
#include "slave/core/surface/programs.h"

namespace tessera::core {
namespace {

// One value per vertex, interpolated.
template <typename T>
T corner(const std::vector<T>& values, const std::array<std::uint32_t, 3>& triangle,
         std::size_t k) {
  return values[triangle[k]];
}

Vec3f interpolated_normal(const Mesh& mesh, const std::array<std::uint32_t, 3>& triangle,
                          const Transform& to_world, float u, float v) {
  const Vec3f local = corner(mesh.normals, triangle, 0) * (1 - u - v) +
                      corner(mesh.normals, triangle, 1) * u + corner(mesh.normals, triangle, 2) * v;
  return normalize(to_world.is_identity() ? local : to_world.normal(local));
}

// A hit point of a triangle: what textures and programs need of it.
struct Place {
  const SurfaceTriangle& of;
  const std::array<std::uint32_t, 3>& triangle;
  float u, v;
};

// How wide what the cone sees is on the surface, seen as it stands: the width over the cosine
// (Akenine-Moeller et al. 2021, section 3); infinite edge-on.
float footprint_of(const Surface& s, Vec3f to_surface, RayCone cone) {
  return cone.width * length(to_surface) / std::fabs(dot(s.normal, to_surface));
}

// Twice its area in texture coordinates over that in the world gives texels per length.
struct TextureAt {
  Vec2f uv;
  float images;  // how many images the footprint is wide, in a square one
};

TextureAt texture_at(const Place& at, float footprint) {
  const auto& [of, t, u, v] = at;
  const auto& uvs = of.mesh->uvs;
  const Vec2f p = corner(uvs, t, 0), q = corner(uvs, t, 1), r = corner(uvs, t, 2);
  const float uv_area = std::fabs((q.x - p.x) * (r.y - p.y) - (r.x - p.x) * (q.y - p.y));
  return {{p.x * (1 - u - v) + q.x * u + r.x * v, p.y * (1 - u - v) + q.y * u + r.y * v},
          footprint > 0 ? footprint * std::sqrt(uv_area / of.twice_area) : 0};
}

Vec3f sample_at(const MipMap& map, const TextureAt& at) {
  const float texels =
      static_cast<float>(map.base->width_px) * static_cast<float>(map.base->height_px);
  return sample_mip_map(map, at.uv, at.images * std::sqrt(texels));
}

void apply_textures(const PreparedScene::Impl& scene, const Material& material, const TextureAt& at,
                    Surface& s) {
  if (material.albedo_texture != kNoTexture)
    s.albedo = s.albedo * sample_at(*scene.textures[material.albedo_texture], at);
  if (material.emission_texture != kNoTexture && !is_black(s.emission))
    s.emission = s.emission * sample_at(*scene.textures[material.emission_texture], at);
  if (material.roughness_metalness_texture != kNoTexture) {
    const Vec3f factor = sample_at(*scene.textures[material.roughness_metalness_texture], at);
    s.roughness *= factor.y;
    s.metalness *= factor.z;
  }
}

// glTF 2.0, section 3.9.3. The tangent is that of the triangle, along which u rises and v does not,
// made perpendicular to the interpolated normal. One that would turn the surface away from the side
// that is seen, or of a triangle without area in the texture, stays as it was.
void apply_normal_map(const PreparedScene::Impl& scene, const Material& material,
                      const TextureAt& at, const Place& place, Surface& s) {
  const bool is_front = dot(s.normal, place.of.normal) > 0;
  const Vec3f outward = is_front ? s.shading_normal : -s.shading_normal;
  const auto& uvs = place.of.mesh->uvs;
  const auto uv_to = [&](std::size_t k) {
    const Vec2f from = corner(uvs, place.triangle, 0), to = corner(uvs, place.triangle, k);
    return Vec2f{to.x - from.x, to.y - from.y};
  };
  const Vec2f uv_b = uv_to(1), uv_c = uv_to(2);
  const float side = uv_b.x * uv_c.y < uv_c.x * uv_b.y ? -1.0f : 1.0f;
  const Vec3f along_u = (place.of.edge_b * uv_c.y - place.of.edge_c * uv_b.y) * side;
  const Vec3f along_v = (place.of.edge_c * uv_b.x - place.of.edge_b * uv_c.x) * side;
  const Vec3f tangent = normalize(along_u - outward * dot(outward, along_u));
  const Vec3f across = cross(outward, tangent);
  const Vec3f bitangent = across * (dot(across, along_v) < 0 ? -1.0f : 1.0f);
  const Vec3f t = sample_at(*scene.textures[material.normal_texture], at) * 2 - Vec3f{1, 1, 1};
  const Vec3f turned = normalize(tangent * (t.x * material.normal_scale) +
                                 bitangent * (t.y * material.normal_scale) + outward * t.z);
  const Vec3f seen = is_front ? turned : -turned;
  if (dot(seen, s.normal) > 0) s.shading_normal = seen;  // not so for NaN either
}

void apply_program(const Material& material, const Place& at, float footprint, Surface& s) {
  const auto& [of, t, u, v] = at;
  const Mesh& mesh = *of.mesh;
  // Vertices before the transform.
  const Vec3f a = mesh.positions[t[0]];
  const Vec3f b = mesh.positions[t[1]] - a, c = mesh.positions[t[2]] - a;
  const Vec3f normal = cross(b, c);
  const float shrunk = length(normal) / of.twice_area;  // area before the transform to behind
  const SurfacePlace place{a + b * u + c * v, normal,
                           footprint > 0 ? footprint * std::sqrt(shrunk) : 0};
  apply_surface_program(material.surface, place, s);
}

void apply_patterns(const PreparedScene::Impl& scene, const Place& place, Vec3f to_surface,
                    Surface& s) {
  const Material& material = *s.material;
  const float footprint = s.cone.width > 0 ? footprint_of(s, to_surface, s.cone) : 0;
  if (has_texture(material) && !place.of.mesh->uvs.empty()) {
    const TextureAt at = texture_at(place, footprint);
    if (material.normal_texture != kNoTexture) apply_normal_map(scene, material, at, place, s);
    apply_textures(scene, material, at, s);
  }
  if (material.surface.kind != SurfaceKind::kConstant) apply_program(material, place, footprint, s);
}

void set_scattering(const Material& material, bool is_front, std::uint32_t instance,
                    Vec3f to_surface, Surface& s) {
  s.bsdf = material.bsdf;
  s.is_front = is_front;
  s.to_viewer = -normalize(to_surface);
  s.roughness = material.roughness;
  s.metalness = material.metalness;
  s.instance = instance;
}

// All that a plain scene does not have. Apart, so that such a scene pays for one question.
[[gnu::noinline]] void enrich(const PreparedScene::Impl& scene, const Place& place,
                              Vec3f to_surface, bool is_front, RayCone cone, float hit_t,
                              Surface& s) {
  const SurfaceTriangle& t = place.of;
  if (scene.features.has_normals && !t.mesh->normals.empty()) {
    const Vec3f n = interpolated_normal(
        *t.mesh, place.triangle, scene.instances[t.instance].object_to_world, place.u, place.v);
    const float side = dot(n, s.normal);
    if (side > 0) s.shading_normal = n;
    if (side < 0) s.shading_normal = -n;  // NaN or zero: stays flat
  }
  if (!scene.features.is_diffuse())
    set_scattering(*t.material, is_front, t.instance, to_surface, s);
  if (scene.features.needs_cones()) {
    s.cone = cone.advanced(hit_t * length(to_surface));
    apply_patterns(scene, place, to_surface, s);
  }
  // A normal that looks away from the viewer is none to reflect about.
  if (s.bsdf != BsdfKind::kDiffuse && !(dot(s.shading_normal, s.to_viewer) > 0))
    s.shading_normal = s.normal;
}

}  // namespace

SurfaceTriangle surface_triangle(const PreparedScene::Impl& scene, std::uint32_t triangle) {
  SurfaceTriangle t;
  t.a = scene.triangles.vertex(triangle, 0);
  t.edge_b = scene.triangles.vertex(triangle, 1) - t.a;
  t.edge_c = scene.triangles.vertex(triangle, 2) - t.a;
  const Vec3f across = cross(t.edge_b, t.edge_c);
  t.normal = normalize(across);
  t.twice_area = length(across);
  t.instance = scene.triangles.instance_of(triangle);
  t.mesh = scene.meshes[scene.instances[t.instance].mesh].get();
  t.local = triangle - scene.triangles.instance_first[t.instance];
  const auto& materials = t.mesh->materials;
  t.material = &scene.materials[materials.size() == 1 ? materials[0] : materials[t.local]];
  return t;
}

Surface surface_at(const PreparedScene::Impl& scene, const SurfaceTriangle& t, float u, float v,
                   Vec3f to_surface, RayCone cone, float hit_t) {
  Surface s;
  const bool is_front = dot(t.normal, to_surface) < 0;
  s.normal = is_front ? t.normal : -t.normal;
  const SurfacePoint at = surface_point(t.a, t.edge_b, t.edge_c, s.normal, u, v);
  s.point = at.point;
  s.offset = at.offset;
  s.shading_normal = s.normal;
  s.material = t.material;
  s.albedo = t.material->albedo;
  if (is_front) s.emission = t.material->emission;
  if (scene.features.is_rich)
    enrich(scene, {t, t.mesh->triangles[t.local], u, v}, to_surface, is_front, cone, hit_t, s);
  return s;
}

}  // namespace tessera::core
