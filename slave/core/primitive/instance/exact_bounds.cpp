// SPDX-License-Identifier: Apache-2.0
#include "slave/core/primitive/instance/exact_bounds.h"

#include <algorithm>

#include "slave/core/accel/bvh_farthest.h"
#include "slave/core/primitive/instance/instance_placement.h"
#include "slave/core/primitive/instance/mesh_slot.h"
#include "slave/core/primitive/instance/mesh_slot_abi.h"
#include "slave/core/primitive/triangle/triangle_store.h"

namespace tessera::core {
namespace {

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
  FarthestCorner(const MeshShape<W>& mesh, const InstanceBlock& instance)
      : mesh_(mesh), to_world_(transform_of(instance)) {}

  float find(const AxisDirection& along, float best) const {
    if (is_slot(mesh_)) return find_in_all(MeshSlot<W>::of(mesh_).mesh(), along, best);
    const auto reach_of = [&](const Bounds3f& box) {
      return along.of(placed_bounds(to_world_, {&box, 1}));
    };
    const auto best_in_leaf = [&](std::uint32_t leaf, float far) {
      return find_in_leaf(leaf, along, far);
    };
    return farthest_in_bvh(mesh_.nodes, best, reach_of, best_in_leaf);
  }

 private:
  // For meshes that may have no hierarchy yet.
  float find_in_all(const Mesh& mesh, const AxisDirection& along, float best) const {
    const auto placed = [&](std::uint32_t vertex) {
      const Vec3f p = mesh.positions[vertex];
      return to_world_.is_identity() ? p : to_world_.point(p);
    };
    for (const auto& triangle : mesh.triangles) {
      const Vec3f p[3] = {placed(triangle[0]), placed(triangle[1]), placed(triangle[2])};
      const float far = std::max({along.of(p[0]), along.of(p[1]), along.of(p[2])});
      if (far > best && !is_degenerate(p[0], p[1], p[2])) best = far;
    }
    return best;
  }

  float find_in_leaf(std::uint32_t child, const AxisDirection& along, float best) const {
    const std::uint32_t first = first_block_of(child), count = block_count_of(child);
    for (std::uint32_t b = first; b < first + count; ++b) {
      const TriangleBlock<W>& block = mesh_.triangles[b];
      for (int lane = 0; lane < W && block.primitive[lane] != kNoPrimitive; ++lane) {
        const Vec3f p[3] = {corner(block, lane, 0, to_world_), corner(block, lane, 1, to_world_),
                            corner(block, lane, 2, to_world_)};
        const float far = std::max({along.of(p[0]), along.of(p[1]), along.of(p[2])});
        if (far > best && !is_degenerate(p[0], p[1], p[2])) best = far;
      }
    }
    return best;
  }

  const MeshShape<W>& mesh_;
  const Transform to_world_;
};

// Finds who lies farthest along a direction: an instance, or what is flattened.
template <int W>
class Farthest {
 public:
  // Begins with the best that is known, and who has it.
  Farthest(const InstancedBvh<W>& index, const AxisDirection& along, float best, std::int64_t who)
      : index_(index), along_(along), best_(best), who_(who) {}

  void look_at(std::size_t i) {
    if (!(along_.of(index_.boxes[i]) > best_)) return;
    const InstanceBlock& instance = index_.instances[i];
    const float found =
        FarthestCorner<W>(index_.shapes[instance.mesh], instance).find(along_, best_);
    if (found > best_) who_ = static_cast<std::int64_t>(i);
    best_ = found;
  }
  // The instance whose box reaches farthest comes first, so that few others have to be looked at.
  void look_at_all() {
    std::size_t first = 0;
    for (std::size_t i = 1; i < index_.boxes.size(); ++i) {
      if (along_.of(index_.boxes[i]) > along_.of(index_.boxes[first])) first = i;
    }
    if (!index_.boxes.empty()) look_at(first);
    for (std::size_t i = 0; i < index_.boxes.size(); ++i) look_at(i);
  }
  float best() const { return best_; }
  std::int64_t who() const { return who_; }

 private:
  const InstancedBvh<W>& index_;
  const AxisDirection along_;
  float best_;
  std::int64_t who_;
};

}  // namespace

// Where who lay farthest in the other version has not changed, only those that have can lie
// farther.
template <int W>
void set_exact_bounds(const Bounds3f& flattened, const InstancedBvh<W>* known,
                      std::span<const std::uint32_t> changed, InstancedBvh<W>& index) {
  float limit[2][3];
  const std::int64_t of_part = known != nullptr && known->instances.size() < index.instances.size()
                                   ? static_cast<std::int64_t>(known->instances.size())
                                   : -1;
  for (int d = 0; d < 6; ++d) {
    const AxisDirection along{d / 2, d % 2 == 0 ? -1.0f : 1.0f};
    std::int64_t who = known != nullptr ? known->farthest[d] : -1;
    if (who < 0) who = of_part;
    const bool is_known =
        known != nullptr && !std::binary_search(changed.begin(), changed.end(), who);
    Farthest<W> farthest(index, along, along.of(is_known ? known->bounds : flattened),
                         is_known ? who : -1);
    if (is_known) {
      for (const std::uint32_t i : changed) farthest.look_at(i);
    } else {
      farthest.look_at_all();
    }
    limit[d % 2][d / 2] = along.sign * farthest.best();
    index.farthest[d] = farthest.who();
  }
  const auto &low = limit[0], &high = limit[1];
  index.bounds = {{low[0], low[1], low[2]}, {high[0], high[1], high[2]}};
}

template void set_exact_bounds<8>(const Bounds3f&, const InstancedBvh<8>*,
                                  std::span<const std::uint32_t>, InstancedBvh<8>&);
template void set_exact_bounds<16>(const Bounds3f&, const InstancedBvh<16>*,
                                   std::span<const std::uint32_t>, InstancedBvh<16>&);

}  // namespace tessera::core
