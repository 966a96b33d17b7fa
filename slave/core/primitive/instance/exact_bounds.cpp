// SPDX-License-Identifier: Apache-2.0
#include "slave/core/primitive/instance/exact_bounds.h"

#include <algorithm>
#include <limits>
#include <queue>
#include <utility>

#include "slave/core/primitive/instance/instance_placement.h"
#include "slave/core/primitive/triangle/triangle_store.h"

namespace tessera::core {
namespace {

// One of the six directions along the axes; of() is the coordinate along it.
struct Direction {
  int axis;
  float sign;

  float of(Vec3f p) const { return p[axis] * sign; }
  float of(const Bounds3f& box) const { return of(sign > 0 ? box.upper : box.lower); }
};

Transform transform_of(const InstanceBlock& instance) {
  Transform t;
  for (std::size_t i = 0; i < 3; ++i) std::copy_n(instance.to_world[i], 4, t.m[i].begin());
  return t;
}

template <int W>
Vec3f corner(const TriangleBlock<W>& block, int lane, int k, const Transform& to_world) {
  const Vec3f p{block.vertex[3 * k][lane], block.vertex[3 * k + 1][lane],
                block.vertex[3 * k + 2][lane]};
  return to_world.is_identity() ? p : to_world.point(p);
}

// Finds the corner of an instance that lies farthest along a direction. The search goes down the
// mesh's hierarchy only where something may lie farther than the best so far.
template <int W>
class FarthestCorner {
 public:
  FarthestCorner(const MeshIndex<W>& mesh, const InstanceBlock& instance)
      : mesh_(mesh), to_world_(transform_of(instance)) {}

  float find(const Direction& along, float best) const {
    std::priority_queue<std::pair<float, std::uint32_t>> open;  // the farthest first
    open.push({std::numeric_limits<float>::infinity(), 0});
    while (!open.empty() && open.top().first > best) {
      const std::uint32_t child = open.top().second;
      open.pop();
      if ((child & kBvhLeaf) != 0) {
        best = find_in_leaf(child, along, best);
        continue;
      }
      const BvhNode<W>& node = mesh_.bvh.structure.nodes[child];
      for (int i = 0; i < W; ++i) {
        if (node.child[i] == kBvhNoChild) continue;
        const Bounds3f box{{node.lower[0][i], node.lower[1][i], node.lower[2][i]},
                           {node.upper[0][i], node.upper[1][i], node.upper[2][i]}};
        open.push({along.of(placed_bounds(to_world_, {&box, 1})), node.child[i]});
      }
    }
    return best;
  }

 private:
  float find_in_leaf(std::uint32_t child, const Direction& along, float best) const {
    const std::uint32_t first = child & kBvhBlockMask;
    const std::uint32_t count = (child >> kBvhCountShift & (kBvhLeafBlocksMax - 1)) + 1;
    for (std::uint32_t b = first; b < first + count; ++b) {
      const TriangleBlock<W>& block = mesh_.bvh.triangles[b];
      for (int lane = 0; lane < W && block.primitive[lane] != kNoPrimitive; ++lane) {
        const Vec3f p[3] = {corner(block, lane, 0, to_world_), corner(block, lane, 1, to_world_),
                            corner(block, lane, 2, to_world_)};
        const float far = std::max({along.of(p[0]), along.of(p[1]), along.of(p[2])});
        if (far > best && !is_degenerate(p[0], p[1], p[2])) best = far;
      }
    }
    return best;
  }

  const MeshIndex<W>& mesh_;
  const Transform to_world_;
};

// The instance whose box reaches farthest comes first, so that few others have to be looked at.
template <int W>
float farthest(const InstancedBvh<W>& index, const Direction& along, float best) {
  std::size_t first = 0;
  for (std::size_t i = 1; i < index.boxes.size(); ++i) {
    if (along.of(index.boxes[i]) > along.of(index.boxes[first])) first = i;
  }
  const auto look_at = [&](std::size_t i) {
    if (!(along.of(index.boxes[i]) > best)) return;
    const InstanceBlock& instance = index.instances[i];
    best = FarthestCorner<W>(*index.meshes[instance.mesh], instance).find(along, best);
  };
  look_at(first);
  for (std::size_t i = 0; i < index.boxes.size(); ++i) look_at(i);
  return best;
}

}  // namespace

template <int W>
Bounds3f exact_bounds(const InstancedBvh<W>& index, const Bounds3f& flattened) {
  float lower[3], upper[3];
  for (int a = 0; a < 3; ++a) {
    lower[a] = -farthest(index, {a, -1}, -flattened.lower[a]);
    upper[a] = farthest(index, {a, 1}, flattened.upper[a]);
  }
  return {{lower[0], lower[1], lower[2]}, {upper[0], upper[1], upper[2]}};
}

template Bounds3f exact_bounds<8>(const InstancedBvh<8>&, const Bounds3f&);
template Bounds3f exact_bounds<16>(const InstancedBvh<16>&, const Bounds3f&);

}  // namespace tessera::core
