#include "slave/core/render/surface.h"

#include <algorithm>
#include <array>
#include <cmath>

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

// Everything is a mean there, and products with what patterns multiply it by stay finite.
constexpr float kFootprintMax = 1e12f;

// A hit point of a triangle: what textures need of it.
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
  const Vec3f outward = s.is_front ? s.shading_normal : -s.shading_normal;
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
  const Vec3f seen = s.is_front ? turned : -turned;
  if (dot(seen, s.normal) > 0) s.shading_normal = seen;  // not so for NaN either
}

void apply_textures_at(const PreparedScene::Impl& scene, const Place& place, Vec3f to_surface,
                       Surface& s) {
  const float footprint = s.cone.width > 0 ? footprint_of(s, to_surface, s.cone) : 0;
  const TextureAt at = texture_at(place, footprint);
  if (s.material->normal_texture != kNoTexture) apply_normal_map(scene, *s.material, at, place, s);
  apply_textures(scene, *s.material, at, s);
}

}  // namespace

const Material& material_of(const PreparedScene::Impl& scene, std::uint32_t triangle) {
  const std::uint32_t instance = scene.triangles.instance_of(triangle);
  const auto& materials = scene.meshes[scene.instances[instance].mesh]->materials;
  return scene.materials[materials.size() == 1
                             ? materials[0]
                             : materials[triangle - scene.triangles.instance_first[instance]]];
}

SurfaceTriangle surface_triangle(const PreparedScene::Impl& scene, std::uint32_t triangle) {
  SurfaceTriangle t;
  t.number = triangle;
  const Vec3f a = scene.triangles.vertex(triangle, 0);
  t.edge_b = scene.triangles.vertex(triangle, 1) - a;
  t.edge_c = scene.triangles.vertex(triangle, 2) - a;
  t.twice_area = length(cross(t.edge_b, t.edge_c));
  t.instance = scene.triangles.instance_of(triangle);
  t.mesh = scene.meshes[scene.instances[t.instance].mesh].get();
  t.local = triangle - scene.triangles.instance_first[t.instance];
  if (!scene.features.has_programs) return t;
  const auto& corners = t.mesh->triangles[t.local];
  t.own_a = t.mesh->positions[corners[0]];
  t.own_b = t.mesh->positions[corners[1]] - t.own_a;
  t.own_c = t.mesh->positions[corners[2]] - t.own_a;
  t.own_normal = cross(t.own_b, t.own_c);
  t.shrunk = std::sqrt(length(t.own_normal) / t.twice_area);
  return t;
}

void enrich(const PreparedScene::Impl& scene, const SurfaceTriangle& t, const SurfaceHit& hit,
            Surface& s) {
  const Place place{t, t.mesh->triangles[t.local], hit.u, hit.v};
  if (scene.features.has_normals && !t.mesh->normals.empty()) {
    const Vec3f n = interpolated_normal(*t.mesh, place.triangle,
                                        scene.instances[t.instance].object_to_world, hit.u, hit.v);
    const float side = dot(n, s.normal);
    if (side > 0) s.shading_normal = n;
    if (side < 0) s.shading_normal = -n;  // NaN or zero: stays flat
  }
  if (!scene.features.is_diffuse()) {
    s.bsdf = s.material->bsdf;
    s.to_viewer = -normalize(hit.direction);
    s.roughness = s.material->roughness;
    s.metalness = s.material->metalness;
    s.instance = t.instance;
  }
  if (scene.features.needs_cones()) {
    s.cone = hit.cone;
    if (has_texture(*s.material) && !t.mesh->uvs.empty())
      apply_textures_at(scene, place, hit.direction, s);
  }
  // A normal that looks away from the viewer is none to reflect about.
  if (s.bsdf != BsdfKind::kDiffuse && !(dot(s.shading_normal, s.to_viewer) > 0))
    s.shading_normal = s.normal;
}

void add_place(const SurfaceTriangle& t, const SurfaceHit& hit, Surface& s, SurfacePlaces& places) {
  const auto i = static_cast<std::size_t>(places.count++);
  const Vec3f point = t.own_a + t.own_b * hit.u + t.own_c * hit.v;
  for (int a = 0; a < 3; ++a) {
    places.point[a][i] = point[a];
    places.normal[a][i] = t.own_normal[a];
  }
  const float footprint = s.cone.width > 0 ? footprint_of(s, hit.direction, s.cone) * t.shrunk : 0;
  // Bounded: edge-on it is infinite, and next to no size NaN.
  places.footprint[i] = footprint > 0 ? std::min(footprint, kFootprintMax) : 0;
  places.surface[i] = &s;
}

}  // namespace tessera::core
