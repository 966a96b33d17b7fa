// SPDX-License-Identifier: Apache-2.0
#include "common/scene/validate_animation.h"

#include <cmath>
#include <cstddef>
#include <string>

#include "common/base/limits.h"
#include "common/math/transform_checks.h"

namespace tessera {
namespace {

std::string numbered(const char* what, std::size_t index) {
  return std::string(what) + " " + std::to_string(index);
}

// Refuses `name`, the subject of the line.
Status refused(const std::string& name, const std::string& what) {
  return Status::invalid_argument("animation: " + name + " " + what);
}

// Whether `count` elements from `first` on lie in an array of `size`.
bool fits(std::uint64_t first, std::uint64_t count, std::size_t size) {
  return first <= size && count <= size - first;
}

Status validate_nodes(const SceneAnimation& a) {
  if (a.nodes.size() > kAnimationNodesMax)
    return Status::resource_exhausted("animation: more than " + std::to_string(kAnimationNodesMax) +
                                      " nodes");
  for (std::size_t i = 0; i < a.nodes.size(); ++i) {
    const MotionNode& node = a.nodes[i];
    const std::string name = numbered("node", i);
    if (node.parent != kNoIndex && node.parent >= i)
      return refused(name, "comes before its parent");
    if (node.has_matrix > 1) return refused(name, "has a place of no kind that there is");
    const Vec4f& q = node.rotation;
    if (!is_finite(node.translation) || !is_finite(q) || !is_finite(node.scale) ||
        !is_finite(node.matrix))
      return refused(name, "has a place that is not finite");
    if (q.x == 0 && q.y == 0 && q.z == 0 && q.w == 0)
      return refused(name, "has a rotation of length 0");
    if (!fits(node.first_weight, node.weight_count, a.weights.size()))
      return refused(name, "has weights that are not there");
  }
  for (std::size_t i = 0; i < a.weights.size(); ++i) {
    if (!std::isfinite(a.weights[i])) return refused(numbered("weight", i), "is not finite");
  }
  return Status::ok();
}

Status validate_keys(const SceneAnimation& a, const MotionChannel& channel,
                     const std::string& name) {
  if (channel.key_count == 0) return refused(name, "has no keys");
  if (!fits(channel.first_key, channel.key_count, a.key_seconds.size()))
    return refused(name, "has keys that are not there");
  const std::uint64_t values = std::uint64_t{channel.key_count} * channel_width(a, channel);
  if (!fits(channel.first_value, values, a.key_values.size()))
    return refused(name, "has values that are not there");
  for (std::size_t i = 0; i < channel.key_count; ++i) {
    const float at = a.key_seconds[channel.first_key + i];
    if (!(at >= 0 && static_cast<double>(at) <= kFrameTimeMaxSeconds))
      return refused(name, "has a time that is not in [0, a year], of key " + std::to_string(i));
    if (i > 0 && !(at > a.key_seconds[channel.first_key + i - 1]))
      return refused(name, "has times that do not rise, at key " + std::to_string(i));
  }
  for (std::uint64_t i = 0; i < values; ++i) {
    if (!std::isfinite(a.key_values[channel.first_value + i]))
      return refused(name, "has a value that is not finite, of key " +
                               std::to_string(i / channel_width(a, channel)));
  }
  return Status::ok();
}

Status validate_channels(const SceneAnimation& a) {
  for (std::size_t i = 0; i < a.channels.size(); ++i) {
    const MotionChannel& channel = a.channels[i];
    const std::string name = numbered("channel", i);
    if (channel.node >= a.nodes.size()) return refused(name, "moves a node that is not there");
    if (channel.path > MotionPath::kWeights || channel.curve > KeyCurve::kCubic)
      return refused(name, "is of no kind that there is");
    const MotionNode& node = a.nodes[channel.node];
    if (channel.path == MotionPath::kWeights && node.weight_count == 0)
      return refused(name, "moves weights of a node without morph targets");
    if (channel.path != MotionPath::kWeights && node.has_matrix != 0)
      return refused(name, "moves a node that has a matrix");
    TESSERA_RETURN_IF_ERROR(validate_keys(a, channel, name));
  }
  std::uint64_t channels = 0, name_bytes = 0;
  for (const MotionClip& clip : a.clips) {
    channels += clip.channel_count;
    name_bytes += clip.name_bytes;
  }
  if (channels != a.channels.size() || name_bytes != a.names.size())
    return Status::invalid_argument("animation: clips do not fit channels and names");
  return Status::ok();
}

Status validate_moved(const SceneAnimation& a, const Scene& scene) {
  for (std::size_t i = 0; i < a.instances.size(); ++i) {
    const MovedInstance& moved = a.instances[i];
    if (moved.instance >= scene.instances.size() || moved.node >= a.nodes.size())
      return refused(numbered("moved instance", i), "names what is not there");
    if (!is_finite(moved.in_node))
      return refused(numbered("moved instance", i), "has a place that is not finite");
  }
  const auto are_there = [&](const std::vector<MovedObject>& objects, std::size_t count) {
    for (const MovedObject& moved : objects) {
      if (moved.object >= count || moved.node >= a.nodes.size()) return false;
    }
    return true;
  };
  if (!are_there(a.lights, scene.lights.size()))
    return refused("a moved light", "names what is not there");
  if (!are_there(a.cameras, scene.cameras.size()))
    return refused("a moved camera", "names what is not there");
  for (std::size_t i = 0; i < a.joints.size(); ++i) {
    if (a.joints[i].node >= a.nodes.size())
      return refused(numbered("joint", i), "names a node that is not there");
    if (!is_finite(a.joints[i].inverse_bind))
      return refused(numbered("joint", i), "has a matrix that is not finite");
  }
  return Status::ok();
}

// influences: those of the mesh.
Status validate_influences(const DeformedMesh& how, std::size_t vertices,
                           const Influence* influences, const std::string& name) {
  for (std::size_t vertex = 0; how.influence_count > 0 && vertex < vertices; ++vertex) {
    float sum = 0;
    for (std::size_t i = 0; i < how.influence_count; ++i) {
      const Influence& influence = influences[vertex * how.influence_count + i];
      const std::string which = numbered("vertex", vertex) + " of " + name;
      if (influence.joint >= how.joint_count) return refused(which, "has a joint out of range");
      if (!(influence.weight >= 0) || !std::isfinite(influence.weight))
        return refused(which, "has a weight that is not finite or below 0");
      sum += influence.weight;
    }
    if (!(sum > 0) || !std::isfinite(sum))
      return refused(numbered("vertex", vertex) + " of " + name, "has weights that sum to 0");
  }
  return Status::ok();
}

Status validate_deformed(const SceneAnimation& a, const Scene& scene) {
  std::uint64_t influences = 0, deltas = 0;
  for (std::size_t i = 0; i < a.meshes.size(); ++i) {
    const DeformedMesh& how = a.meshes[i];
    const std::string name = numbered("deformed mesh", i);
    if (how.mesh >= scene.meshes.size() || how.node >= a.nodes.size())
      return refused(name, "names what is not there");
    if (how.has_normals > 1 || how.has_tangents > 1)
      return refused(name, "is of no kind that there is");
    const bool has_skin = how.first_joint != kNoIndex;
    if (has_skin ? how.joint_count == 0 || how.influence_count == 0 ||
                       !fits(how.first_joint, how.joint_count, a.joints.size())
                 : how.joint_count != 0 || how.influence_count != 0)
      return refused(name, "has joints that do not fit");
    if (how.influence_count > kInfluencesMax)
      return refused(name, "has more than " + std::to_string(kInfluencesMax) + " joints a vertex");
    if (how.target_count > a.nodes[how.node].weight_count)
      return refused(name, "has more morph targets than weights");
    const std::uint64_t vertices = scene.meshes[how.mesh]->positions.size();
    const std::uint64_t vectors = vertices * (1 + how.has_normals + how.has_tangents);
    if (!fits(influences, vertices * how.influence_count, a.influences.size()))
      return refused(name, "has fewer weights than vertices");
    if (how.target_count > 0 && (vectors > a.deltas.size() / how.target_count ||
                                 !fits(deltas, vectors * how.target_count, a.deltas.size())))
      return refused(name, "has fewer differences than its targets have vertices");
    TESSERA_RETURN_IF_ERROR(
        validate_influences(how, vertices, a.influences.data() + influences, name));
    influences += vertices * how.influence_count;
    deltas += vectors * how.target_count;
  }
  if (influences != a.influences.size() || deltas != a.deltas.size())
    return Status::invalid_argument("animation: there are more weights or differences than meshes");
  for (std::size_t i = 0; i < a.deltas.size(); ++i) {
    if (!is_finite(a.deltas[i])) return refused(numbered("difference", i), "is not finite");
  }
  return Status::ok();
}

}  // namespace

Status validate_animation(const SceneAnimation& animation, const Scene& scene) {
  TESSERA_RETURN_IF_ERROR(validate_nodes(animation));
  TESSERA_RETURN_IF_ERROR(validate_channels(animation));
  TESSERA_RETURN_IF_ERROR(validate_moved(animation, scene));
  return validate_deformed(animation, scene);
}

}  // namespace tessera
