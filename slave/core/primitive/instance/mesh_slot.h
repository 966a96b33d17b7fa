// SPDX-License-Identifier: Apache-2.0
// A mesh whose structure is built when the first ray reaches its box, by the thread that traces the
// ray. Another thread that comes while it is built leaves its tile for a later one, or waits, as
// its MetBuilds says.
//
// Threads. Any.
#pragma once

#include <atomic>
#include <functional>
#include <memory>

#include "common/base/status.h"
#include "slave/core/primitive/instance/mesh_index.h"

namespace tessera::core {

// Aligned so that its address may stand where that of a block of triangles does.
template <int W>
class alignas(64) MeshSlot {
 public:
  // Builds the structure, whatever the thread. It may return kResourceExhausted, and throw
  // std::bad_alloc.
  using Build = std::function<Result<std::shared_ptr<const MeshIndex<W>>>()>;

  // What is known of the mesh before it is built. The slot keeps it.
  MeshSlot(std::shared_ptr<const Mesh> mesh, Build build);
  // A slot that builds the mesh as it is built beforehand.
  explicit MeshSlot(std::shared_ptr<const Mesh> mesh);

  // Returns: the shape, without nodes where there is no answer. The reference holds as long as the
  // slot.
  const MeshShape<W>& meet();

  // What stands for the slot among the shapes of meshes; and the slot that such a shape stands for.
  MeshShape<W> shape() {
    MeshShape<W> shape{};
    shape.triangles = reinterpret_cast<const TriangleBlock<W>*>(this);
    return shape;
  }
  static MeshSlot& of(const MeshShape<W>& shape) {
    return *reinterpret_cast<MeshSlot*>(const_cast<TriangleBlock<W>*>(shape.triangles));
  }

  const Mesh& mesh() const { return *mesh_; }
  // Box of all triangles that are in the structure, object space.
  const Bounds3f& bounds() const { return bounds_; }
  std::uint64_t degenerate_count() const { return degenerate_count_; }
  // Null while the structure is not there.
  const MeshIndex<W>* built() const;
  bool has_failed() const { return state_.load(std::memory_order_acquire) == kFailed; }

 private:
  enum State : int { kUnbuilt, kInWork, kBuilt, kFailed };
  const MeshShape<W>& meet_unbuilt();
  void build();

  const std::shared_ptr<const Mesh> mesh_;
  const Build build_;
  Bounds3f bounds_;
  std::uint64_t degenerate_count_ = 0;
  std::atomic<int> state_ = kUnbuilt;
  // Written before state_ says so, then never changed:
  std::shared_ptr<const MeshIndex<W>> index_;
  MeshShape<W> shape_{};
  Status failure_;
};

}  // namespace tessera::core
