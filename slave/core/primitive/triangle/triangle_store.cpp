// SPDX-License-Identifier: Apache-2.0
#include "slave/core/primitive/triangle/triangle_store.h"

#include <algorithm>

#include "slave/core/primitive/triangle/exact_hit_abi.h"

namespace tessera::core {
namespace {

void append_mesh(const Mesh& mesh, const Transform& to_world, TriangleStore& store,
                 std::vector<Bounds3f>& boxes) {
  const bool is_identity = to_world.is_identity();  // keeps -0.0 and needs no arithmetic
  for (const auto& triangle : mesh.triangles) {
    Vec3f p[3];
    Bounds3f box;
    bool is_finite_all = true;
    for (std::size_t k = 0; k < 3; ++k) {
      const Vec3f local = mesh.positions[triangle[k]];
      p[k] = is_identity ? local : to_world.point(local);
      is_finite_all = is_finite_all && is_finite(p[k]);
      box.grow(p[k]);
      store.vertices.insert(store.vertices.end(), {p[k].x, p[k].y, p[k].z});
    }
    if (!is_finite_all || is_degenerate(p[0], p[1], p[2])) {
      box = Bounds3f{};
      ++store.degenerate_count;
    }
    boxes.push_back(box);
  }
}

}  // namespace

bool is_degenerate(Vec3f a, Vec3f b, Vec3f c) {
  const float triangle[9] = {a.x, a.y, a.z, b.x, b.y, b.z, c.x, c.y, c.z};
  return !has_area(triangle);
}

std::uint32_t TriangleStore::instance_of(std::uint64_t triangle) const {
  const auto next = std::upper_bound(instance_first.begin(), instance_first.end(), triangle);
  return static_cast<std::uint32_t>(next - instance_first.begin() - 1);
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

TriangleStore make_triangle_store(const TriangleSource& source, std::vector<Bounds3f>& boxes) {
  TriangleStore store;
  store.meshes = source.meshes;
  store.instances = source.instances;
  const bool is_flat = source.is_placed.empty();
  const auto is_stored = [&](std::size_t i) { return is_flat || source.is_placed[i] == 0; };
  std::uint64_t count = 0, stored = 0;
  for (std::size_t i = 0; i < source.instances.size(); ++i) {
    const std::uint64_t own = source.meshes[source.instances[i].mesh]->triangles.size();
    store.instance_first.push_back(count);
    if (!is_flat) store.stored_first.push_back(is_stored(i) ? stored : TriangleStore::kNotStored);
    count += own;
    if (is_stored(i)) stored += own;
  }
  store.instance_first.push_back(count);
  store.vertices.reserve(stored * 9);
  boxes.clear();
  boxes.reserve(stored);
  for (std::size_t i = 0; i < source.instances.size(); ++i) {
    const Instance& instance = source.instances[i];
    if (is_stored(i))
      append_mesh(*source.meshes[instance.mesh], instance.object_to_world, store, boxes);
  }
  return store;
}

TriangleStore make_triangle_store(const Scene& scene, std::vector<Bounds3f>& boxes) {
  return make_triangle_store({scene.meshes, scene.instances, {}}, boxes);
}

}  // namespace tessera::core
