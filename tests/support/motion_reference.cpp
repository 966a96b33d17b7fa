// SPDX-License-Identifier: Apache-2.0
#include "tests/support/motion_reference.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "common/scene/animation.h"

namespace tessera::test {
namespace {

using Numbers = std::vector<double>;

Matrix4 identity() {
  Matrix4 m{};
  for (std::size_t i = 0; i < 4; ++i) m[i][i] = 1;
  return m;
}

Matrix4 product(const Matrix4& a, const Matrix4& b) {
  Matrix4 r{};
  for (std::size_t i = 0; i < 4; ++i) {
    for (std::size_t j = 0; j < 4; ++j) {
      for (std::size_t k = 0; k < 4; ++k) r[i][j] += a[i][k] * b[k][j];
    }
  }
  return r;
}

Matrix4 matrix_of(const Transform& t) {
  Matrix4 m = identity();
  for (std::size_t i = 0; i < 3; ++i) {
    for (std::size_t j = 0; j < 4; ++j) m[i][j] = static_cast<double>(t.m[i][j]);
  }
  return m;
}

Numbers normalised(Numbers q) {
  const double size = std::sqrt(std::inner_product(q.begin(), q.end(), q.begin(), 0.0));
  for (double& x : q) x /= size;
  return q;
}

// The spherical interpolation of appendix C.4.
Numbers turned(const Numbers& a, Numbers b, double t) {
  double d = std::inner_product(a.begin(), a.end(), b.begin(), 0.0);
  if (d < 0) {
    for (double& x : b) x = -x;
    d = -d;
  }
  const double angle = std::acos(std::min(d, 1.0));
  Numbers r(4);
  for (std::size_t i = 0; i < 4; ++i) {
    r[i] = angle < 1e-7
               ? (1 - t) * a[i] + t * b[i]
               : (std::sin((1 - t) * angle) * a[i] + std::sin(t * angle) * b[i]) / std::sin(angle);
  }
  return r;
}

Numbers value_at(const SceneAnimation& a, const MotionChannel& c, double seconds) {
  const std::size_t width = value_width(a, c);
  const bool is_cubic = c.curve == KeyCurve::kCubic, is_turn = c.path == MotionPath::kRotation;
  // part: 0 tangent in, 1 value, 2 tangent out.
  const auto numbers = [&](std::size_t key, std::size_t part) {
    const std::size_t first =
        c.first_value + key * width * (is_cubic ? 3 : 1) + (is_cubic ? part * width : 0);
    Numbers all;
    for (std::size_t i = 0; i < width; ++i)
      all.push_back(static_cast<double>(a.key_values[first + i]));
    return is_turn && !is_cubic ? normalised(all) : all;
  };
  const auto time = [&](std::size_t key) {
    return static_cast<double>(a.key_seconds[c.first_key + key]);
  };
  std::size_t key = 0;
  while (key + 1 < c.key_count && time(key + 1) <= seconds) ++key;
  Numbers value = numbers(key, 1);
  if (seconds > time(0) && key + 1 < c.key_count && c.curve != KeyCurve::kStep) {
    const double span = time(key + 1) - time(key), t = (seconds - time(key)) / span;
    const Numbers next = numbers(key + 1, 1);
    if (is_cubic) {
      const Numbers out = numbers(key, 2), in = numbers(key + 1, 0);
      for (std::size_t i = 0; i < width; ++i) {
        value[i] = (2 * t * t * t - 3 * t * t + 1) * value[i] +
                   span * (t * t * t - 2 * t * t + t) * out[i] +
                   (-2 * t * t * t + 3 * t * t) * next[i] + span * (t * t * t - t * t) * in[i];
      }
    } else if (is_turn) {
      value = turned(value, next, t);
    } else {
      for (std::size_t i = 0; i < width; ++i) value[i] = (1 - t) * value[i] + t * next[i];
    }
  }
  return is_turn ? normalised(value) : value;
}

// The value of a property, or `rest` where no channel moves it; the last channel counts.
Numbers property(const SceneAnimation& a, std::uint32_t node, MotionPath path, double seconds,
                 Numbers rest) {
  const std::size_t count = a.clips.empty() ? 0 : a.clips[0].channel_count;
  for (std::size_t i = 0; i < count; ++i) {
    if (a.channels[i].node == node && a.channels[i].path == path)
      rest = value_at(a, a.channels[i], seconds);
  }
  return rest;
}

Numbers numbers_of(Vec3f v) {
  return {static_cast<double>(v.x), static_cast<double>(v.y), static_cast<double>(v.z)};
}

}  // namespace

Matrix4 reference_place(const SceneAnimation& a, std::uint32_t number, double seconds) {
  const MotionNode& node = a.nodes[number];
  Matrix4 local = matrix_of(node.matrix);
  if (node.has_matrix == 0) {
    const Vec4f& rest = node.rotation;
    const Numbers move =
        property(a, number, MotionPath::kTranslation, seconds, numbers_of(node.translation));
    const Numbers scale = property(a, number, MotionPath::kScale, seconds, numbers_of(node.scale));
    const Numbers q =
        normalised(property(a, number, MotionPath::kRotation, seconds,
                            {static_cast<double>(rest.x), static_cast<double>(rest.y),
                             static_cast<double>(rest.z), static_cast<double>(rest.w)}));
    // The rotation as the product of two 4x4 matrices of the quaternion.
    const Matrix4 left{{{q[3], -q[2], q[1], q[0]},
                        {q[2], q[3], -q[0], q[1]},
                        {-q[1], q[0], q[3], q[2]},
                        {-q[0], -q[1], -q[2], q[3]}}};
    const Matrix4 right{{{q[3], -q[2], q[1], -q[0]},
                         {q[2], q[3], -q[0], -q[1]},
                         {-q[1], q[0], q[3], -q[2]},
                         {q[0], q[1], q[2], q[3]}}};
    Matrix4 moved = identity(), scaled = identity();
    for (std::size_t i = 0; i < 3; ++i) {
      moved[i][3] = move[i];
      scaled[i][i] = scale[i];
    }
    local = product(moved, product(product(left, right), scaled));
  }
  return node.parent == kNoIndex ? local : product(reference_place(a, node.parent, seconds), local);
}

std::vector<std::array<double, 3>> reference_vertices(const Scene& scene, std::size_t deformed,
                                                      double seconds) {
  const SceneAnimation& a = *scene.animation;
  std::size_t influence = 0, delta = 0;
  for (std::size_t i = 0; i < deformed; ++i) {
    const DeformedMesh& other = a.meshes[i];
    const std::size_t vertices = scene.meshes[other.mesh]->positions.size();
    influence += vertices * other.influence_count;
    delta += vertices * other.target_count * (1 + other.has_normals + other.has_tangents);
  }
  const DeformedMesh& how = a.meshes[deformed];
  const MotionNode& node = a.nodes[how.node];
  Numbers weights;
  for (std::size_t i = 0; i < node.weight_count; ++i)
    weights.push_back(static_cast<double>(a.weights[node.first_weight + i]));
  weights = property(a, how.node, MotionPath::kWeights, seconds, weights);
  std::vector<Matrix4> joints;
  for (std::size_t i = 0; i < how.joint_count; ++i) {
    const Joint& joint = a.joints[how.first_joint + i];
    joints.push_back(
        product(reference_place(a, joint.node, seconds), matrix_of(joint.inverse_bind)));
  }
  const std::vector<Vec3f>& rest = scene.meshes[how.mesh]->positions;
  std::vector<std::array<double, 3>> all;
  for (std::size_t v = 0; v < rest.size(); ++v) {
    Numbers p = numbers_of(rest[v]);
    for (std::size_t t = 0; t < how.target_count; ++t) {
      const std::size_t parts = 1 + how.has_normals + how.has_tangents;
      const Numbers d = numbers_of(a.deltas[delta + t * parts * rest.size() + v]);
      for (std::size_t i = 0; i < 3; ++i) p[i] += weights[t] * d[i];
    }
    p.push_back(1);
    std::array<double, 4> sum{};
    double weight_sum = 0;
    for (std::size_t k = 0; k < how.influence_count; ++k) {
      const Influence& pull = a.influences[influence + v * how.influence_count + k];
      const auto weight = static_cast<double>(pull.weight);
      weight_sum += weight;
      for (std::size_t i = 0; weight > 0 && i < 4; ++i) {
        for (std::size_t j = 0; j < 4; ++j) sum[i] += weight * joints[pull.joint][i][j] * p[j];
      }
    }
    if (how.influence_count == 0) {
      all.push_back({p[0], p[1], p[2]});
    } else {
      all.push_back({sum[0] / weight_sum, sum[1] / weight_sum, sum[2] / weight_sum});
    }
  }
  return all;
}

}  // namespace tessera::test
