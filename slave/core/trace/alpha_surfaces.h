// SPDX-License-Identifier: Apache-2.0
// The triangles of a scene that rays may go through, and which rays do.
//
// A ray goes through a mask where its opacity is below the cutoff, and through a blended surface
// with the probability 1 - opacity (stochastic transparency: Enderton, Sintorn, Shirley, Luebke
// 2010): the mean over rays is that of attenuated light, and surfaces need not be sorted. The
// chance is drawn from the ray's own bits and the triangle's number, so a ray's answer is the same
// on every slave, in every packet and with every instruction set.
//
// Threads. Constant after construction.
#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "slave/core/primitive/triangle/triangle_store.h"
#include "slave/core/ray/packet_layout.h"
#include "slave/core/surface/opacity.h"

namespace tessera::core {

class AlphaSurfaces {
 public:
  struct Parts {
    const TriangleStore& triangles;
    const std::vector<std::shared_ptr<const Mesh>>& meshes;
    const std::vector<Instance>& instances;
    const std::vector<Material>& materials;
    MipMaps textures;
  };

  // Returns: null where no ray goes through anything. Requires: the parts outlive it and stay where
  // they are.
  static std::unique_ptr<const AlphaSurfaces> make(const Parts& parts);

  // Whether the ray goes through the triangle that it meets. Requires: it meets that.
  bool is_passed(std::uint32_t triangle, const SingleRay& ray) const {
    return (may_pass_[triangle / 64] >> (triangle % 64) & 1u) != 0 && is_let_through(triangle, ray);
  }

  std::uint64_t memory_bytes() const { return may_pass_.size() * sizeof(std::uint64_t); }

 private:
  explicit AlphaSurfaces(const Parts& parts) : parts_(parts) {}

  bool mark(std::uint32_t instance);
  bool is_let_through(std::uint32_t triangle, const SingleRay& ray) const;

  const Parts parts_;
  std::vector<std::uint64_t> may_pass_;  // a bit for each triangle
};

}  // namespace tessera::core
