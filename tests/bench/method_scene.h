// SPDX-License-Identifier: Apache-2.0
// The teapot split in one way, as the methods' rows trace it: with the product's hierarchy, and
// with a plain one for bundles in lanes. Threads. One.
#pragma once

#include <memory>
#include <vector>

#include "slave/core/primitive/freeform/patch_store.h"
#include "slave/core/primitive/primitive_index.h"
#include "tests/bench/method_lanes_layout.h"
#include "tests/bench/workload.h"

namespace tessera::bench {

class MethodScene {
 public:
  // splitting: of each patch; null: as the product does. lanes: of the product's registers.
  MethodScene(const Scene& scene, const core::PatchSplitting* splitting, int lanes);

  const core::PatchStore& store() const { return *store_; }
  const std::vector<Bounds3f>& boxes() const { return boxes_; }
  const core::PrimitiveIndex& index() const { return index_; }

 private:
  std::shared_ptr<core::PatchStore> store_;
  std::vector<Bounds3f> boxes_;
  core::PrimitiveIndex index_;
};

// Parts and patches for bundles of rays from one eye. Requires: all patches are bicubic; the scene
// outlives it.
class LaneParts {
 public:
  LaneParts(const MethodScene& scene, Vec3f eye);

  const LaneScene& view() const { return view_; }
  const MethodScene& scene() const { return scene_; }
  // To be called before rays whose Newton begins where neighbours' has ended.
  void forget();

 private:
  std::uint32_t build(std::vector<std::uint32_t>& parts, std::size_t first, std::size_t count,
                      std::size_t node);
  void add_patch(const core::Patch& patch);
  static int starts(const void* owner, std::uint32_t patch, const float* direction, float* u,
                    float* v);

  const MethodScene& scene_;
  const Vec3f eye_;
  std::vector<LaneNode> nodes_;
  std::vector<LanePart> parts_;
  std::vector<LanePatch> patches_;
  std::vector<float> last_;
  LaneScene view_{};
};

}  // namespace tessera::bench
