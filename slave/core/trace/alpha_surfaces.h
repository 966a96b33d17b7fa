// SPDX-License-Identifier: Apache-2.0
// The triangles and patches of a scene that rays may go through, and which rays do.
//
// A ray goes through a mask where its opacity is below the cutoff, and through a blended surface
// with the probability 1 - opacity (stochastic transparency: Enderton, Sintorn, Shirley, Luebke
// 2010): the mean over rays is that of attenuated light, and surfaces need not be sorted. The
// chance is drawn from the ray's own bits and the primitive's number, so a ray's answer is the same
// on every slave, in every packet and with every instruction set.
//
// Threads. Constant after construction.
#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "common/frame/patch_method.h"
#include "slave/core/primitive/freeform/patch_store.h"
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
    const PatchStore* patches;  // null where the scene has none
    const std::vector<std::shared_ptr<const PatchSurface>>& surfaces;
  };

  // Returns: null where no ray goes through anything. Requires: the parts outlive it and stay where
  // they are.
  static std::unique_ptr<const AlphaSurfaces> make(const Parts& parts);

  // Whether the ray goes through what it meets. Requires: it meets that, patches by the method.
  bool is_passed(const SingleHit& hit, const SingleRay& ray,
                 PatchMethod method = PatchMethod::kAuto) const {
    return (may_pass_[hit.primitive / 64] >> (hit.primitive % 64) & 1u) != 0 &&
           is_let_through(hit, ray, method);
  }

  std::uint64_t memory_bytes() const { return may_pass_.size() * sizeof(std::uint64_t); }

 private:
  explicit AlphaSurfaces(const Parts& parts) : parts_(parts) {}

  bool mark(std::uint32_t instance);
  bool mark_patches(std::uint32_t instance);
  const Material& material_of_part(std::uint32_t instance, std::uint64_t part) const;
  bool is_let_through(const SingleHit& hit, const SingleRay& ray, PatchMethod method) const;
  float opacity_of_patch(std::uint32_t instance, const SingleHit& hit, const SingleRay& ray,
                         PatchMethod method) const;

  const Parts parts_;
  std::vector<std::uint64_t> may_pass_;  // a bit for each primitive
};

}  // namespace tessera::core
