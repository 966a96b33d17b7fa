// SPDX-License-Identifier: Apache-2.0
#include "slave/core/scene/surface_detail.h"

#include <algorithm>
#include <array>
#include <bit>
#include <span>

#include "slave/core/bsdf/transmission.h"
#include "slave/core/primitive/freeform/patch_point.h"
#include "slave/core/ray/ray_bits.h"
#include "slave/core/sampling/sample_sequence.h"
#include "slave/core/scene/lobe_detail.h"
#include "slave/core/simd/axis_arrays.h"
#include "slave/core/surface/programs.h"

namespace tessera::core {
namespace {

static_assert(kDetailPoints >= kPacketRays && kDetailPoints <= kPlacesMax);

bool is_needed(const DetailGroup& g) {
  return g.has_normals || g.has_colors || g.uses != 0 || g.has_program || !g.is_diffuse;
}

void set_maps(const Transform& to_world, DetailGroup& group) {
  group.is_moved = !to_world.is_identity();
  if (!group.is_moved) return;
  const std::array<Vec3f, 3> rows = to_world.cofactors();
  for (std::size_t row = 0; row < 3; ++row) {
    for (int column = 0; column < 3; ++column) group.normal_map[row][column] = rows[row][column];
    std::copy_n(to_world.m[row].begin(), 3, group.tangent_map[row]);
  }
}

// The point that a transform brings to `at`; where it has no inverse, `at` itself.
Vec3f before(const Transform& to_world, Vec3f at) {
  if (to_world.is_identity()) return at;
  const std::array<Vec3f, 3> c = to_world.cofactors();
  const auto& m = to_world.m;
  const Vec3f from{at.x - m[0][3], at.y - m[1][3], at.z - m[2][3]};
  const float volume = m[0][0] * c[0].x + m[0][1] * c[0].y + m[0][2] * c[0].z;
  if (volume == 0) return at;
  return (c[0] * from.x + c[1] * from.y + c[2] * from.z) * (1 / volume);
}

constexpr std::uint32_t kNormalUses = 1u << kNormalTexture | 1u << kClearcoatNormalTexture;

// Random number in [0, 1) of a ray where it meets a triangle.
float chance_of(Vec3f direction, Vec3f point, std::uint32_t triangle) {
  std::uint32_t key = mix_bits(triangle);
  for (int a = 0; a < 3; ++a) {
    key = hash_combine(key, std::bit_cast<std::uint32_t>(direction[a]));
    key = hash_combine(key, std::bit_cast<std::uint32_t>(point[a]));
  }
  return unit_float(key);
}

void put_uv(Vec2f uv, float (&to)[2][kDetailPoints], int i) {
  to[0][i] = uv.x;
  to[1][i] = uv.y;
}

}  // namespace

void SurfaceDetail::add(const Hits& hits, std::uint64_t rays, const RayCone* cones,
                        Surface* const* to, SurfaceBatch* batch) {
  const auto& instance = hits.instance;
  const bool is_diffuse = scene_.features.is_diffuse();
  const bool has_cones = cones != nullptr && scene_.features.needs_cones();
  for_each_ray(rays, [&](int ray) {
    Surface& s = *to[ray];
    if (has_cones) s.cone = cones[ray].advanced(hits.points.distance[ray]);
    if (is_diffuse) return;
    s.bsdf = s.material->bsdf;
    s.roughness = s.material->roughness;
    s.metalness = s.material->metalness;
    s.instance = instance[ray];
  });
  while (rays != 0) {
    const int first = std::countr_zero(rays);
    const Material* const material = to[first]->material;
    std::uint64_t group = 0;
    for_each_ray(rays, [&](int ray) {
      if (instance[ray] == instance[first] && to[ray]->material == material)
        group |= std::uint64_t{1} << ray;
    });
    rays &= ~group;
    const DetailGroup shared = group_of(instance[first], *material);
    if (is_needed(shared)) add_group(shared, hits, group, to, batch);
  }
}

DetailGroup SurfaceDetail::group_of(std::uint32_t instance, const Material& material) const {
  const Mesh& mesh = mesh_of(instance);
  DetailGroup group{};
  group.is_diffuse = scattering_of(material.bsdf) == Scattering::kEven;
  group.has_program = material.surface.kind != SurfaceKind::kConstant;
  group.has_normals = scene_.features.has_normals && !mesh.normals.empty();
  if (group.has_normals) set_maps(scene_.instances[instance].object_to_world, group);
  if (scene_.features.has_lobes) {
    group.has_coat = has_coat(material);
    group.coat_normal_scale = material.clearcoat.normal_scale;
    group.is_stretched = is_stretched(material) && !(mesh.uvs.empty() && mesh.tangents.empty());
  }
  group.has_colors = scene_.features.has_colors && !mesh.colors.empty();
  if (scene_.features.has_textures) put_textures(material, mesh, group);
  group.has_tangents =
      !mesh.tangents.empty() && ((group.uses & kNormalUses) != 0 || group.is_stretched);
  if (group.has_tangents) set_maps(scene_.instances[instance].object_to_world, group);
  return group;
}

void SurfaceDetail::put_textures(const Material& material, const Mesh& mesh,
                                 DetailGroup& group) const {
  group.textures = &scene_.texture_tables[static_cast<std::size_t>(number_of(material))];
  if (!mesh.uvs.empty()) group.uses |= group.textures->uses_of_set[0];
  if (!mesh.uvs1.empty()) group.uses |= group.textures->uses_of_set[1];
  group.normal_scale = material.normal_scale;
}

std::ptrdiff_t SurfaceDetail::number_of(const Material& material) const {
  return &material - scene_.materials.data();
}

void SurfaceDetail::add_group(const DetailGroup& group, const Hits& hits, std::uint64_t rays,
                              Surface* const* to, SurfaceBatch* batch) {
  int count = 0;
  memory_.points.front = 0;
  for_each_ray(rays, [&](int ray) {
    memory_.surface[count] = to[ray];
    memory_.triangle[count] = hits.triangle[ray];
    memory_.ray[count] = ray;
    memory_.points.u[count] = hits.points.u[ray];
    memory_.points.v[count] = hits.points.v[ray];
    for (int a = 0; a < 3; ++a) {
      memory_.points.direction[a][count] = hits.direction[a][ray];
      memory_.points.normal[a][count] = hits.points.normal[a][ray];
    }
    memory_.points.cone_width[count] = to[ray]->cone.width;
    memory_.points.front |= (hits.points.front >> ray & 1u) << count;
    ++count;
  });
  memory_.points.count = count;
  const std::uint32_t instance = hits.instance[memory_.ray[0]];
  first_triangle_ = scene_.triangles.instance_first[instance];
  put_corners(group, instance);
  kernels_.surface_detail(group, memory_.points);
  take(group, mesh_of(instance));
  if (group.has_program) run_program(*memory_.surface[0]->material);
  const Material& material = *memory_.surface[0]->material;
  if (scene_.features.has_lobes && has_lobes(material)) add_lobes(group, batch);
  if (scene_.features.has_transmission) pass_light(group, hits, batch);
}

void SurfaceDetail::add_lobes(const DetailGroup& group, SurfaceBatch* batch) {
  if (batch == nullptr) return;
  for (int i = 0; i < memory_.points.count; ++i) {
    Surface& s = *memory_.surface[i];
    const auto slot = static_cast<std::uint16_t>(&s - batch->surface);
    batch->lobes[slot] = lobes_of(s, group, memory_.points, i);
    s.lobes = slot;
  }
}

void SurfaceDetail::pass_light(const DetailGroup& group, const Hits& hits, SurfaceBatch* batch) {
  const Material& material = *memory_.surface[0]->material;
  for (int i = 0; i < memory_.points.count; ++i) {
    Surface& s = *memory_.surface[i];
    if (absorbs(material) && !s.is_front)
      s.weight = absorbed(material.transmission, hits.points.distance[memory_.ray[i]]);
    if (!passes_light(material)) continue;
    const float share = transmission_of(s, group, memory_.points, i);
    SurfaceLobes* const lobes = s.lobes == kNoLobes ? nullptr : &batch->lobes[s.lobes];
    const Vec3f direction{hits.direction[0][memory_.ray[i]], hits.direction[1][memory_.ray[i]],
                          hits.direction[2][memory_.ray[i]]};
    choose_part(s, lobes, share, chance_of(direction, s.point, memory_.triangle[i]));
  }
}

const Mesh& SurfaceDetail::mesh_of(std::uint32_t instance) const {
  return scene_.is_patched(instance) ? mesh_of_patches()
                                     : *scene_.meshes[scene_.instances[instance].mesh];
}

// Stands in for the corners of a triangle: the plane that touches the patch, with its coordinates.
void SurfaceDetail::put_tangents(std::uint32_t instance) {
  const Transform& to_world = scene_.instances[instance].object_to_world;
  for (int i = 0; i < memory_.points.count; ++i) {
    const PartInWorld there = scene_.part(instance, memory_.triangle[i]);
    const TangentTriangle on =
        tangent_triangle(*there.patch, memory_.points.u[i], memory_.points.v[i]);
    for (int k = 0; k < 3; ++k) {
      put_vector(on.corner[k], memory_.points.corner[k], i);
      put_vector(before(to_world, on.corner[k]), memory_.points.corner_of_mesh[k], i);
      put_uv(mesh_of_patches().uvs[static_cast<std::size_t>(k)], memory_.points.corner_uv[0][k], i);
    }
  }
}

// Asks the memory for what all corners have, so that it comes at once and not corner by corner.
void SurfaceDetail::fetch_corners(const DetailGroup& group, const Mesh& mesh) const {
  for (int i = 0; i < memory_.points.count; ++i) {
    for (const std::uint32_t vertex : mesh.triangles[memory_.triangle[i] - first_triangle_]) {
      if (group.has_normals) __builtin_prefetch(&mesh.normals[vertex]);
      if (group.has_program) __builtin_prefetch(&mesh.positions[vertex]);
      if (group.uses != 0 && !mesh.uvs.empty()) __builtin_prefetch(&mesh.uvs[vertex]);
    }
  }
}

void SurfaceDetail::put_corners(const DetailGroup& group, std::uint32_t instance) {
  if (scene_.is_patched(instance)) return put_tangents(instance);
  const Mesh& mesh = mesh_of(instance);
  fetch_corners(group, mesh);
  const auto is_used = [&](int set) {
    return group.uses != 0 && (group.uses & group.textures->uses_of_set[set]) != 0;
  };
  const bool has_own_uv = group.is_stretched && !group.has_tangents;
  const bool has_set[2] = {is_used(0) || has_own_uv, is_used(1)};
  for (int i = 0; i < memory_.points.count; ++i) {
    const auto& corners = mesh.triangles[memory_.triangle[i] - first_triangle_];
    for (int k = 0; k < 3; ++k) {
      const std::uint32_t vertex = corners[static_cast<std::size_t>(k)];
      if (group.has_normals) put_vector(mesh.normals[vertex], memory_.points.corner_normal[k], i);
      if (group.has_program)
        put_vector(mesh.positions[vertex], memory_.points.corner_of_mesh[k], i);
      if (has_set[0]) put_uv(mesh.uvs[vertex], memory_.points.corner_uv[0][k], i);
      if (has_set[1]) put_uv(mesh.uvs1[vertex], memory_.points.corner_uv[1][k], i);
      if (group.uses != 0 || group.has_program || group.is_stretched)
        put_vector(scene_.triangles.vertex_of(instance, memory_.triangle[i], k),
                   memory_.points.corner[k], i);
      if (group.has_tangents) {
        const Vec4f& t = mesh.tangents[vertex];
        put_vector({t.x, t.y, t.z}, memory_.points.corner_tangent[k], i);
        memory_.points.handedness[i] = t.w;
      }
    }
  }
}

void SurfaceDetail::take(const DetailGroup& group, const Mesh& mesh) {
  for (int i = 0; i < memory_.points.count; ++i) {
    Surface& s = *memory_.surface[i];
    s.shading_normal = vector_at(memory_.points.shading_normal, i);
    if (!group.is_diffuse) s.to_viewer = vector_at(memory_.points.to_viewer, i);
    if (group.has_colors) s.albedo = s.albedo * color_at(mesh, i);
    if (group.uses == 0) continue;
    const auto has = [&](TextureUse use) { return (group.uses >> use & 1u) != 0; };
    const auto texel = [&](TextureUse use) { return vector_at(memory_.points.texel[use], i); };
    if (has(kAlbedoTexture)) s.albedo = s.albedo * texel(kAlbedoTexture);
    if (has(kEmissionTexture)) s.emission = s.emission * texel(kEmissionTexture);
    if (has(kRoughnessMetalnessTexture)) {
      const Vec3f factor = texel(kRoughnessMetalnessTexture);
      s.roughness *= factor.y;
      s.metalness *= factor.z;
    }
  }
}

Vec3f SurfaceDetail::color_at(const Mesh& mesh, int i) const {
  const auto& corners = mesh.triangles[memory_.triangle[i] - first_triangle_];
  const auto color = [&](std::size_t k) {
    const Vec4f& c = mesh.colors[corners[k]];
    return Vec3f{c.x, c.y, c.z};
  };
  const float u = memory_.points.u[i], v = memory_.points.v[i];
  return color(0) * (1 - u - v) + color(1) * u + color(2) * v;
}

void SurfaceDetail::run_program(const Material& material) {
  const auto count = static_cast<std::size_t>(memory_.points.count);
  const auto axes = [&](const float(&of)[3][kDetailPoints]) {
    return SurfacePlaces::Axes{{{of[0], count}, {of[1], count}, {of[2], count}}};
  };
  apply_surface_program(material.surface, Noise(kernels_.noise),
                        {axes(memory_.points.place),
                         axes(memory_.points.place_normal),
                         {memory_.points.footprint, count},
                         {memory_.surface, count}});
}

}  // namespace tessera::core
