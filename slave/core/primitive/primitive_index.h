// SPDX-License-Identifier: Apache-2.0
// The structure that the rays of a scene go through, whichever it is, with the blocks of primitives
// that its leaves name.
//
// Threads. Built once, then never changed.
#pragma once

#include <cstdint>
#include <span>
#include <variant>
#include <vector>

#include "common/base/status.h"
#include "slave/core/accel/build_control.h"
#include "slave/core/accel/bvh.h"
#include "slave/core/accel/bvh_builder.h"
#include "slave/core/accel/kd_index.h"
#include "slave/core/accel/structure.h"
#include "slave/core/primitive/triangle/triangle_layout.h"

namespace tessera::core {

template <class Structure, int W>
struct Indexed {
  Structure structure;
  std::vector<TriangleBlock<W>> triangles;

  std::uint64_t memory_bytes() const {
    return structure.memory_bytes() + triangles.capacity() * sizeof(TriangleBlock<W>);
  }
};
template <int W>
using IndexedBvh = Indexed<Bvh<W>, W>;
template <int W>
using IndexedKd = Indexed<KdIndex, W>;

// Answers do not depend on the structure, only time does.
struct PrimitiveIndex {
  std::variant<IndexedBvh<8>, IndexedBvh<16>, IndexedKd<8>, IndexedKd<16>> any;

  std::uint64_t memory_bytes() const {
    return std::visit([](const auto& index) { return index.memory_bytes(); }, any);
  }
};

// Shape: boxes [triangle_count], an empty one keeps its number and stays out; vertices
// [triangle_count][3][3]. Returns: kCancelled; kResourceExhausted when indices or memory run out.
template <int W>
Result<IndexedBvh<W>> index_by_bvh(std::span<const Bounds3f> boxes, std::span<const float> vertices,
                                   const BuildControl& control, const BvhBuildConfig& config = {});
template <int W>
Result<IndexedKd<W>> index_by_kd(std::span<const Bounds3f> boxes, std::span<const float> vertices,
                                 const BuildControl& control, const KdBuildConfig& config = {});

// The one for a processor with registers of `lanes` floats. Shape and returns: as above.
Result<PrimitiveIndex> build_primitive_index(std::span<const Bounds3f> boxes,
                                             std::span<const float> vertices, Structure structure,
                                             int lanes, const BuildControl& control);

}  // namespace tessera::core
