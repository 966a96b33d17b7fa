// SPDX-License-Identifier: Apache-2.0
#include "master/import/gltf/nodes.h"

#include <cmath>

#include "common/base/limits.h"
#include "common/scene_io/scene_reader.h"
#include "master/import/gltf/accessor.h"
#include "master/import/gltf/lights.h"
#include "master/import/gltf/primitive.h"

namespace tessera::import {
namespace {

// Rigs have some hundred joints in a row; a deeper chain was not made by a person.
constexpr int kNodeDepthMax = 4096;

// translation * rotation * scale; a quaternion of length 0 counts as no rotation.
Transform placed(std::array<float, 3> move, std::array<float, 4> turn, std::array<float, 3> scale) {
  double x = turn[0], y = turn[1], z = turn[2], w = turn[3];
  const double size = std::sqrt(x * x + y * y + z * z + w * w);
  if (size > 0) {
    x /= size, y /= size, z /= size, w /= size;
  } else {
    w = 1;
  }
  const std::array<std::array<double, 3>, 3> rows{
      {{1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)},
       {2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)},
       {2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)}}};
  Transform t;
  for (std::size_t i = 0; i < 3; ++i) {
    for (std::size_t j = 0; j < 3; ++j)
      t.m[i][j] = static_cast<float>(rows[i][j] * static_cast<double>(scale[j]));
    t.m[i][3] = move[i];
  }
  return t;
}

Transform local_transform(const GltfObject& node) {
  if (!node.has("matrix")) {
    return placed(node.reals<3>("translation", {0, 0, 0}, kAnyNumber),
                  node.reals<4>("rotation", {0, 0, 0, 1}, kAnyNumber),
                  node.reals<3>("scale", {1, 1, 1}, kAnyNumber));
  }
  const auto m =
      node.reals<16>("matrix", {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1}, kAnyNumber);
  if (m[3] != 0 || m[7] != 0 || m[11] != 0 || m[15] != 1)
    node.warn("matrix", "has a last row that is not 0, 0, 0, 1; it is passed over");
  Transform t;
  for (std::size_t i = 0; i < 3; ++i) {
    for (std::size_t j = 0; j < 4; ++j) t.m[i][j] = m[4 * j + i];
  }
  return t;
}

bool is_finite_transform(const Transform& t) {
  for (const auto& row : t.m) {
    for (const float x : row) {
      if (!std::isfinite(x)) return false;
    }
  }
  return true;
}

// Whether the matrix has no inverse: its determinant is 0, or cannot be told from rounding.
bool is_singular(const Transform& t) {
  double determinant = 0, size = 0;
  for (std::size_t i = 0; i < 3; ++i) {
    const auto at = [&](std::size_t row, std::size_t column) {
      return static_cast<double>(t.m[row][(i + column) % 3]);
    };
    const double a = at(0, 0) * (at(1, 1) * at(2, 2)), b = at(0, 0) * (at(1, 2) * at(2, 1));
    determinant += a - b;
    size += std::fabs(a) + std::fabs(b);
  }
  // The six products of three and their sum in double have 3 + 5 roundings, and as many again are
  // to spare.
  return !(std::fabs(determinant) > 16 * 0x1p-53 * size);
}

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
  const Transform here = place.parent * local_transform(node);
  if (!is_finite_transform(here))
    return Status::invalid_argument(node.name() + ": its place is not finite");
  const auto children = node.refused_indices("children", document_.count("nodes"));
  if (!children.is_ok()) return children.status();
  if (!shown.flag("visible", true)) return Status::ok();
  const auto mesh = node.refused_index("mesh", document_.count("meshes"));
  if (!mesh.is_ok()) return mesh.status();
  const std::uint32_t number = motion_.enter(place.node, node, place.parent_number);
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
    if (!is_finite_transform(here))
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
    places.push_back(
        placed({move[0], move[1], move[2]}, part(1, {0, 0, 0, 1}), {scale[0], scale[1], scale[2]}));
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
