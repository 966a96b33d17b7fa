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

// What shading of a texture or a program needs of a triangle: vertices before the transform.
struct Corners {
  Vec3f a, edge_b, edge_c;
  Vec3f normal;  // of twice the area
};

Corners corners_of(const Mesh& mesh, const std::array<std::uint32_t, 3>& triangle) {
  const Vec3f a = mesh.positions[triangle[0]];
  const Vec3f edge_b = mesh.positions[triangle[1]] - a, edge_c = mesh.positions[triangle[2]] - a;
  return {a, edge_b, edge_c, cross(edge_b, edge_c)};
}

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

TextureAt texture_at(const Mesh& mesh, const std::array<std::uint32_t, 3>& t, float u, float v,
                     float twice_area, float footprint) {
  const Vec2f p = corner(mesh.uvs, t, 0), q = corner(mesh.uvs, t, 1), r = corner(mesh.uvs, t, 2);
  const float uv_area = std::fabs((q.x - p.x) * (r.y - p.y) - (r.x - p.x) * (q.y - p.y));
  return {{p.x * (1 - u - v) + q.x * u + r.x * v, p.y * (1 - u - v) + q.y * u + r.y * v},
          footprint > 0 ? footprint * std::sqrt(uv_area / twice_area) : 0};
}

Vec3f sample_at(const MipMap& map, const TextureAt& at) {
  const float texels =
      static_cast<float>(map.base->width_px) * static_cast<float>(map.base->height_px);
  return sample_mip_map(map, at.uv, at.images * std::sqrt(texels));
}

void apply_textures(const PreparedScene::Impl& scene, const Material& material, const TextureAt& at,
                    Surface& s) {
  if (material.albedo_texture != kNoTexture)
    s.albedo = s.albedo * sample_at(scene.textures[material.albedo_texture], at);
  if (material.roughness_metalness_texture != kNoTexture) {
    const Vec3f factor = sample_at(scene.textures[material.roughness_metalness_texture], at);
    s.roughness *= factor.y;
    s.metalness *= factor.z;
  }
}

void apply_program(const Material& material, const Corners& c, float u, float v, float twice_area,
                   float footprint, Surface& s) {
  const float shrunk = length(c.normal) / twice_area;  // area before the transform to behind
  const SurfacePlace place{c.a + c.edge_b * u + c.edge_c * v, c.normal,
                           footprint > 0 ? footprint * std::sqrt(shrunk) : 0};
  apply_surface_program(material.surface, place, s);
}

void set_scattering(const Material& material, bool is_front, std::uint32_t instance,
                    Vec3f to_surface, Surface& s) {
  s.bsdf = material.bsdf;
  s.is_front = is_front;
  s.to_viewer = -normalize(to_surface);
  s.roughness = material.roughness;
  s.metalness = material.metalness;
  s.instance = instance;
  // An interpolated normal that looks away from the viewer is no normal to reflect about.
  if (s.bsdf != BsdfKind::kDiffuse && !(dot(s.shading_normal, s.to_viewer) > 0))
    s.shading_normal = s.normal;
}

}  // namespace

Surface surface_at(const PreparedScene::Impl& scene, std::uint32_t triangle, float u, float v,
                   Vec3f to_surface, RayCone cone) {
  const Vec3f a = scene.triangles.vertex(triangle, 0);
  const Vec3f edge_b = scene.triangles.vertex(triangle, 1) - a;
  const Vec3f edge_c = scene.triangles.vertex(triangle, 2) - a;
  Surface s;
  const Vec3f across = cross(edge_b, edge_c);
  s.normal = normalize(across);
  const bool is_front = dot(s.normal, to_surface) < 0;
  if (!is_front) s.normal = -s.normal;
  const SurfacePoint at = surface_point(a, edge_b, edge_c, s.normal, u, v);
  s.point = at.point;
  s.offset = at.offset;
  s.shading_normal = s.normal;

  const std::uint32_t number = scene.triangles.instance_of(triangle);
  const Instance& instance = scene.instances[number];
  const Mesh& mesh = *scene.meshes[instance.mesh];
  const std::size_t local = triangle - scene.triangles.instance_first[number];
  const Material& material =
      scene.materials[mesh.materials.size() == 1 ? mesh.materials[0] : mesh.materials[local]];
  s.material = &material;
  s.albedo = material.albedo;
  if (is_front) s.emission = material.emission;
  if (scene.features.has_normals && !mesh.normals.empty()) {
    const Vec3f n =
        interpolated_normal(mesh, mesh.triangles[local], instance.object_to_world, u, v);
    const float side = dot(n, s.normal);
    if (side > 0) s.shading_normal = n;
    if (side < 0) s.shading_normal = -n;  // NaN or zero: stays flat
  }
  if (!scene.features.is_diffuse()) set_scattering(material, is_front, number, to_surface, s);
  if (!scene.features.needs_cones()) return s;
  s.cone = cone;
  const float footprint = cone.width > 0 ? footprint_of(s, to_surface, cone) : 0;
  const auto& t = mesh.triangles[local];
  const bool is_textured =
      material.albedo_texture != kNoTexture || material.roughness_metalness_texture != kNoTexture;
  if (is_textured && !mesh.uvs.empty())
    apply_textures(scene, material, texture_at(mesh, t, u, v, length(across), footprint), s);
  if (material.surface.kind != SurfaceKind::kConstant)
    apply_program(material, corners_of(mesh, t), u, v, length(across), footprint, s);
  return s;
}

}  // namespace tessera::core
