// SPDX-License-Identifier: Apache-2.0
#include "master/import/gltf/nodes.h"

#include "common/base/limits.h"
#include "common/math/transform_checks.h"
#include "common/scene/pose.h"
#include "common/scene_io/scene_reader.h"
#include "master/import/gltf/accessor.h"
#include "master/import/gltf/lights.h"
#include "master/import/gltf/primitive.h"

namespace tessera::import {
namespace {

// Rigs have some hundred joints in a row; a deeper chain was not made by a person.
constexpr int kNodeDepthMax = 4096;

// glTF 2.0, section 3.7.4: a node that mirrors turns the order of a triangle's corners round.
bool is_mirrored(const Transform& t) {
  const auto row = [&t](std::size_t i) { return Vec3f{t.m[i][0], t.m[i][1], t.m[i][2]}; };
  return dot(cross(row(0), row(1)), row(2)) < 0;
}

}  // namespace

Status GltfNodes::walk(const std::vector<std::uint32_t>& roots) {
  is_seen_.assign(document_.count("nodes"), false);
  std::vector<Place> open;
  for (auto root = roots.rbegin(); root != roots.rend(); ++root)
    open.push_back({*root, 0, Transform{}, kNoIndex});
  while (!open.empty()) {
    const Place place = open.back();
    open.pop_back();
    TESSERA_RETURN_IF_ERROR(visit(place, open));
  }
  return Status::ok();
}

Status GltfNodes::visit(const Place& place, std::vector<Place>& open) {
  const GltfObject node = document_.at("nodes", place.node);
  if (is_seen_[place.node])
    return Status::invalid_argument(node.name() + ": is its own ancestor, or a child of two nodes");
  is_seen_[place.node] = true;
  if (place.depth > kNodeDepthMax)
    return Status::invalid_argument(node.name() + ": lies deeper than " +
                                    std::to_string(kNodeDepthMax) + " nodes");
  node.check_keys(
      {"camera", "children", "skin", "matrix", "mesh", "rotation", "scale", "translation",
       "weights"},
      {"KHR_lights_punctual", "EXT_mesh_gpu_instancing", "KHR_node_visibility", "KHR_xmp_json_ld"});
  const GltfObject shown = node.extension("KHR_node_visibility");
  shown.check_keys({"visible"}, {});
  const MotionNode rest = read_place(node);
  const Transform here = place.parent * rest_place(rest);
  if (!is_finite(here)) return Status::invalid_argument(node.name() + ": its place is not finite");
  const auto children = node.refused_indices("children", document_.count("nodes"));
  if (!children.is_ok()) return children.status();
  if (!shown.flag("visible", true)) return Status::ok();
  const auto mesh = node.refused_index("mesh", document_.count("meshes"));
  if (!mesh.is_ok()) return mesh.status();
  const std::uint32_t number = motion_.enter(place.node, rest, place.parent_number);
  if (*mesh) TESSERA_RETURN_IF_ERROR(add_instances(node, **mesh, here, number));
  const std::size_t lights = scene_.lights.size(), cameras = scene_.cameras.size();
  add_light(document_, node, here, scene_);
  if (scene_.lights.size() > lights) motion_.carry_light(number);
  add_camera(document_, node, here, scene_);
  if (scene_.cameras.size() > cameras) motion_.carry_camera(number);
  for (auto child = children->rbegin(); child != children->rend(); ++child)
    open.push_back({*child, place.depth + 1, here, number});
  return Status::ok();
}

Status GltfNodes::add_instances(const GltfObject& node, std::uint32_t mesh,
                                const Transform& to_world, std::uint32_t number) {
  const auto meshes = meshes_of(mesh);
  if (!meshes.is_ok()) return meshes.status();
  const auto places = instances_of(node);
  if (!places.is_ok()) return places.status();
  std::size_t left_out = 0;
  for (const Transform& place : *places) {
    const Transform here = to_world * place;
    if (!is_finite(here))
      return Status::invalid_argument(node.name() + ": the place of an instance is not finite");
    if (is_singular(here)) {
      ++left_out;
      continue;
    }
    for (const std::uint32_t m : **meshes)
      TESSERA_RETURN_IF_ERROR(add_instance(node, m, here, place, number));
  }
  if (left_out > 0) {
    const std::string which =
        places->size() == 1 ? "" : std::to_string(left_out) + " instances of ";
    node.warn("mesh", "is not drawn: the matrix of " + which +
                          "the node, with those above it, is singular (it has no inverse)");
  }
  return Status::ok();
}

// A mesh that a skin or morph targets deform is one of its own for each node. Skins place it in the
// world, and their node's own place is of no effect.
Status GltfNodes::add_instance(const GltfObject& node, std::uint32_t mesh,
                               const Transform& to_world, const Transform& in_node,
                               std::uint32_t number) {
  if (scene_.instances.size() >= kInstancesMax)
    return Status::resource_exhausted("more than " + std::to_string(kInstancesMax) + " instances");
  const auto how = deformations_.find(mesh);
  const bool has_skin = node.has("skin");
  const bool is_skinned = how != deformations_.end() && how->second.influence_count > 0 && has_skin;
  if (has_skin && !is_skinned)
    node.warn("skin", "moves nothing: the mesh has no JOINTS_0 and WEIGHTS_0");
  const bool is_reversed = !is_skinned && is_mirrored(to_world);
  const std::uint32_t shown = is_reversed ? reversed(mesh) : mesh;
  if (how == deformations_.end() || (!is_skinned && how->second.target_count == 0)) {
    scene_.instances.push_back({shown, to_world});
    motion_.carry_instance(number, in_node);
    return Status::ok();
  }
  const auto own = static_cast<std::uint32_t>(scene_.meshes.size());
  scene_.meshes.push_back(scene_.meshes[shown]);
  scene_.instances.push_back({own, is_skinned ? Transform{} : to_world});
  if (!is_skinned) motion_.carry_instance(number, in_node);
  return motion_.deform(number, node, own, how->second);
}

// The places of EXT_mesh_gpu_instancing; one identity transform for a node without the extension.
Result<std::vector<Transform>> GltfNodes::instances_of(const GltfObject& node) {
  const GltfObject extension = node.extension("EXT_mesh_gpu_instancing");
  if (!extension.is_there()) return std::vector<Transform>(1);
  extension.check_keys({"attributes"}, {});
  const GltfObject attributes = extension.object("attributes");
  constexpr std::pair<const char*, std::size_t> kParts[] = {
      {"TRANSLATION", 3}, {"ROTATION", 4}, {"SCALE", 3}};
  std::array<std::optional<GltfAccessor>, 3> parts;
  std::optional<std::size_t> count;
  for (std::size_t i = 0; i < 3; ++i) {
    const auto& [name, components] = kParts[i];
    const auto index = attributes.refused_index(name, document_.count("accessors"));
    if (!index.is_ok()) return index.status();
    if (!*index) continue;
    auto accessor = GltfAccessor::open(document_, **index);
    if (!accessor.is_ok()) return accessor.status();
    if (accessor->components() != components)
      return attributes.refuse(name, "must have " + std::to_string(components) + " components");
    if (count.value_or(accessor->count()) != accessor->count())
      return attributes.refuse(name, "has another count than the others");
    count = accessor->count();
    parts[i] = std::move(*accessor);
  }
  if (count.value_or(1) > kInstancesMax)
    return attributes.refuse("TRANSLATION",
                             "asks for more than " + std::to_string(kInstancesMax) + " instances");
  std::vector<Transform> places;
  for (std::size_t i = 0; i < count.value_or(1); ++i) {
    const auto part = [&](std::size_t k, std::array<float, 4> fallback) {
      return parts[k] ? parts[k]->read(i) : fallback;
    };
    const auto move = part(0, {0, 0, 0, 0}), scale = part(2, {1, 1, 1, 0});
    const auto turn = part(1, {0, 0, 0, 1});
    MotionNode rest;
    rest.translation = {move[0], move[1], move[2]};
    rest.rotation = {turn[0], turn[1], turn[2], turn[3]};
    rest.scale = {scale[0], scale[1], scale[2]};
    places.push_back(rest_place(rest));
  }
  for (const std::string& name : attributes.keys()) {
    if (name != "TRANSLATION" && name != "ROTATION" && name != "SCALE" && !name.starts_with("_"))
      attributes.warn(printable(name), "is not read");
  }
  return places;
}

Result<const std::vector<std::uint32_t>*> GltfNodes::meshes_of(std::uint32_t mesh) {
  const auto known = meshes_.find(mesh);
  if (known != meshes_.end()) return &known->second;
  const GltfObject source = document_.at("meshes", mesh);
  source.check_keys({"primitives", "weights"}, {"KHR_xmp_json_ld"});
  std::vector<std::uint32_t>& made = meshes_[mesh];
  for (const GltfObject& primitive : source.objects("primitives")) {
    auto read = read_primitive(document_, primitive, materials_);
    if (!read.is_ok()) return read.status();
    if (read->mesh == nullptr || read->mesh->triangles.empty()) continue;
    degenerate_count_ += count_degenerate(*read->mesh);
    made.push_back(static_cast<std::uint32_t>(scene_.meshes.size()));
    if (read->deformation.is_any()) deformations_[made.back()] = std::move(read->deformation);
    scene_.meshes.push_back(std::move(read->mesh));
  }
  return &made;
}

std::uint32_t GltfNodes::reversed(std::uint32_t mesh) {
  const auto [known, is_new] =
      reversed_.try_emplace(mesh, static_cast<std::uint32_t>(scene_.meshes.size()));
  if (is_new) {
    auto copy = std::make_shared<Mesh>(*scene_.meshes[mesh]);
    for (auto& t : copy->triangles) std::swap(t[1], t[2]);
    scene_.meshes.push_back(std::move(copy));
  }
  return known->second;
}

}  // namespace tessera::import
