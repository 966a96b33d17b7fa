// SPDX-License-Identifier: Apache-2.0
#include "common/scene/pose.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <string>
#include <utility>

#include "common/math/transform_checks.h"
#include "common/scene/motion_curve.h"
#include "common/scene/validate.h"

namespace tessera {
namespace {

// An affine map in double, rows as in Transform.
struct Place {
  std::array<std::array<double, 4>, 3> m{{{1, 0, 0, 0}, {0, 1, 0, 0}, {0, 0, 1, 0}}};
};
using Triple = std::array<double, 3>;

Place operator*(const Place& a, const Place& b) {
  Place r;
  for (std::size_t i = 0; i < 3; ++i) {
    for (std::size_t j = 0; j < 4; ++j) {
      r.m[i][j] = a.m[i][0] * b.m[0][j] + a.m[i][1] * b.m[1][j] + a.m[i][2] * b.m[2][j] +
                  (j == 3 ? a.m[i][3] : 0);
    }
  }
  return r;
}

Place exact(const Transform& t) {
  Place p;
  for (std::size_t i = 0; i < 3; ++i) {
    for (std::size_t j = 0; j < 4; ++j) p.m[i][j] = static_cast<double>(t.m[i][j]);
  }
  return p;
}

Transform rounded(const Place& p) {
  Transform t;
  for (std::size_t i = 0; i < 3; ++i) {
    for (std::size_t j = 0; j < 4; ++j) t.m[i][j] = static_cast<float>(p.m[i][j]);
  }
  return t;
}

Place placed(const Triple& move, const Quaternion& turn, const Triple& scale) {
  const auto [x, y, z, w] = turn;
  const std::array<Triple, 3> rows{
      {{1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)},
       {2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)},
       {2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)}}};
  Place p;
  for (std::size_t i = 0; i < 3; ++i) {
    for (std::size_t j = 0; j < 3; ++j) p.m[i][j] = rows[i][j] * scale[j];
    p.m[i][3] = move[i];
  }
  return p;
}

Triple direction(const Place& p, const Triple& d) {
  Triple r;
  for (std::size_t i = 0; i < 3; ++i) r[i] = p.m[i][0] * d[0] + p.m[i][1] * d[1] + p.m[i][2] * d[2];
  return r;
}

Triple point(const Place& p, const Triple& q) {
  Triple r = direction(p, q);
  for (std::size_t i = 0; i < 3; ++i) r[i] += p.m[i][3];
  return r;
}

// The cofactor matrix times a normal (Transform::normal).
Triple normal(const Place& p, const Triple& n) {
  Triple r{};
  for (std::size_t i = 0; i < 3; ++i) {
    const auto &b = p.m[(i + 1) % 3], &c = p.m[(i + 2) % 3];
    for (std::size_t j = 0; j < 3; ++j) {
      const std::size_t k = (j + 1) % 3, l = (j + 2) % 3;
      r[i] += (b[k] * c[l] - b[l] * c[k]) * n[j];
    }
  }
  return r;
}

Triple widened(Vec3f v) {
  return {static_cast<double>(v.x), static_cast<double>(v.y), static_cast<double>(v.z)};
}

Vec3f narrowed(const Triple& v) {
  return {static_cast<float>(v[0]), static_cast<float>(v[1]), static_cast<float>(v[2])};
}

// At length 1; zero, which stands for a flat normal, where there is no direction.
Triple unit_or_zero(const Triple& v) {
  const double size = std::sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]);
  if (!(size > 0) || !std::isfinite(size)) return {};
  return {v[0] / size, v[1] / size, v[2] / size};
}

Quaternion widened(const Vec4f& q) {
  return {static_cast<double>(q.x), static_cast<double>(q.y), static_cast<double>(q.z),
          static_cast<double>(q.w)};
}

// The nodes of an animation at one time.
class PosedNodes {
 public:
  PosedNodes(const SceneAnimation& animation, double seconds) : animation_(animation) {
    const std::size_t count = animation.nodes.size();
    std::vector<Triple> moves(count), scales(count);
    std::vector<Quaternion> turns(count);
    weights_.assign(animation.weights.begin(), animation.weights.end());
    for (std::size_t i = 0; i < count; ++i) {
      const MotionNode& node = animation.nodes[i];
      moves[i] = widened(node.translation);
      scales[i] = widened(node.scale);
      turns[i] = unit(widened(node.rotation));
    }
    const std::size_t played = animation.clips.empty() ? 0 : animation.clips[0].channel_count;
    for (std::size_t i = 0; i < played; ++i) {
      const MotionChannel& channel = animation.channels[i];
      const MotionNode& node = animation.nodes[channel.node];
      switch (channel.path) {
        case MotionPath::kTranslation:
          sample_channel(animation, channel, seconds, moves[channel.node]);
          break;
        case MotionPath::kRotation:
          sample_channel(animation, channel, seconds, turns[channel.node]);
          break;
        case MotionPath::kScale:
          sample_channel(animation, channel, seconds, scales[channel.node]);
          break;
        case MotionPath::kWeights:
          sample_channel(animation, channel, seconds,
                         std::span(weights_).subspan(node.first_weight, node.weight_count));
          break;
      }
    }
    places_.reserve(count);
    for (std::size_t i = 0; i < count; ++i) {
      const MotionNode& node = animation.nodes[i];
      const Place local =
          node.has_matrix != 0 ? exact(node.matrix) : placed(moves[i], turns[i], scales[i]);
      places_.push_back(node.parent == kNoIndex ? local : places_[node.parent] * local);
    }
  }

  const Place& place(std::uint32_t node) const { return places_[node]; }

  // All that decides how a mesh is deformed: weights, then 12 numbers for each joint.
  std::vector<double> inputs_of(const DeformedMesh& mesh) const {
    const MotionNode& node = animation_.nodes[mesh.node];
    std::vector<double> inputs(weights_.begin() + node.first_weight,
                               weights_.begin() + node.first_weight + mesh.target_count);
    for (std::uint32_t i = 0; i < mesh.joint_count; ++i) {
      const Joint& joint = animation_.joints[mesh.first_joint + i];
      const Place place = places_[joint.node] * exact(joint.inverse_bind);
      for (const auto& row : place.m) inputs.insert(inputs.end(), row.begin(), row.end());
    }
    return inputs;
  }

 private:
  const SceneAnimation& animation_;
  std::vector<double> weights_;
  std::vector<Place> places_;  // in world space
};

// Deforms one mesh.
class Deformation {
 public:
  // influences, deltas: the first of the mesh.
  Deformation(const DeformedMesh& how, const Mesh& rest, const std::vector<double>& inputs,
              const Influence* influences, const Vec3f* deltas)
      : how_(how), rest_(rest), weights_(inputs.data()), influences_(influences), deltas_(deltas) {
    for (std::size_t i = 0; i < how.joint_count; ++i) {
      Place& place = joints_.emplace_back();
      const double* from = inputs.data() + how.target_count + 12 * i;
      for (auto& row : place.m) {
        std::copy(from, from + 4, row.begin());
        from += 4;
      }
    }
  }

  std::shared_ptr<const Mesh> deformed() const {
    auto mesh = std::make_shared<Mesh>(rest_);
    for (std::size_t vertex = 0; vertex < rest_.positions.size(); ++vertex) {
      const Place place = skinned(vertex);
      mesh->positions[vertex] = narrowed(point(place, morphed(rest_.positions[vertex], vertex, 0)));
      if (!rest_.normals.empty()) {
        const Triple n = morphed(rest_.normals[vertex], vertex, how_.has_normals != 0 ? 1 : 3);
        mesh->normals[vertex] = narrowed(unit_or_zero(normal(place, n)));
      }
      if (rest_.tangents.empty()) continue;
      Vec4f& tangent = mesh->tangents[vertex];
      const std::size_t part = how_.has_tangents != 0 ? 1 + how_.has_normals : 3;
      const Triple t = morphed({tangent.x, tangent.y, tangent.z}, vertex, part);
      const Vec3f turned = narrowed(unit_or_zero(direction(place, t)));
      tangent = {turned.x, turned.y, turned.z, tangent.w};
    }
    return mesh;
  }

 private:
  std::size_t parts() const { return 1 + how_.has_normals + how_.has_tangents; }

  // part: which of the targets' arrays; the targets have no part 3.
  Triple morphed(Vec3f rest, std::size_t vertex, std::size_t part) const {
    Triple sum = widened(rest);
    if (part == 3) return sum;
    const std::size_t count = rest_.positions.size();
    for (std::size_t target = 0; target < how_.target_count; ++target) {
      const Triple delta = widened(deltas_[(target * parts() + part) * count + vertex]);
      for (std::size_t i = 0; i < 3; ++i) sum[i] += weights_[target] * delta[i];
    }
    return sum;
  }

  // The weighted mean of the joints' places; the identity for a mesh without a skin.
  Place skinned(std::size_t vertex) const {
    if (joints_.empty()) return {};
    Place sum;
    for (auto& row : sum.m) row.fill(0);
    double weight_sum = 0;
    for (std::size_t i = 0; i < how_.influence_count; ++i) {
      const Influence& influence = influences_[vertex * how_.influence_count + i];
      const auto weight = static_cast<double>(influence.weight);
      if (weight == 0) continue;
      weight_sum += weight;
      for (std::size_t row = 0; row < 3; ++row) {
        for (std::size_t column = 0; column < 4; ++column)
          sum.m[row][column] += weight * joints_[influence.joint].m[row][column];
      }
    }
    for (auto& row : sum.m) {
      for (double& x : row) x /= weight_sum;
    }
    return sum;
  }

  const DeformedMesh& how_;
  const Mesh& rest_;
  const double* const weights_;
  const Influence* const influences_;
  const Vec3f* const deltas_;
  std::vector<Place> joints_;
};

Status not_finite(const char* what, std::size_t index, double seconds) {
  return Status::invalid_argument(std::string(what) + " " + std::to_string(index) +
                                  " is not finite at " + std::to_string(seconds) + " s");
}

Status move_instances(const PosedNodes& nodes, double seconds, Scene& scene) {
  std::vector<bool> is_hidden(scene.instances.size(), false);
  bool is_any_hidden = false;
  for (const MovedInstance& moved : scene.animation->instances) {
    const Transform place = rounded(nodes.place(moved.node) * exact(moved.in_node));
    if (!is_finite(place)) return not_finite("instance", moved.instance, seconds);
    scene.instances[moved.instance].object_to_world = place;
    if (is_singular(place)) is_hidden[moved.instance] = is_any_hidden = true;
  }
  if (!is_any_hidden) return Status::ok();
  std::vector<Instance> shown;
  for (std::size_t i = 0; i < scene.instances.size(); ++i) {
    if (!is_hidden[i]) shown.push_back(scene.instances[i]);
  }
  scene.instances = std::move(shown);
  return Status::ok();
}

// Returns: nothing where no camera can stand.
std::optional<Camera> camera_at(const PosedNodes& nodes, const MovedObject& moved,
                                const Camera& rest) {
  const Camera now = camera_of(rounded(nodes.place(moved.node)), rest.vfov_degrees);
  return validate_camera(now).is_ok() ? std::optional(now) : std::nullopt;
}

// What a lamp or camera of a flattened node would see cannot be said: it stays where it is.
void move_lights_and_cameras(const PosedNodes& nodes, Scene& scene) {
  for (const MovedObject& moved : scene.animation->lights) {
    const Place& place = nodes.place(moved.node);
    Light light = scene.lights[moved.object];
    light.position = narrowed(point(place, {0, 0, 0}));
    light.direction = narrowed(unit_or_zero(direction(place, {0, 0, -1})));
    const bool is_good =
        is_finite(light.position) && is_finite(light.direction) && length(light.direction) > 0;
    if (is_good) scene.lights[moved.object] = light;
  }
  for (const MovedObject& moved : scene.animation->cameras) {
    const Camera before = scene.cameras[moved.object].camera;
    const std::optional<Camera> now = camera_at(nodes, moved, before);
    if (!now) continue;
    scene.cameras[moved.object].camera = *now;
    if (scene.camera && *scene.camera == before) scene.camera = now;
  }
}

// Whether meshes with equal inputs are deformed to the same.
bool deform_alike(const SceneAnimation& a, const SceneAnimation& b) {
  return a.meshes == b.meshes && a.influences == b.influences && a.deltas == b.deltas;
}

}  // namespace

Transform rest_place(const MotionNode& node) {
  if (node.has_matrix != 0) return node.matrix;
  return rounded(
      placed(widened(node.translation), unit(widened(node.rotation)), widened(node.scale)));
}

Camera camera_of(const Transform& to_world, float vfov_degrees) {
  Camera camera;
  camera.eye = to_world.point({0, 0, 0});
  // The target is as far away as the eye's coordinates are large, to keep the direction's digits.
  const Vec3f eye = camera.eye;
  const float reach = 1 + std::fabs(eye.x) + std::fabs(eye.y) + std::fabs(eye.z);
  camera.target = eye + reach * normalize(to_world.direction({0, 0, -1}));
  camera.up = normalize(to_world.direction({0, 1, 0}));
  camera.vfov_degrees = vfov_degrees;
  return camera;
}

std::optional<Camera> moved_camera(const Scene& scene, std::size_t camera, double seconds) {
  if (!scene.animation) return std::nullopt;
  for (const MovedObject& moved : scene.animation->cameras) {
    if (moved.object != camera) continue;
    return camera_at(PosedNodes(*scene.animation, seconds), moved, scene.cameras[camera].camera);
  }
  return std::nullopt;
}

Result<Scene> ScenePoser::at(const Scene& scene, double seconds) {
  if (!scene.animation) return scene;
  const SceneAnimation& animation = *scene.animation;
  const PosedNodes nodes(animation, seconds);
  Scene posed = scene;
  if (animation_ != scene.animation) {
    if (!animation_ || !deform_alike(*animation_, animation)) known_.clear();
    animation_ = scene.animation;
  }
  known_.resize(animation.meshes.size());
  const Influence* influences = animation.influences.data();
  const Vec3f* deltas = animation.deltas.data();
  for (std::size_t i = 0; i < animation.meshes.size(); ++i) {
    const DeformedMesh& how = animation.meshes[i];
    const std::shared_ptr<const Mesh>& rest = scene.meshes[how.mesh];
    std::vector<double> inputs = nodes.inputs_of(how);
    if (known_[i].rest != rest || known_[i].inputs != inputs) {
      known_[i] = {rest, Deformation(how, *rest, inputs, influences, deltas).deformed(), inputs};
    }
    posed.meshes[how.mesh] = known_[i].deformed;
    const std::size_t vertices = rest->positions.size();
    influences += vertices * how.influence_count;
    deltas += vertices * how.target_count * (1 + how.has_normals + how.has_tangents);
    for (const Vec3f& position : known_[i].deformed->positions) {
      if (!is_finite(position)) return not_finite("mesh", how.mesh, seconds);
    }
  }
  TESSERA_RETURN_IF_ERROR(move_instances(nodes, seconds, posed));
  move_lights_and_cameras(nodes, posed);
  return posed;
}

}  // namespace tessera
