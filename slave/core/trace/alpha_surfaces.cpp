// SPDX-License-Identifier: Apache-2.0
#include "slave/core/trace/alpha_surfaces.h"

#include <bit>

#include "slave/core/primitive/freeform/patch_point.h"
#include "slave/core/primitive/triangle/barycentric.h"
#include "slave/core/sampling/sample_sequence.h"

namespace tessera::core {
namespace {

// Random number in [0, 1) of a ray at a primitive.
float chance_of(const SingleRay& ray, std::uint32_t primitive) {
  std::uint32_t key = mix_bits(primitive);
  for (const float x : ray.origin) key = hash_combine(key, std::bit_cast<std::uint32_t>(x));
  for (const float x : ray.direction) key = hash_combine(key, std::bit_cast<std::uint32_t>(x));
  return unit_float(key);
}

const Material& material_of(const AlphaSurfaces::Parts& parts, const Mesh& mesh,
                            std::size_t triangle) {
  return parts.materials[mesh.materials.size() == 1 ? mesh.materials[0] : mesh.materials[triangle]];
}

}  // namespace

std::unique_ptr<const AlphaSurfaces> AlphaSurfaces::make(const Parts& parts) {
  bool has_alpha = false;
  for (const Material& material : parts.materials)
    has_alpha |= material.alpha.mode != AlphaMode::kOpaque;
  if (!has_alpha) return nullptr;
  std::unique_ptr<AlphaSurfaces> made(new AlphaSurfaces(parts));
  made->may_pass_.resize((parts.triangles.primitive_count() + 63) / 64);
  bool is_any = false;
  for (std::uint32_t i = 0; i < parts.instances.size(); ++i) is_any |= made->mark(i);
  if (!is_any) return nullptr;
  return made;
}

// Returns: whether any triangle of the instance may be passed.
bool AlphaSurfaces::mark(std::uint32_t instance) {
  if (parts_.instances[instance].kind == ObjectKind::kPatchSurface) return mark_patches(instance);
  const Mesh& mesh = *parts_.meshes[parts_.instances[instance].mesh];
  const std::uint64_t first = parts_.triangles.instance_first[instance];
  // Neighbours mostly have one material.
  const Material* known = nullptr;
  bool may_pass = false, is_any = false;
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
    const Material& material = material_of(parts_, mesh, i);
    if (&material != known) {
      known = &material;
      may_pass = may_be_passed(material, mesh, parts_.textures);
    }
    if (!may_pass) continue;
    is_any = true;
    may_pass_[(first + i) / 64] |= std::uint64_t{1} << ((first + i) % 64);
  }
  return is_any;
}

const Material& AlphaSurfaces::material_of_part(std::uint32_t instance, std::uint64_t part) const {
  const auto& of = parts_.surfaces[parts_.instances[instance].mesh]->materials;
  return parts_
      .materials[of.size() == 1 ? of[0] : of[parts_.patches->patch_of_part(instance, part)]];
}

bool AlphaSurfaces::mark_patches(std::uint32_t instance) {
  const PatchStore& patches = *parts_.patches;
  std::uint64_t number = parts_.triangles.instance_first[instance];
  bool is_any = false;
  for (std::uint64_t p = 0; p < patches.part_count(instance); ++p) {
    const Material& material = material_of_part(instance, p);
    if (may_be_passed(material, mesh_of_patches(), parts_.textures)) {
      is_any = true;
      may_pass_[number / 64] |= std::uint64_t{1} << (number % 64);
    }
    ++number;
  }
  return is_any;
}

float AlphaSurfaces::opacity_of_patch(std::uint32_t instance, const SingleHit& hit,
                                      const SingleRay& ray, PatchMethod method) const {
  const std::uint64_t part = hit.primitive - parts_.triangles.instance_first[instance];
  const PartInWorld there = parts_.patches->part_at(instance, part);
  const PatchSurfacePoint at =
      patch_point(*there.patch, *there.part, ray.origin, ray.direction, hit.t, method);
  return opacity_at(material_of_part(instance, part), mesh_of_patches(), 0, parts_.textures, at.u,
                    at.v);
}

bool AlphaSurfaces::is_let_through(const SingleHit& hit, const SingleRay& ray,
                                   PatchMethod method) const {
  const TriangleStore& store = parts_.triangles;
  const std::uint32_t triangle = hit.primitive, instance = store.instance_of(triangle);
  if (parts_.instances[instance].kind == ObjectKind::kPatchSurface) {
    const float opacity = opacity_of_patch(instance, hit, ray, method);
    return opacity < 1 && chance_of(ray, triangle) >= opacity;
  }
  const Mesh& mesh = *parts_.meshes[parts_.instances[instance].mesh];
  const auto local = static_cast<std::size_t>(triangle - store.instance_first[instance]);
  const Vec3f origin{ray.origin[0], ray.origin[1], ray.origin[2]};
  const Vec3f direction{ray.direction[0], ray.direction[1], ray.direction[2]};
  const Vec2f uv = barycentric(origin, direction, store.vertex(triangle, 0),
                               store.vertex(triangle, 1), store.vertex(triangle, 2));
  const float opacity =
      opacity_at(material_of(parts_, mesh, local), mesh, local, parts_.textures, uv.x, uv.y);
  return opacity < 1 && chance_of(ray, triangle) >= opacity;
}

}  // namespace tessera::core
