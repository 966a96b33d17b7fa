// The structure that the rays of a scene go through, whichever it is.
//
// Threads. Built once, then never changed.
#pragma once

#include <cstdint>
#include <span>
#include <variant>

#include "common/base/status.h"
#include "slave/core/accel/build_control.h"
#include "slave/core/accel/bvh.h"
#include "slave/core/accel/kd_index.h"
#include "slave/core/accel/structure.h"

namespace tessera::core {

// Answers do not depend on it, only time does.
struct SpatialIndex {
  std::variant<Bvh<8>, Bvh<16>, KdIndex<8>, KdIndex<16>> structure;

  std::uint64_t memory_bytes() const {
    return std::visit([](const auto& s) { return s.memory_bytes(); }, structure);
  }
};

// The one for a processor with registers of `lanes` floats. Shape: boxes [triangle_count], an empty
// one keeps its number and stays out; vertices [triangle_count][3][3]. Returns: kCancelled,
// kResourceExhausted.
Result<SpatialIndex> build_spatial_index(std::span<const Bounds3f> boxes,
                                         std::span<const float> vertices, Structure structure,
                                         int lanes, const BuildControl& control);

}  // namespace tessera::core
