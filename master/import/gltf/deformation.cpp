// SPDX-License-Identifier: Apache-2.0
#include "master/import/gltf/deformation.h"

#include <algorithm>
#include <cmath>

#include "common/base/limits.h"

namespace tessera::import {
namespace {

constexpr std::size_t kSetWidth = 4;  // joints of one pair JOINTS_n, WEIGHTS_n

std::string of_vertex(std::size_t vertex) { return "of vertex " + std::to_string(vertex); }

Status read_set(const GltfObject& primitive, const GltfVertices& vertices, std::uint32_t set,
                const GltfAccessor& joints, const GltfAccessor& weights, GltfDeformation& result) {
  const std::string name = "attributes.WEIGHTS_" + std::to_string(set);
  for (std::size_t vertex = 0; vertex < vertices.count; ++vertex) {
    const std::size_t source = vertices.source_of(vertex);
    const auto joint = joints.read(source), weight = weights.read(source);
    for (std::size_t i = 0; i < kSetWidth; ++i) {
      if (!(weight[i] >= 0) || !std::isfinite(weight[i]))
        return primitive.refuse(name, of_vertex(source) + " is below 0 or not finite");
      const auto number = static_cast<std::uint32_t>(weight[i] > 0 ? joint[i] : 0);
      result.influences[vertex * result.influence_count + set * kSetWidth + i] = {number,
                                                                                  weight[i]};
      if (weight[i] > 0) result.joint_count = std::max(result.joint_count, number + 1);
    }
  }
  return Status::ok();
}

Status read_influences(const GltfObject& primitive, const GltfVertices& vertices,
                       GltfDeformation& result) {
  std::vector<std::pair<GltfAccessor, GltfAccessor>> sets;
  for (std::uint32_t set = 0; set < kInfluencesMax / kSetWidth; ++set) {
    const std::string number = std::to_string(set);
    auto joints = vertices.find("JOINTS_" + number, kSetWidth, kSetWidth);
    if (!joints.is_ok()) return joints.status();
    auto weights = vertices.find("WEIGHTS_" + number, kSetWidth, kSetWidth);
    if (!weights.is_ok()) return weights.status();
    if (joints->has_value() != weights->has_value())
      return primitive.refuse("attributes.JOINTS_" + number,
                              "and WEIGHTS_" + number + " come together or not at all");
    if (!*joints) break;
    if ((*joints)->is_normalized() ||
        ((*joints)->type() != ComponentType::kUint8 && (*joints)->type() != ComponentType::kUint16))
      return primitive.refuse("attributes.JOINTS_" + number, "are no unsigned bytes or shorts");
    sets.emplace_back(std::move(**joints), std::move(**weights));
  }
  result.influence_count = static_cast<std::uint32_t>(sets.size() * kSetWidth);
  result.influences.resize(vertices.count * result.influence_count);
  for (std::uint32_t set = 0; set < sets.size(); ++set) {
    TESSERA_RETURN_IF_ERROR(
        read_set(primitive, vertices, set, sets[set].first, sets[set].second, result));
  }
  for (std::size_t vertex = 0; result.influence_count > 0 && vertex < vertices.count; ++vertex) {
    float sum = 0;
    for (std::size_t i = 0; i < result.influence_count; ++i)
      sum += result.influences[vertex * result.influence_count + i].weight;
    if (!(sum > 0))
      return primitive.refuse("attributes.WEIGHTS_0",
                              of_vertex(vertices.source_of(vertex)) + " sum to 0");
  }
  return Status::ok();
}

// Appends what one attribute of a target adds to the vertices: zeros where it has none.
Status read_deltas(GltfDocument& document, const GltfObject& target, const std::string& name,
                   const GltfVertices& vertices, std::vector<Vec3f>& deltas) {
  const std::size_t first = deltas.size();
  deltas.resize(first + vertices.count);
  const auto index = target.refused_index(name, document.count("accessors"));
  if (!index.is_ok()) return index.status();
  if (!*index) return Status::ok();
  const auto accessor = GltfAccessor::open(document, **index);
  if (!accessor.is_ok()) return accessor.status();
  if (accessor->components() != 3 || accessor->count() < vertices.source_count)
    return target.refuse(name, "is " + accessor->name() + ", which does not fit the primitive");
  for (std::size_t vertex = 0; vertex < vertices.count; ++vertex) {
    const std::size_t source = vertices.source_of(vertex);
    const auto delta = accessor->read(source);
    deltas[first + vertex] = {delta[0], delta[1], delta[2]};
    if (!is_finite(deltas[first + vertex]))
      return target.refuse(name, of_vertex(source) + " is not finite");
  }
  return Status::ok();
}

}  // namespace

Result<GltfDeformation> read_deformation(GltfDocument& document, const GltfObject& primitive,
                                         const GltfVertices& vertices) {
  GltfDeformation result;
  TESSERA_RETURN_IF_ERROR(read_influences(primitive, vertices, result));
  const std::vector<GltfObject> targets = primitive.objects("targets");
  result.target_count = static_cast<std::uint32_t>(targets.size());
  for (const GltfObject& target : targets) {
    result.has_normals = result.has_normals || target.has("NORMAL");
    result.has_tangents = result.has_tangents || target.has("TANGENT");
  }
  for (const GltfObject& target : targets) {
    TESSERA_RETURN_IF_ERROR(read_deltas(document, target, "POSITION", vertices, result.deltas));
    if (result.has_normals)
      TESSERA_RETURN_IF_ERROR(read_deltas(document, target, "NORMAL", vertices, result.deltas));
    if (result.has_tangents)
      TESSERA_RETURN_IF_ERROR(read_deltas(document, target, "TANGENT", vertices, result.deltas));
    for (const std::string& name : target.keys()) {
      if (name != "POSITION" && name != "NORMAL" && name != "TANGENT" && !name.starts_with("_"))
        target.warn(printable(name), "is not read");
    }
  }
  return result;
}

}  // namespace tessera::import
