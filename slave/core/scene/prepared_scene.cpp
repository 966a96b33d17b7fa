// SPDX-License-Identifier: Apache-2.0
#include "slave/core/scene/prepared_scene.h"

#include <algorithm>
#include <new>
#include <span>
#include <string>
#include <unordered_map>
#include <utility>

#include "common/base/byte_text.h"
#include "common/base/check.h"
#include "common/base/limits.h"
#include "common/base/work_gate.h"
#include "slave/core/bsdf/albedo_table.h"
#include "slave/core/bsdf/coat_table.h"
#include "slave/core/bsdf/sheen_table.h"
#include "slave/core/kernels/kernel_table.h"
#include "slave/core/primitive/instance/instanced_index.h"
#include "slave/core/primitive/placed/surface_places.h"
#include "slave/core/scene/flat_geometry.h"
#include "slave/core/scene/patched_geometry.h"
#include "slave/core/scene/prepared_scene_impl.h"
#include "slave/core/simd/isa_support.h"
#include "slave/core/surface/surface_lobes.h"

namespace tessera::core {
namespace {

// Whether vertex normals make a difference: one is further than 1e-5 from that of its triangle,
// which is more than rounding and less than can be seen.
bool is_smooth(const Mesh& mesh) {
  if (mesh.normals.empty()) return false;
  SmallSteps steps;
  for (const auto& t : mesh.triangles) {
    steps.next();
    const Vec3f a = mesh.positions[t[0]];
    const Vec3f flat = normalize(cross(mesh.positions[t[1]] - a, mesh.positions[t[2]] - a));
    for (const std::uint32_t vertex : t) {
      const Vec3f off = normalize(mesh.normals[vertex]) - flat;
      if (!(dot(off, off) <= 1e-10f)) return true;  // also for NaN: of no area, or no normal
    }
  }
  return false;
}

// `same`: another version with the same meshes, or null.
SurfaceFeatures features_of(const Scene& scene, const Geometry& geometry,
                            const PreparedScene::Impl* same) {
  SurfaceFeatures features;
  features.has_normals |= geometry.is_smooth;
  if (same != nullptr) {
    features.has_colors = same->features.has_colors;
  } else {
    for (const auto& mesh : scene.meshes) features.has_colors |= !mesh->colors.empty();
  }
  for (const Material& material : scene.materials) {
    features.has_textures |= has_texture(material);
    features.has_programs |= material.surface.kind != SurfaceKind::kConstant;
    features.has_glossy |= scattering_of(material.bsdf) == Scattering::kLobes;
    features.has_specular |= scattering_of(material.bsdf) == Scattering::kDelta;
    features.has_unlit |= material.is_unlit;
    features.has_lobes |= has_lobes(material);
    features.has_specular |= passes_light(material);
    features.has_transmission |= passes_light(material) || absorbs(material);
  }
  features.is_rich |= features.has_normals || features.needs_cones() || !features.is_diffuse() ||
                      features.has_colors || features.has_unlit;
  return features;
}

// change: of the scene, to what the geometry was made of.
bool is_of(const Geometry& geometry, const Scene& scene, const SceneChange& change,
           const BuildOptions& options) {
  return change.moved && change.moved->empty() && geometry.surfaces == scene.surfaces &&
         geometry.structure == options.structure && geometry.instancing == options.instancing &&
         geometry.is_on_demand == options.is_on_demand &&
         geometry.is_shareable == shareable_surfaces(scene, options.instancing);
}

bool is_any_smooth(const Scene& scene) {
  for (const auto& mesh : scene.meshes) {
    if (is_smooth(*mesh)) return true;
  }
  return false;
}

template <int W>
KnownInstances<W> known_of(const PreparedScene* scene, const SceneChange& change) {
  if (scene == nullptr || scene->impl().patches != nullptr) return {};
  const Geometry& other = *scene->impl().geometry;
  const auto* const index = std::get_if<InstancedBvh<W>>(&other.index.any);
  return {{other.meshes(), other.instances,
           index == nullptr ? std::vector<bool>() : index->is_moving, change},
          index,
          other.triangles.instance_first};
}

// Makes the triangles that are flattened beside instances, or takes those of the other version
// where they are the same. In a version that follows another they get a structure of their own.
template <int W>
Status flatten(const Placement<W>& placement, const Scene& scene, const BuildOptions& options,
               const KnownInstances<W>& known, std::vector<Bounds3f>& boxes,
               Flattened<W>& flattened, Geometry& geometry) {
  TriangleStore& store = geometry.triangles;
  const TriangleSource source{geometry.meshes(), geometry.instances, placement.is_placed};
  const bool has_same_numbers = has_same_flat_part(placement, known);
  flattened.part =
      has_same_numbers
          ? known.index->flat
          : std::make_shared<const FlatPart<W>>(flat_part_of<W>(scene, placement.is_placed));
  if (has_same_numbers ||
      (known.index != nullptr && known.index->flat->made_of == flattened.part->made_of)) {
    const Geometry& other = *options.other->impl().geometry;
    if (has_same_numbers) {
      store = other.triangles;
      store.meshes = source.meshes;
      store.instances = source.instances;
    } else {
      store = make_triangle_store(source, other.triangles);
    }
    geometry.left_out = other.left_out;
    store.degenerate_count = other.left_out.size();
    flattened.part = known.index->flat;
    if (!flattened.part->index) boxes = boxes_of(store.vertices);
  } else {
    store = make_triangle_store(source, boxes);
    leave_out(boxes, flattened.part->numbers(), geometry);
  }
  flattened.boxes = boxes;
  flattened.vertices = store.vertices;
  if (flattened.part->index || store.vertices.empty() || !keeps_most_of(scene, known.scene))
    return Status::ok();
  geometry.built_primitives += boxes.size();
  auto part = std::make_shared<FlatPart<W>>(*flattened.part);
  TESSERA_RETURN_IF_ERROR(
      index_flat_part<W>(boxes, store.vertices, {options.threads, options.is_cancelled}, *part));
  flattened.part = std::move(part);
  return Status::ok();
}

// What a kd-tree takes more than was reckoned is looked for here, before it is built.
Status find_room_for_copies(const Scene& scene, const BuildOptions& options) {
  const std::uint64_t needed = options.free_bytes ? bytes_without_sharing(scene) : 0;
  const std::optional<std::uint64_t> free = needed > 0 ? options.free_bytes() : std::nullopt;
  if (!free || needed <= *free) return Status::ok();
  return Status::resource_exhausted("a kd-tree of the scene needs " + mib_text(needed) +
                                    " of memory here, " + mib_text(*free) +
                                    " are free: it copies what --structure auto shares");
}

// Builds the triangles with their structure, in two levels where instances are worth it.
template <int W>
Status build_index(const Scene& scene, const SceneChange& change, const BuildOptions& options,
                   Geometry& geometry) {
  const BuildControl control{options.threads, options.is_cancelled};
  const KnownInstances<W> known = known_of<W>(options.other, change);
  const bool is_kd =
      options.structure == Structure::kKd || options.structure == Structure::kKdQuality;
  if (is_kd) TESSERA_RETURN_IF_ERROR(find_room_for_copies(scene, options));
  const bool is_on_demand = options.is_on_demand && (options.structure == Structure::kAuto ||
                                                     options.structure == Structure::kBvh);
  Result<Placement<W>> placed = place_instances<W>(
      scene, {is_kd ? Instancing::kNever : options.instancing, is_on_demand}, known, control);
  if (!placed.is_ok()) return placed.status();
  if (placed->is_empty()) {
    const Geometry* const other =
        options.other == nullptr ? nullptr : options.other->impl().geometry.get();
    return build_flat_geometry<W>(other, control, geometry);
  }
  std::vector<Bounds3f> boxes;  // by flattened triangle
  Flattened<W> flattened;
  TESSERA_RETURN_IF_ERROR(flatten(*placed, scene, options, known, boxes, flattened, geometry));
  geometry.triangles.degenerate_count += placed->degenerate_count;
  auto index = index_instances<W>(std::move(*placed), std::move(flattened), known.index, control);
  if (!index.is_ok()) return index.status();
  // PreparedScene::built_primitives() adds all that rays have met. What they met in versions before
  // was built there, and is taken off beforehand; the sum is right, though this may wrap around.
  geometry.built_primitives += index->built_primitives - index->met_primitives();
  geometry.index.any = std::move(*index);
  return Status::ok();
}

bool has_patches(const Scene& scene) {
  return std::any_of(scene.instances.begin(), scene.instances.end(), [](const Instance& instance) {
    return instance.kind == ObjectKind::kPatchSurface;
  });
}

Status build_any_index(const Scene& scene, const SceneChange& change, const BuildOptions& options,
                       Geometry& geometry) {
  const bool is_wide = kernels_for(widest_isa(cpu_isas() & compiled_isas())).lane_count >= 16;
  if (!has_patches(scene)) {
    return is_wide ? build_index<16>(scene, change, options, geometry)
                   : build_index<8>(scene, change, options, geometry);
  }
  if (!kKnowsPatches) return Status::invalid_argument("this build knows no patches");
  if (options.structure == Structure::kKd || options.structure == Structure::kKdQuality)
    return Status::invalid_argument("patches are traced through a hierarchy: use --structure bvh");
  const Geometry* const other =
      options.other == nullptr ? nullptr : options.other->impl().geometry.get();
  const BuildControl control{options.threads, options.is_cancelled};
  return is_wide ? build_patched_geometry<16>(scene, other, control, geometry)
                 : build_patched_geometry<8>(scene, other, control, geometry);
}

Result<std::shared_ptr<const Geometry>> build_geometry(const Scene& scene,
                                                       const SceneChange& change,
                                                       const BuildOptions& options) {
  const Geometry* other = nullptr;
  if (options.other != nullptr) {
    const std::shared_ptr<const Geometry>& others = options.other->impl().geometry;
    if (is_of(*others, scene, change, options)) return others;
    other = others.get();
  }
  auto geometry = std::make_shared<Geometry>();
  geometry->mesh_list =
      change.has_same_meshes ? other->mesh_list : std::make_shared<const MeshList>(scene.meshes);
  geometry->surfaces = scene.surfaces;
  geometry->is_shareable = shareable_surfaces(scene, options.instancing);
  geometry->instances = scene.instances;
  geometry->structure = options.structure;
  geometry->instancing = options.instancing;
  geometry->is_on_demand = options.is_on_demand;
  TESSERA_RETURN_IF_ERROR(build_any_index(scene, change, options, *geometry));
  geometry->is_smooth = change.has_same_meshes ? other->is_smooth : is_any_smooth(scene);
  return std::shared_ptr<const Geometry>(std::move(geometry));
}

std::vector<std::shared_ptr<const MipMap>> mip_maps_of(const Scene& scene,
                                                       const PreparedScene::Impl* other) {
  std::unordered_map<const Texture*, std::shared_ptr<const MipMap>> known;
  if (other != nullptr) {
    for (const auto& map : other->textures) known[map->base.get()] = map;
  }
  std::vector<std::shared_ptr<const MipMap>> maps;
  for (const auto& texture : scene.textures) {
    auto& map = known[texture.get()];
    if (!map) map = std::make_shared<const MipMap>(make_mip_map(texture));
    maps.push_back(map);
  }
  return maps;
}

Result<std::shared_ptr<const PreparedScene>> build_checked(const Scene& scene,
                                                           const BuildOptions& options) {
  const PreparedScene::Impl* other = options.other == nullptr ? nullptr : &options.other->impl();
  const SceneChange change =
      other == nullptr ? SceneChange() : change_of(scene, other->meshes, other->instances);
  const std::uint64_t count = change.moved ? 0 : scene.triangle_count();  // that of the other
  if (count > kTrianglesMax) {
    return Status::resource_exhausted("the scene has " + std::to_string(count) +
                                      " triangles, more than 2^30: split it");
  }
  auto geometry = build_geometry(scene, change, options);
  if (!geometry.is_ok()) return geometry.status();
  auto impl = std::make_unique<PreparedScene::Impl>(std::move(*geometry));
  impl->textures = mip_maps_of(scene, other);
  for (const auto& map : impl->textures) impl->texture_views.push_back(view_of(*map));
  impl->lights =
      make_light_set(scene, impl->triangles, impl->geometry->patches, impl->geometry->left_out,
                     impl->textures, other == nullptr ? nullptr : &other->lights);
  impl->features = features_of(scene, *impl->geometry, change.has_same_meshes ? other : nullptr);
  if (impl->features.has_glossy) AlbedoTable::shared();  // made here, not in the first tile
  if (std::any_of(scene.materials.begin(), scene.materials.end(), has_sheen)) SheenTable::shared();
  if (std::any_of(scene.materials.begin(), scene.materials.end(), has_coat)) CoatTable::shared();
  impl->materials = scene.materials;
  for (std::size_t i = 0; i < scene.materials.size() && impl->features.has_textures; ++i)
    impl->texture_tables.push_back(make_texture_table(scene.materials[i], impl->texture_views));
  impl->alpha =
      AlphaSurfaces::make({impl->triangles, impl->meshes, impl->instances, impl->materials,
                           impl->textures, impl->patches, impl->geometry->surfaces});
  return std::shared_ptr<const PreparedScene>(std::make_shared<PreparedScene>(std::move(impl)));
}

}  // namespace

Result<std::shared_ptr<const PreparedScene>> PreparedScene::build(const Scene& scene,
                                                                  const BuildOptions& options) {
  TESSERA_CHECK_GE(options.threads, 1);
  try {
    return build_checked(scene, options);
  } catch (const std::bad_alloc&) {
    return Status::resource_exhausted("no memory to prepare a scene of " +
                                      std::to_string(scene.triangle_count()) + " triangles");
  }
}

PreparedScene::PreparedScene(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
PreparedScene::~PreparedScene() = default;

std::uint64_t PreparedScene::primitive_count() const {
  const std::vector<std::uint64_t>& first = impl_->geometry->first_number;
  return first.empty() ? impl_->triangles.primitive_count() : first.back();
}
std::uint64_t PreparedScene::degenerate_count() const { return impl_->triangles.degenerate_count; }

bool PreparedScene::has_geometry_of(const PreparedScene& other) const {
  return impl_->geometry == other.impl_->geometry;
}

std::uint64_t PreparedScene::built_primitives() const {
  const auto met = [](const auto& index) -> std::uint64_t {
    if constexpr (requires { index.met_primitives(); }) return index.met_primitives();
    return 0;
  };
  return impl_->geometry->built_primitives + std::visit(met, impl_->index.any);
}

std::uint64_t PreparedScene::fitted_primitives() const {
  return impl_->geometry->fitted_primitives;
}

std::uint64_t PreparedScene::memory_bytes() const {
  std::uint64_t bytes = sizeof(Impl) + impl_->index.memory_bytes();
  bytes += impl_->triangles.vertices.size() * sizeof(float);
  if (impl_->patches != nullptr) bytes += impl_->patches->memory_bytes();
  bytes += (impl_->triangles.instance_first.capacity() + impl_->triangles.stored_first.capacity()) *
           sizeof(std::uint64_t);
  bytes += impl_->instances.capacity() * sizeof(Instance);
  bytes += impl_->lights.emitters.capacity() * sizeof(Emitter);
  bytes += impl_->lights.emitter_textures.capacity() * sizeof(EmitterTexture);
  for (const auto& mesh : impl_->meshes) {
    bytes += mesh->positions.size() * sizeof(Vec3f) + mesh->normals.size() * sizeof(Vec3f);
    bytes += (mesh->uvs.size() + mesh->uvs1.size()) * sizeof(Vec2f);
    bytes += (mesh->tangents.size() + mesh->colors.size()) * sizeof(Vec4f);
    bytes += mesh->triangles.size() * 3 * sizeof(std::uint32_t);
  }
  for (const auto& surface : impl_->geometry->surfaces)
    bytes +=
        surface->numbers.size() * sizeof(float) + surface->trim_points.size() * sizeof(TrimPoint);
  if (impl_->alpha) bytes += impl_->alpha->memory_bytes();
  if (impl_->lights.sky_map) bytes += impl_->lights.sky_map->memory_bytes();
  bytes += impl_->texture_views.capacity() * sizeof(TextureView);
  bytes += impl_->texture_tables.capacity() * sizeof(TextureTable);
  for (const auto& map : impl_->textures) {
    bytes += memory_bytes_of(*map->base);
    for (const Texture& level : map->levels) bytes += memory_bytes_of(level);
  }
  return bytes;
}

}  // namespace tessera::core
