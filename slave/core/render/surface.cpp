#include "slave/core/render/surface.h"

#include <array>
#include <cmath>

#include "slave/core/geometry/surface_offset.h"

namespace tessera::core {
namespace {

// sRGB byte to linear, IEC 61966-2-1. From double, so that the floats do not depend on the
// processor.
std::array<float, 256> make_srgb_table() {
  std::array<float, 256> table{};
  for (std::size_t i = 0; i < table.size(); ++i) {
    const double e = static_cast<double>(i) / 255;
    table[i] = static_cast<float>(e <= 0.04045 ? e / 12.92 : std::pow((e + 0.055) / 1.055, 2.4));
  }
  return table;
}

Vec3f texel(const Texture& texture, int x, int y) {
  static const std::array<float, 256> kLinear = make_srgb_table();
  const std::size_t index =
      4 * (static_cast<std::size_t>(y) * static_cast<std::size_t>(texture.width_px) +
           static_cast<std::size_t>(x));
  const std::uint8_t* p = texture.rgba.data() + index;
  if (texture.is_srgb) return {kLinear[p[0]], kLinear[p[1]], kLinear[p[2]]};
  return Vec3f{static_cast<float>(p[0]), static_cast<float>(p[1]), static_cast<float>(p[2])} *
         (1 / 255.0f);
}

// The two texels of one axis around coordinate c (in images) and the weight of the second.
struct Taps {
  int first, second;
  float weight;
};

Taps taps_of(float c, int size) {
  const float wrapped = c - std::floor(c);  // in [0, 1]; 1 by rounding of tiny negatives
  const float at = wrapped * static_cast<float>(size) - 0.5f;
  const float base = std::floor(at);
  const int first = static_cast<int>(base);  // -1 .. size
  return {(first + size) % size, (first + 1 + size) % size, at - base};
}

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

}  // namespace

Vec3f sample_texture(const Texture& texture, Vec2f uv) {
  const Taps x = taps_of(uv.x, texture.width_px), y = taps_of(1 - uv.y, texture.height_px);
  const Vec3f top = texel(texture, x.first, y.first) * (1 - x.weight) +
                    texel(texture, x.second, y.first) * x.weight;
  const Vec3f bottom = texel(texture, x.first, y.second) * (1 - x.weight) +
                       texel(texture, x.second, y.second) * x.weight;
  return top * (1 - y.weight) + bottom * y.weight;
}

Surface surface_at(const PreparedScene::Impl& scene, std::uint32_t triangle, float u, float v,
                   Vec3f to_surface) {
  const Vec3f a = scene.triangles.vertex(triangle, 0);
  const Vec3f edge_b = scene.triangles.vertex(triangle, 1) - a;
  const Vec3f edge_c = scene.triangles.vertex(triangle, 2) - a;
  Surface s;
  s.normal = normalize(cross(edge_b, edge_c));
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
  s.material = mesh.materials.size() == 1 ? mesh.materials[0] : mesh.materials[local];
  const Material& material = scene.materials[s.material];
  s.albedo = material.albedo;
  if (is_front) s.emission = material.emission;
  if (scene.features.has_normals && !mesh.normals.empty()) {
    const Vec3f n =
        interpolated_normal(mesh, mesh.triangles[local], instance.object_to_world, u, v);
    const float side = dot(n, s.normal);
    if (side > 0) s.shading_normal = n;
    if (side < 0) s.shading_normal = -n;  // NaN or zero: stays flat
  }
  if (scene.features.has_textures && material.albedo_texture != kNoTexture && !mesh.uvs.empty()) {
    const auto& t = mesh.triangles[local];
    const Vec2f p = corner(mesh.uvs, t, 0), q = corner(mesh.uvs, t, 1), r = corner(mesh.uvs, t, 2);
    const Vec2f uv{p.x * (1 - u - v) + q.x * u + r.x * v, p.y * (1 - u - v) + q.y * u + r.y * v};
    s.albedo = s.albedo * sample_texture(*scene.textures[material.albedo_texture], uv);
  }
  return s;
}

}  // namespace tessera::core
