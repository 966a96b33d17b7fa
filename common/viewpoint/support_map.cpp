// SPDX-License-Identifier: Apache-2.0
#include "common/viewpoint/support_map.h"

#include <algorithm>
#include <limits>

#include "common/viewpoint/patch_net.h"

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
// point p of the shape along the direction in the world.
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

void SupportMap::Shape::make_boxes() {
  const std::size_t count = point_count();
  run_boxes.reserve((count + kRunPoints - 1) / kRunPoints);
  for (std::size_t begin = 0; begin < count; begin += kRunPoints) {
    Bounds3f run;
    for (std::size_t i = begin; i < std::min(begin + kRunPoints, count); ++i) run.grow(point(i));
    run_boxes.push_back(run);
    box.grow(run);
  }
}

SupportMap::SupportMap(const Scene& scene) {
  const std::size_t mesh_count = scene.meshes.size();
  shapes_.resize(mesh_count + scene.surfaces.size());
  for (std::size_t i = 0; i < shapes_.size(); ++i) {
    if (i < mesh_count) {
      shapes_[i].mesh = scene.meshes[i];
    } else {
      shapes_[i].net = fine_net(*scene.surfaces[i - mesh_count]);
    }
    shapes_[i].make_boxes();
  }
  for (const Instance& instance : scene.instances) {
    const std::size_t shape =
        instance.mesh + (instance.kind == ObjectKind::kPatchSurface ? mesh_count : 0);
    if (!shapes_[shape].run_boxes.empty()) instances_.push_back({shape, instance.object_to_world});
  }
}

void SupportMap::search(const Placed& placed, Vec3d direction, Best& best) const {
  const Shape& shape = shapes_[placed.shape];
  const Height height(placed.object_to_world, direction);
  const auto visit = [&](std::size_t run) {
    const std::size_t end = std::min((run + 1) * kRunPoints, shape.point_count());
    for (std::size_t i = run * kRunPoints; i < end; ++i) {
      const Vec3f p = shape.point(i);
      if (const double h = height.of(p); h > best.height)
        best = {h, to_world(placed.object_to_world, p)};
    }
  };
  best_first(
      shape.run_boxes.size(), [&](std::size_t run) { return height.bound(shape.run_boxes[run]); },
      [&] { return best.height; }, visit);
}

Vec3d SupportMap::farthest(Vec3d direction) const {
  Best best;
  const auto bound = [&](std::size_t i) {
    const Placed& placed = instances_[i];
    return Height(placed.object_to_world, direction).bound(shapes_[placed.shape].box);
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
