// SPDX-License-Identifier: Apache-2.0
#include "slave/core/primitive/triangle/triangle_store.h"

#include <algorithm>

namespace tessera::core {
namespace {

// Twice the area is zero. In double the differences of float32 vertices are nearly always exact; a
// sliver whose area is lost even there cannot be hit.
bool is_degenerate(Vec3f a, Vec3f b, Vec3f c) {
  const double e1[3] = {double{b.x} - a.x, double{b.y} - a.y, double{b.z} - a.z};
  const double e2[3] = {double{c.x} - a.x, double{c.y} - a.y, double{c.z} - a.z};
  return e1[1] * e2[2] == e1[2] * e2[1] && e1[2] * e2[0] == e1[0] * e2[2] &&
         e1[0] * e2[1] == e1[1] * e2[0];
}

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

std::uint32_t TriangleStore::instance_of(std::uint64_t triangle) const {
  const auto next = std::upper_bound(instance_first.begin(), instance_first.end(), triangle);
  return static_cast<std::uint32_t>(next - instance_first.begin() - 1);
}

void InstanceFinder::find(std::uint64_t triangle) {
  instance_ = triangles_->instance_of(triangle);
  first_ = triangles_->instance_first[instance_];
  count_ = triangles_->instance_first[instance_ + 1] - first_;
}

TriangleStore make_triangle_store(const Scene& scene, std::vector<Bounds3f>& boxes) {
  TriangleStore store;
  std::uint64_t count = 0;
  for (const Instance& instance : scene.instances) {
    store.instance_first.push_back(count);
    count += scene.meshes[instance.mesh]->triangles.size();
  }
  store.instance_first.push_back(count);
  store.vertices.reserve(count * 9);
  boxes.clear();
  boxes.reserve(count);
  for (const Instance& instance : scene.instances) {
    append_mesh(*scene.meshes[instance.mesh], instance.object_to_world, store, boxes);
  }
  return store;
}

}  // namespace tessera::core
