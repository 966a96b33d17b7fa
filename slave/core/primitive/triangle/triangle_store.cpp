// SPDX-License-Identifier: Apache-2.0
#include "slave/core/primitive/triangle/triangle_store.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "common/base/work_gate.h"
#include "slave/core/primitive/triangle/exact_hit_abi.h"

namespace tessera::core {
namespace {

void append_mesh(const Mesh& mesh, const Transform& to_world, std::vector<float>& vertices) {
  const bool is_identity = to_world.is_identity();  // keeps -0.0 and needs no arithmetic
  SmallSteps steps;
  for (const auto& triangle : mesh.triangles) {
    steps.next();
    for (const std::uint32_t corner : triangle) {
      const Vec3f local = mesh.positions[corner];
      const Vec3f p = is_identity ? local : to_world.point(local);
      vertices.insert(vertices.end(), {p.x, p.y, p.z});
    }
  }
}

// Shape: triangle [3 corners][x, y, z]. Whether it is in the tree.
bool has_box(const float* triangle) {
  return std::all_of(triangle, triangle + 9, [](float x) { return std::isfinite(x); }) &&
         has_area(triangle);
}

// Returns: a store without corners.
TriangleStore numbered_store(const TriangleSource& source) {
  TriangleStore store;
  store.meshes = source.meshes;
  store.instances = source.instances;
  std::uint64_t count = 0, stored = 0;
  for (std::size_t i = 0; i < source.instances.size(); ++i) {
    const std::uint64_t own = source.primitive_count(i);
    store.instance_first.push_back(count);
    if (!source.is_placed.empty() || !source.other_counts.empty())
      store.stored_first.push_back(source.is_stored(i) ? stored : TriangleStore::kNotStored);
    count += own;
    if (source.is_stored(i)) stored += own;
  }
  store.instance_first.push_back(count);
  return store;
}

}  // namespace

bool is_degenerate(Vec3f a, Vec3f b, Vec3f c) {
  const float triangle[9] = {a.x, a.y, a.z, b.x, b.y, b.z, c.x, c.y, c.z};
  return !has_area(triangle);
}

std::uint32_t TriangleStore::instance_of(std::uint64_t triangle) const {
  // Rays that bounce ask for one instance after another, so that no branch may depend on which.
  const std::uint64_t* from = instance_first.data();
  for (std::size_t left = instance_first.size(); left > 1; left -= left / 2)
    from += from[left / 2] <= triangle ? left / 2 : 0;
  return static_cast<std::uint32_t>(from - instance_first.data());
}

void InstanceFinder::find(std::uint64_t triangle) {
  instance_ = triangles_.instance_of(triangle);
  first_ = triangles_.instance_first[instance_];
  count_ = triangles_.instance_first[instance_ + 1] - first_;
}

Vec3f TriangleStore::vertex_of(std::uint32_t instance, std::uint64_t triangle, int corner) const {
  if (is_flat()) return stored_vertex(triangle, corner);
  const std::uint64_t local = triangle - instance_first[instance];
  if (stored_first[instance] != kNotStored)
    return stored_vertex(stored_first[instance] + local, corner);
  const Instance& placed = instances[instance];
  const Mesh& mesh = *meshes[placed.mesh];
  const Vec3f at = mesh.positions[mesh.triangles[local][static_cast<std::size_t>(corner)]];
  return placed.object_to_world.is_identity() ? at : placed.object_to_world.point(at);
}

std::vector<Bounds3f> boxes_of(std::span<const float> vertices) {
  std::vector<Bounds3f> boxes;
  boxes.reserve(vertices.size() / 9);
  SmallSteps steps;
  for (std::size_t at = 0; at < vertices.size(); at += 9) {
    steps.next();
    const float* const p = vertices.data() + at;
    Bounds3f box;
    if (has_box(p)) {
      box.grow(Vec3f{p[0], p[1], p[2]});
      box.grow(Vec3f{p[3], p[4], p[5]});
      box.grow(Vec3f{p[6], p[7], p[8]});
    }
    boxes.push_back(box);
  }
  return boxes;
}

std::vector<std::uint64_t> without_box(std::span<const float> vertices) {
  std::vector<std::uint64_t> numbers;
  SmallSteps steps;
  for (std::size_t at = 0; at < vertices.size(); at += 9) {
    steps.next();
    if (!has_box(vertices.data() + at)) numbers.push_back(at / 9);
  }
  return numbers;
}

TriangleStore make_triangle_store(const TriangleSource& source) {
  TriangleStore store = numbered_store(source);
  std::vector<float> vertices;
  std::uint64_t stored = 0;
  for (std::size_t i = 0; i < source.instances.size(); ++i) {
    if (source.is_stored(i)) stored += store.instance_first[i + 1] - store.instance_first[i];
  }
  vertices.reserve(stored * 9);
  for (std::size_t i = 0; i < source.instances.size(); ++i) {
    const Instance& instance = source.instances[i];
    if (source.is_stored(i))
      append_mesh(*source.meshes[instance.mesh], instance.object_to_world, vertices);
  }
  store.keep(std::move(vertices));
  return store;
}

TriangleStore make_triangle_store(const TriangleSource& source, std::vector<Bounds3f>& boxes) {
  TriangleStore store = make_triangle_store(source);
  boxes = boxes_of(store.vertices);
  store.degenerate_count = static_cast<std::uint64_t>(std::count_if(
      boxes.begin(), boxes.end(), [](const Bounds3f& box) { return box.is_empty(); }));
  return store;
}

TriangleStore make_triangle_store(const TriangleSource& source, const TriangleStore& known) {
  TriangleStore store = numbered_store(source);
  store.kept = known.kept;
  store.vertices = *store.kept;
  return store;
}

TriangleStore make_triangle_store(const Scene& scene, std::vector<Bounds3f>& boxes) {
  return make_triangle_store({scene.meshes, scene.instances, {}}, boxes);
}

}  // namespace tessera::core
