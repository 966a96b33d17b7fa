// SPDX-License-Identifier: Apache-2.0
#include "common/viewpoint/support_map.h"

#include <algorithm>
#include <limits>

namespace tessera {
namespace {

constexpr double kNothing = -std::numeric_limits<double>::infinity();

Vec3d to_world(const Transform& t, Vec3f p) {
  const auto row = [&](std::size_t i) {
    return double{t.m[i][0]} * p.x + double{t.m[i][1]} * p.y + double{t.m[i][2]} * p.z + t.m[i][3];
  };
  return {row(0), row(1), row(2)};
}

// A plane's normal and offset in the space of an instance: normal . p + offset is the height of
// point p of the mesh along the direction in the world.
struct Height {
  Vec3d normal;
  double offset = 0;

  Height(const Transform& t, Vec3d d) {
    const auto column = [&](std::size_t j) {
      return d.x * t.m[0][j] + d.y * t.m[1][j] + d.z * t.m[2][j];
    };
    normal = {column(0), column(1), column(2)};
    offset = column(3);
  }
  double of(Vec3f p) const { return normal.x * p.x + normal.y * p.y + normal.z * p.z + offset; }
  // Upper bound: no point of the box is higher, but for a rounding.
  double bound(const Bounds3f& box) const {
    return std::max(normal.x * box.lower.x, normal.x * box.upper.x) +
           std::max(normal.y * box.lower.y, normal.y * box.upper.y) +
           std::max(normal.z * box.lower.z, normal.z * box.upper.z) + offset;
  }
};

// Calls visit(i) for i in [0, count) whose bound(i) exceeds height(): first for the one of the
// greatest bound, which mostly leaves nothing for the others.
template <class Bound, class ReachedHeight, class Visit>
void best_first(std::size_t count, const Bound& bound, const ReachedHeight& height,
                const Visit& visit) {
  std::size_t first = 0;
  double greatest = kNothing;
  for (std::size_t i = 0; i < count; ++i) {
    if (const double b = bound(i); b > greatest) {
      greatest = b;
      first = i;
    }
  }
  if (!(greatest > height())) return;
  visit(first);
  for (std::size_t i = 0; i < count; ++i) {
    if (i != first && bound(i) > height()) visit(i);
  }
}

}  // namespace

struct SupportMap::Best {
  double height = kNothing;
  Vec3d point;
};

SupportMap::SupportMap(const Scene& scene) {
  shapes_.resize(scene.meshes.size());
  for (std::size_t i = 0; i < shapes_.size(); ++i) {
    const Mesh& mesh = *scene.meshes[i];
    Shape& shape = shapes_[i];
    shape.mesh = scene.meshes[i];
    const std::size_t count = mesh.triangles.size();
    shape.run_boxes.reserve((count + kRunTriangles - 1) / kRunTriangles);
    for (std::size_t begin = 0; begin < count; begin += kRunTriangles) {
      Bounds3f box;
      for (std::size_t t = begin; t < std::min(begin + kRunTriangles, count); ++t) {
        for (const std::uint32_t vertex : mesh.triangles[t]) box.grow(mesh.positions[vertex]);
      }
      shape.run_boxes.push_back(box);
      shape.box.grow(box);
    }
  }
  for (const Instance& instance : scene.instances) {
    if (!shapes_[instance.mesh].run_boxes.empty()) instances_.push_back(instance);
  }
}

void SupportMap::search(const Instance& instance, Vec3d direction, Best& best) const {
  const Shape& shape = shapes_[instance.mesh];
  const Height height(instance.object_to_world, direction);
  const auto visit = [&](std::size_t run) {
    const std::size_t begin = run * kRunTriangles;
    const std::size_t end = std::min(begin + kRunTriangles, shape.mesh->triangles.size());
    for (std::size_t t = begin; t < end; ++t) {
      for (const std::uint32_t vertex : shape.mesh->triangles[t]) {
        const Vec3f p = shape.mesh->positions[vertex];
        if (const double h = height.of(p); h > best.height)
          best = {h, to_world(instance.object_to_world, p)};
      }
    }
  };
  best_first(
      shape.run_boxes.size(), [&](std::size_t run) { return height.bound(shape.run_boxes[run]); },
      [&] { return best.height; }, visit);
}

Vec3d SupportMap::farthest(Vec3d direction) const {
  Best best;
  const auto bound = [&](std::size_t i) {
    const Instance& instance = instances_[i];
    return Height(instance.object_to_world, direction).bound(shapes_[instance.mesh].box);
  };
  best_first(
      instances_.size(), bound, [&] { return best.height; },
      [&](std::size_t i) { search(instances_[i], direction, best); });
  return best.point;
}

Bounds3f SupportMap::bounds() const {
  Bounds3f result;
  if (is_empty()) return result;
  for (const Vec3d axis : {Vec3d{1, 0, 0}, Vec3d{0, 1, 0}, Vec3d{0, 0, 1}}) {
    result.grow(rounded(farthest(axis)));
    result.grow(rounded(farthest(-axis)));
  }
  return result;
}

}  // namespace tessera
