// SPDX-License-Identifier: Apache-2.0
// All triangles of a scene version in world space, in the numbering of the flattened scene. Other
// primitives that instances hold have numbers there, too, and no corners.
// Triangles of flattened instances are stored; corners of others are brought to world space when
// they are asked for, by the same operations, and have the same bits.
//
// Threads. Filled once by make_triangle_store(), then read by any thread.
//
// Invariant. A vertex that triangles of one instance share has the same bits in each of them; the
// watertight test relies on it.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <utility>
#include <vector>

#include "common/math/bounds3.h"
#include "common/scene/scene.h"

namespace tessera::core {

// Whether a triangle has no area: has_area() of exact_hit_abi.h.
bool is_degenerate(Vec3f a, Vec3f b, Vec3f c);

struct TriangleStore {
  // [flattened triangle][3 vertices][x, y, z], world units
  std::span<const float> vertices;
  std::shared_ptr<const std::vector<float>> kept;  // `vertices`; versions of a scene share them
  // [instance_count + 1] number of the first primitive of each
  std::vector<std::uint64_t> instance_first;
  // [instance_count] where the triangles of each instance begin in `vertices`, or kNotStored. Empty
  // where all instances are flattened; then numbers are places in `vertices`.
  std::vector<std::uint64_t> stored_first;
  // What triangles that are not stored are made of; the caller keeps it where it is.
  std::span<const std::shared_ptr<const Mesh>> meshes;
  std::span<const Instance> instances;
  std::uint64_t degenerate_count = 0;

  static constexpr std::uint64_t kNotStored = ~std::uint64_t{0};

  void keep(std::vector<float> corners) {
    kept = std::make_shared<const std::vector<float>>(std::move(corners));
    vertices = *kept;
  }
  bool is_flat() const { return stored_first.empty(); }
  // Of all primitives that rays ask for; in scenes of meshes alone, of triangles.
  std::uint64_t primitive_count() const { return instance_first.back(); }
  Vec3f vertex(std::uint64_t triangle, int corner) const {
    if (!is_flat()) return vertex_of(instance_of(triangle), triangle, corner);
    return stored_vertex(triangle, corner);
  }
  // vertex() where the triangle's instance is known.
  Vec3f vertex_of(std::uint32_t instance, std::uint64_t triangle, int corner) const;
  // The instance that a triangle belongs to. O(log instances).
  std::uint32_t instance_of(std::uint64_t triangle) const;

 private:
  Vec3f stored_vertex(std::uint64_t at, int corner) const {
    const float* p = vertices.data() + at * 9 + static_cast<std::uint64_t>(corner) * 3;
    return {p[0], p[1], p[2]};
  }
};

// Finds the instances of triangles. It remembers the one that was asked for last, which neighbours
// on the picture mostly share.
class InstanceFinder {
 public:
  // Requires: triangles outlives it.
  explicit InstanceFinder(const TriangleStore& triangles) : triangles_(triangles) {}

  std::uint32_t of(std::uint64_t triangle) {
    if (triangle - first_ >= count_) find(triangle);
    return instance_;
  }
  // The first triangle of the instance that was asked for last.
  std::uint64_t first_triangle() const { return first_; }

 private:
  void find(std::uint64_t triangle);

  const TriangleStore& triangles_;
  std::uint64_t first_ = 0, count_ = 0;  // triangles of instance_
  std::uint32_t instance_ = 0;
};

// What a store is made of: parts of a scene for which validate_scene() is ok.
struct TriangleSource {
  std::span<const std::shared_ptr<const Mesh>> meshes;
  std::span<const Instance> instances;
  // [instance_count]: 1 where an instance is not flattened, or empty where all are.
  std::span<const std::uint8_t> is_placed;
  // [instance_count]: primitives of instances that are no meshes, which are not flattened either.
  // Empty where all are meshes.
  std::span<const std::uint64_t> other_counts = {};

  bool is_mesh(std::size_t instance) const { return instances[instance].kind == ObjectKind::kMesh; }
  bool is_stored(std::size_t instance) const {
    return is_mesh(instance) && (is_placed.empty() || is_placed[instance] == 0);
  }
  std::uint64_t primitive_count(std::size_t instance) const {
    return is_mesh(instance) ? meshes[instances[instance].mesh]->triangles.size()
                             : other_counts[instance];
  }
};

// Shape: vertices [triangle][3][3]. Returns: a box for each; a triangle without area, or one that a
// transform sends beyond float32, gets an empty box: it keeps its number and stays out of the tree.
std::vector<Bounds3f> boxes_of(std::span<const float> vertices);

// Returns: the numbers of triangles that get an empty box from boxes_of(), rising.
std::vector<std::uint64_t> without_box(std::span<const float> vertices);

// Returns: a store of flattened triangles whose boxes the caller makes, as it counts those without
// area.
TriangleStore make_triangle_store(const TriangleSource& source);
// Shape: boxes becomes boxes_of() the flattened triangles. Requires: meshes and instances stay
// where they are, if any are placed.
TriangleStore make_triangle_store(const TriangleSource& source, std::vector<Bounds3f>& boxes);
// Takes corners from the store of another version whose flattened instances are the same; the
// caller counts those without area.
TriangleStore make_triangle_store(const TriangleSource& source, const TriangleStore& known);
TriangleStore make_triangle_store(const Scene& scene, std::vector<Bounds3f>& boxes);

}  // namespace tessera::core
