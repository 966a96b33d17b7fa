// SPDX-License-Identifier: Apache-2.0
// What of a scene moves with time, as plain values (after glTF 2.0, sections 3.7.3 and 3.11): a
// forest of nodes, curves over their places and weights, the instances and lights that nodes carry,
// and the meshes that skins and morph targets deform. It travels once, as a block of its own; the
// scene of a time is made where it is needed (pose.h).
//
// Units. Seconds; lengths in scene units. Threads. Plain values. validate_animation() is the border
// (validate_animation.h).
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "common/base/api.h"
#include "common/math/transform.h"
#include "common/math/vec3.h"

namespace tessera {

inline constexpr std::uint32_t kNoIndex = 0xffffffffu;  // no parent, no skin, no clip

// A node's place below its parent at rest.
struct MotionNode {
  std::uint32_t parent = kNoIndex;  // an earlier node
  std::uint32_t has_matrix = 0;     // 1: `matrix` is the place; 0: translation * rotation * scale
  Vec3f translation{0, 0, 0};
  Vec4f rotation{0, 0, 0, 1};  // quaternion x, y, z, w of any length but 0
  Vec3f scale{1, 1, 1};
  Transform matrix;
  std::uint32_t first_weight = 0;  // in SceneAnimation::weights: those of its morph targets at rest
  std::uint32_t weight_count = 0;
  bool operator==(const MotionNode&) const = default;
};

enum class MotionPath : std::uint32_t { kTranslation = 0, kRotation = 1, kScale = 2, kWeights = 3 };

enum class KeyCurve : std::uint32_t {
  kStep = 0,    // the last key's value
  kLinear = 1,  // between two keys; rotations along the shorter great arc
  kCubic = 2    // Hermite; each key has the tangent in, the value, the tangent out
};

// Keys of one property of one node. Before the first key and behind the last one it stands still.
struct MotionChannel {
  std::uint32_t node = 0;
  MotionPath path = MotionPath::kTranslation;
  KeyCurve curve = KeyCurve::kLinear;
  std::uint32_t first_key = 0;  // in SceneAnimation::key_seconds, rising
  std::uint32_t key_count = 0;  // at least 1
  // In SceneAnimation::key_values: 3 numbers a key, 4 of a rotation, or the node's weight_count;
  // of kCubic three times as many.
  std::uint32_t first_value = 0;
  bool operator==(const MotionChannel&) const = default;
};

// A named animation of the file: the channels that follow those of the clip before.
struct MotionClip {
  std::uint32_t channel_count = 0;
  std::uint32_t name_bytes = 0;  // in SceneAnimation::names, behind those of the clip before
  bool operator==(const MotionClip&) const = default;
};

// An instance that goes with a node. Its object_to_world is the node's place times `in_node`.
struct MovedInstance {
  std::uint32_t instance = 0;  // into Scene::instances
  std::uint32_t node = 0;
  Transform in_node;
  bool operator==(const MovedInstance&) const = default;
};

// A light or a camera that goes with a node, along its -z axis.
struct MovedObject {
  std::uint32_t object = 0;  // into Scene::lights, or Scene::cameras
  std::uint32_t node = 0;
  bool operator==(const MovedObject&) const = default;
};

struct Joint {
  std::uint32_t node = 0;
  Transform inverse_bind;  // from the mesh to the joint at rest
  bool operator==(const Joint&) const = default;
};

struct Influence {
  std::uint32_t joint = 0;  // among those of the mesh's skin
  float weight = 0;         // >= 0; those of a vertex sum to 1 within rounding
  bool operator==(const Influence&) const = default;
};

// A mesh whose vertices move: first by morph targets, then by its skin, which brings them to world
// space (its instances stand at the identity).
struct DeformedMesh {
  std::uint32_t mesh = 0;                // into Scene::meshes
  std::uint32_t node = 0;                // whose weights the morph targets have
  std::uint32_t first_joint = kNoIndex;  // into SceneAnimation::joints; kNoIndex: no skin
  std::uint32_t joint_count = 0;
  std::uint32_t influence_count = 0;  // for each vertex
  std::uint32_t target_count = 0;     // morph targets, at most the node's weight_count
  std::uint32_t has_normals = 0, has_tangents = 0;  // 1: the targets move them as well
  bool operator==(const DeformedMesh&) const = default;
};

struct SceneAnimation {
  std::vector<MotionNode> nodes;
  std::vector<float> weights;
  std::vector<MotionClip> clips;
  std::vector<char> names;
  std::vector<MotionChannel> channels;
  std::vector<float> key_seconds;  // >= 0
  std::vector<float> key_values;
  std::vector<MovedInstance> instances;
  std::vector<MovedObject> lights, cameras;
  std::vector<Joint> joints;
  std::vector<DeformedMesh> meshes;
  // Of the deformed meshes in their order: [vertex_count][influence_count].
  std::vector<Influence> influences;
  // Of the deformed meshes in their order, of each target of theirs: what it adds to the positions
  // [vertex_count], then to the normals and to the tangents where it moves them.
  std::vector<Vec3f> deltas;
  bool operator==(const SceneAnimation&) const = default;

  std::vector<std::string> clip_names() const;
  double duration_seconds() const;  // the last key of any clip; 0 without keys
};

// Numbers in a value of a channel, and in all that one of its keys has.
// Requires: the channel's node is there.
std::size_t value_width(const SceneAnimation& animation, const MotionChannel& channel);
std::size_t channel_width(const SceneAnimation& animation, const MotionChannel& channel);

// Copies the animation with one clip alone, or with all of them as one where clip is kNoIndex.
// Requires: clip < clips.size() or kNoIndex; a validated animation.
TESSERA_API SceneAnimation with_clip(const SceneAnimation& animation, std::uint32_t clip);

}  // namespace tessera
