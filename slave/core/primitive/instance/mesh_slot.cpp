// SPDX-License-Identifier: Apache-2.0
#include "slave/core/primitive/instance/mesh_slot.h"

#include <new>
#include <string>
#include <utility>

#include "slave/core/primitive/instance/mesh_slot_abi.h"
#include "slave/core/primitive/triangle/triangle_store.h"
#include "slave/core/ray/met_builds.h"

namespace tessera::core {
template <int W>
MeshSlot<W>::MeshSlot(std::shared_ptr<const Mesh> mesh, Build build)
    : mesh_(std::move(mesh)), build_(std::move(build)) {
  for (const auto& triangle : mesh_->triangles) {
    const Vec3f a = mesh_->positions[triangle[0]], b = mesh_->positions[triangle[1]],
                c = mesh_->positions[triangle[2]];
    if (is_degenerate(a, b, c)) ++degenerate_count_;
    if (!is_in_mesh_index(a, b, c)) continue;
    bounds_.grow(a);
    bounds_.grow(b);
    bounds_.grow(c);
  }
}

template <int W>
MeshSlot<W>::MeshSlot(std::shared_ptr<const Mesh> mesh)
    : MeshSlot(mesh, [mesh] {
        return index_mesh<W>(*mesh, {1, nullptr});
      }) {}

template <int W>
const MeshShape<W>& MeshSlot<W>::meet() {
  return state_.load(std::memory_order_acquire) == kBuilt ? shape_ : meet_unbuilt();
}

template <int W>
const MeshShape<W>& MeshSlot<W>::meet_unbuilt() {
  static constexpr MeshShape<W> kNone{};
  int state = kUnbuilt;
  MetBuilds* const met = MetBuilds::of_thread();
  if (state_.compare_exchange_strong(state, kInWork, std::memory_order_acq_rel)) {
    build();
  } else if (state == kInWork) {
    if (met != nullptr && met->may_leave()) {
      met->leave();
      return kNone;
    }
    state_.wait(kInWork, std::memory_order_acquire);
  }
  if (state_.load(std::memory_order_acquire) == kBuilt) return shape_;
  if (met != nullptr) met->fail(failure_);
  return kNone;
}

template <int W>
void MeshSlot<W>::build() {
  int state = kFailed;
  try {
    Result<std::shared_ptr<const MeshIndex<W>>> built = build_();
    if (built.is_ok()) {
      index_ = std::move(*built);
      shape_ = index_->shape();
      state = kBuilt;
    } else {
      failure_ = built.status();
    }
  } catch (const std::bad_alloc&) {
    failure_ = Status::resource_exhausted(
        "no memory to build a mesh of " + std::to_string(mesh_->triangles.size()) +
        " triangles that a ray has met: give the slave more memory, or "
        "make the scene smaller");
  }
  state_.store(state, std::memory_order_release);
  state_.notify_all();
}

template <int W>
const MeshIndex<W>* MeshSlot<W>::built() const {
  return state_.load(std::memory_order_acquire) == kBuilt ? index_.get() : nullptr;
}

template class MeshSlot<8>;
template class MeshSlot<16>;

const MeshShape<8>& met_mesh(const MeshShape<8>& mesh) { return MeshSlot<8>::of(mesh).meet(); }
const MeshShape<16>& met_mesh(const MeshShape<16>& mesh) { return MeshSlot<16>::of(mesh).meet(); }

}  // namespace tessera::core
