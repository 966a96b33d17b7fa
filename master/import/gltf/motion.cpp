// SPDX-License-Identifier: Apache-2.0
#include "master/import/gltf/motion.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "common/base/limits.h"
#include "common/math/transform_checks.h"
#include "common/scene/pose.h"
#include "master/import/gltf/accessor.h"

namespace tessera::import {
namespace {

Transform matrix_of(const std::array<float, 16>& m) {
  Transform t;
  for (std::size_t i = 0; i < 3; ++i) {
    for (std::size_t j = 0; j < 4; ++j) t.m[i][j] = m[4 * j + i];
  }
  return t;
}

std::optional<MotionPath> path_named(const std::string& name) {
  if (name == "translation") return MotionPath::kTranslation;
  if (name == "rotation") return MotionPath::kRotation;
  if (name == "scale") return MotionPath::kScale;
  if (name == "weights") return MotionPath::kWeights;
  return std::nullopt;
}

}  // namespace

MotionNode read_place(const GltfObject& node) {
  MotionNode place;
  if (node.has("matrix")) {
    const auto m =
        node.reals<16>("matrix", {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1}, kAnyNumber);
    if (m[3] != 0 || m[7] != 0 || m[11] != 0 || m[15] != 1)
      node.warn("matrix", "has a last row that is not 0, 0, 0, 1; it is passed over");
    place.has_matrix = 1;
    place.matrix = matrix_of(m);
    return place;
  }
  const auto move = node.reals<3>("translation", {0, 0, 0}, kAnyNumber);
  const auto turn = node.reals<4>("rotation", {0, 0, 0, 1}, kAnyNumber);
  const auto scale = node.reals<3>("scale", {1, 1, 1}, kAnyNumber);
  const bool is_turned = turn[0] != 0 || turn[1] != 0 || turn[2] != 0 || turn[3] != 0;
  place.translation = {move[0], move[1], move[2]};
  if (is_turned) place.rotation = {turn[0], turn[1], turn[2], turn[3]};
  place.scale = {scale[0], scale[1], scale[2]};
  return place;
}

std::uint32_t GltfMotion::enter(std::uint32_t node, MotionNode rest, std::uint32_t parent) {
  rest.parent = parent;
  const auto number = static_cast<std::uint32_t>(motion_.nodes.size());
  numbers_[node] = number;
  motion_.nodes.push_back(rest);
  return number;
}

void GltfMotion::carry_instance(std::uint32_t number, const Transform& in_node) {
  const auto last = static_cast<std::uint32_t>(scene_.instances.size() - 1);
  motion_.instances.push_back({last, number, in_node});
}

void GltfMotion::carry_light(std::uint32_t number) {
  motion_.lights.push_back({static_cast<std::uint32_t>(scene_.lights.size() - 1), number});
}

void GltfMotion::carry_camera(std::uint32_t number) {
  motion_.cameras.push_back({static_cast<std::uint32_t>(scene_.cameras.size() - 1), number});
}

Status GltfMotion::deform(std::uint32_t number, const GltfObject& source, std::uint32_t scene_mesh,
                          const GltfDeformation& how) {
  const auto skin = source.refused_index("skin", document_.count("skins"));
  if (!skin.is_ok()) return skin.status();
  const bool has_skin = skin->has_value() && how.influence_count > 0;
  MotionNode& node = motion_.nodes[number];
  if (node.weight_count < how.target_count) {
    if (node.weight_count > 0)
      return source.refuse("mesh", "has primitives of different numbers of morph targets");
    node.first_weight = static_cast<std::uint32_t>(motion_.weights.size());
    node.weight_count = how.target_count;
    motion_.weights.resize(motion_.weights.size() + how.target_count);
    const auto mesh = source.index("mesh", document_.count("meshes"), "");
    const GltfObject weighted = source.has("weights") ? source : document_.at("meshes", *mesh);
    weighted.read_reals("weights", motion_.weights.data() + node.first_weight, how.target_count,
                        kAnyNumber);
  }
  DeformedMesh mesh;
  mesh.mesh = scene_mesh;
  mesh.node = number;
  mesh.target_count = how.target_count;
  mesh.has_normals = how.has_normals ? 1 : 0;
  mesh.has_tangents = how.has_tangents ? 1 : 0;
  if (has_skin) {
    mesh.influence_count = how.influence_count;
    motion_.influences.insert(motion_.influences.end(), how.influences.begin(),
                              how.influences.end());
  }
  motion_.deltas.insert(motion_.deltas.end(), how.deltas.begin(), how.deltas.end());
  motion_.meshes.push_back(mesh);
  skins_.push_back(has_skin ? **skin : kNoIndex);
  joint_counts_.push_back(how.joint_count);
  return Status::ok();
}

Status GltfMotion::finish() {
  TESSERA_RETURN_IF_ERROR(read_joints());
  for (std::size_t i = 0; i < document_.count("animations"); ++i)
    TESSERA_RETURN_IF_ERROR(read_animation(document_.at("animations", i)));
  leave_out_still();
  if (motion_.channels.empty() && motion_.meshes.empty()) return Status::ok();
  const bool is_still = motion_.channels.empty();
  scene_.animation = std::make_shared<const SceneAnimation>(std::move(motion_));
  if (!is_still) return Status::ok();
  Result<Scene> posed = ScenePoser().at(scene_, 0);
  if (!posed.is_ok()) return posed.status();
  scene_ = *std::move(posed);
  scene_.animation = nullptr;
  return Status::ok();
}

// Skins come after the walk, when all nodes have numbers.
Status GltfMotion::read_joints() {
  for (std::size_t i = 0; i < motion_.meshes.size(); ++i) {
    if (skins_[i] == kNoIndex) continue;
    const auto joints = joints_of(skins_[i]);
    if (!joints.is_ok()) return joints.status();
    DeformedMesh& mesh = motion_.meshes[i];
    mesh.first_joint = joints->first;
    mesh.joint_count = joints->count;
    if (joint_counts_[i] > mesh.joint_count)
      return document_.at("skins", skins_[i])
          .refuse("joints", "are " + std::to_string(mesh.joint_count) +
                                ", but a mesh asks for joint " +
                                std::to_string(joint_counts_[i] - 1));
  }
  return Status::ok();
}

Result<GltfMotion::Joints> GltfMotion::joints_of(std::uint32_t skin_index) {
  if (const auto known = joints_.find(skin_index); known != joints_.end()) return known->second;
  const GltfObject skin = document_.at("skins", skin_index);
  skin.check_keys({"inverseBindMatrices", "joints", "skeleton"}, {});
  const auto nodes = skin.refused_indices("joints", document_.count("nodes"));
  if (!nodes.is_ok()) return nodes.status();
  const auto index = skin.refused_index("inverseBindMatrices", document_.count("accessors"));
  if (!index.is_ok()) return index.status();
  std::optional<GltfAccessor> binds;
  if (*index) {
    auto accessor = GltfAccessor::open(document_, **index);
    if (!accessor.is_ok()) return accessor.status();
    if (accessor->components() != 16 || accessor->count() < nodes->size())
      return skin.refuse("inverseBindMatrices",
                         "is " + accessor->name() + ", which has no matrix for each joint");
    binds = std::move(*accessor);
  }
  const Joints made{static_cast<std::uint32_t>(motion_.joints.size()),
                    static_cast<std::uint32_t>(nodes->size())};
  for (std::size_t k = 0; k < nodes->size(); ++k) {
    const auto number = numbers_.find((*nodes)[k]);
    if (number == numbers_.end())
      return skin.refuse("joints", "hold node " + std::to_string((*nodes)[k]) +
                                       ", which is not in the scene that is drawn");
    const Transform bind = binds ? matrix_of(binds->read_matrix(k)) : Transform{};
    if (!is_finite(bind))
      return skin.refuse("inverseBindMatrices", "of joint " + std::to_string(k) + " is not finite");
    motion_.joints.push_back({number->second, bind});
  }
  joints_[skin_index] = made;
  return made;
}

Status GltfMotion::read_animation(const GltfObject& source) {
  source.check_keys({"channels", "samplers"}, {});
  const std::vector<GltfObject> samplers = source.objects("samplers");
  const std::size_t first = motion_.channels.size();
  for (const GltfObject& channel : source.objects("channels"))
    TESSERA_RETURN_IF_ERROR(read_channel(source, channel, samplers));
  if (motion_.channels.size() == first) return Status::ok();
  std::string name = printable(source.text("name"));
  if (name.empty()) name = "animation " + std::to_string(motion_.clips.size());
  motion_.names.insert(motion_.names.end(), name.begin(), name.end());
  motion_.clips.push_back({static_cast<std::uint32_t>(motion_.channels.size() - first),
                           static_cast<std::uint32_t>(name.size())});
  return Status::ok();
}

Status GltfMotion::read_channel(const GltfObject& animation, const GltfObject& channel,
                                const std::vector<GltfObject>& samplers) {
  channel.check_keys({"sampler", "target"}, {});
  const auto sampler = channel.refused_index("sampler", samplers.size());
  if (!sampler.is_ok()) return sampler.status();
  if (!*sampler) return channel.refuse("sampler", "is missing");
  const GltfObject target = channel.object("target");
  target.check_keys({"node", "path"}, {});
  const auto node = target.refused_index("node", document_.count("nodes"));
  if (!node.is_ok()) return node.status();
  const std::string path_name = target.text("path");
  const auto path = path_named(path_name);
  if (!path) {
    animation.warn("channels", "move '" + printable(path_name) + "', which is not played");
    return Status::ok();
  }
  const auto number = *node ? numbers_.find(**node) : numbers_.end();
  if (number == numbers_.end()) return Status::ok();  // nothing of it is drawn
  MotionChannel made;
  made.node = number->second;
  made.path = *path;
  const MotionNode& moved = motion_.nodes[made.node];
  if (*path == MotionPath::kWeights && moved.weight_count == 0) {
    animation.warn("channels", "move weights of a node without morph targets, and are left out");
    return Status::ok();
  }
  if (*path != MotionPath::kWeights && moved.has_matrix != 0)
    return target.refuse("node", "is one with a matrix, which no animation may move");
  return read_keys(samplers[**sampler], made);
}

Status GltfMotion::read_keys(const GltfObject& sampler, MotionChannel channel) {
  sampler.check_keys({"input", "interpolation", "output"}, {});
  const std::string curve = sampler.text("interpolation");
  if (curve == "STEP") channel.curve = KeyCurve::kStep;
  if (curve == "CUBICSPLINE") channel.curve = KeyCurve::kCubic;
  if (!curve.empty() && curve != "STEP" && curve != "LINEAR" && curve != "CUBICSPLINE")
    return sampler.refuse("interpolation",
                          "is '" + printable(curve) + "'; it must be LINEAR, STEP or CUBICSPLINE");
  std::optional<GltfAccessor> ends[2];
  for (const std::size_t i : {0u, 1u}) {
    const char* key = i == 0 ? "input" : "output";
    const auto index = sampler.refused_index(key, document_.count("accessors"));
    if (!index.is_ok()) return index.status();
    if (!*index) return sampler.refuse(key, "is missing");
    auto accessor = GltfAccessor::open(document_, **index);
    if (!accessor.is_ok()) return accessor.status();
    ends[i] = std::move(*accessor);
  }
  const GltfAccessor &input = *ends[0], &output = *ends[1];
  const std::size_t width = channel_width(motion_, channel);
  const std::size_t expected =
      channel.path == MotionPath::kWeights ? 1 : value_width(motion_, channel);
  if (input.components() != 1 || input.count() == 0)
    return sampler.refuse("input", "is " + input.name() + ", which holds no times");
  if (output.components() != expected || output.count() * expected < input.count() * width)
    return sampler.refuse("output", "is " + output.name() + ", which does not fit its " +
                                        std::to_string(input.count()) + " keys");
  channel.first_key = static_cast<std::uint32_t>(motion_.key_seconds.size());
  channel.key_count = static_cast<std::uint32_t>(input.count());
  channel.first_value = static_cast<std::uint32_t>(motion_.key_values.size());
  for (std::size_t key = 0; key < input.count(); ++key) {
    const float at = input.read(key)[0];
    if (!(at >= 0 && static_cast<double>(at) <= kFrameTimeMaxSeconds))
      return sampler.refuse("input", "of key " + std::to_string(key) + " is no time");
    if (key > 0 && !(at > motion_.key_seconds.back()))
      return sampler.refuse("input", "does not rise at key " + std::to_string(key));
    motion_.key_seconds.push_back(at);
  }
  for (std::size_t i = 0; i < input.count() * width / expected; ++i) {
    const auto value = output.read(i);
    for (std::size_t k = 0; k < expected; ++k) {
      if (!std::isfinite(value[k]))
        return sampler.refuse("output",
                              "of key " + std::to_string(i * expected / width) + " is not finite");
      motion_.key_values.push_back(value[k]);
    }
  }
  motion_.channels.push_back(channel);
  return Status::ok();
}

// Instances, lights and cameras of nodes that no channel moves stay as they were placed.
void GltfMotion::leave_out_still() {
  std::vector<bool> is_moved(motion_.nodes.size(), false);
  for (const MotionChannel& channel : motion_.channels) {
    if (channel.path != MotionPath::kWeights) is_moved[channel.node] = true;
  }
  for (std::size_t i = 0; i < motion_.nodes.size(); ++i) {
    const std::uint32_t parent = motion_.nodes[i].parent;
    if (parent != kNoIndex && is_moved[parent]) is_moved[i] = true;
  }
  const auto is_still = [&](const auto& carried) { return !is_moved[carried.node]; };
  std::erase_if(motion_.instances, is_still);
  std::erase_if(motion_.lights, is_still);
  std::erase_if(motion_.cameras, is_still);
}

}  // namespace tessera::import
