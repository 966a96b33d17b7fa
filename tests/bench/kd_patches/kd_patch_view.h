// SPDX-License-Identifier: Apache-2.0
// A kd-tree over sub-patches, as the hierarchy over them is in slave/core, for the comparison of
// both: scenes of patches have a hierarchy.
//
// Threads. Built once, then never changed.
#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "common/base/isa.h"
#include "slave/core/accel/kd_index.h"
#include "slave/core/kernels/kernel_table.h"
#include "slave/core/primitive/freeform/patch_store.h"
#include "slave/core/trace/scene_tracer.h"
#include "tests/bench/kd_patches/kd_patch_view_layout.h"

namespace tessera::core {

const ViewTables<PatchedKdView>& kd_patch_kernels(Isa isa);

template <int W>
struct PatchedKd {
  KdIndex<W> structure;
  std::vector<std::uint32_t> blocks;  // as TrianglesAndPatches has them
  std::shared_ptr<const PatchStore> patches;

  std::uint64_t memory_bytes() const {  // but for the patches
    return structure.memory_bytes() + blocks.capacity() * sizeof(std::uint32_t);
  }
};

template <int W>
PatchedKdView<W> view_of(const PatchedKd<W>& kd) {
  return {kd.structure.nodes.data(),
          kd.structure.leaves.data(),
          {kd.blocks.data(), nullptr, kd.patches->parts.data(), kd.patches->patches.data()},
          scene_box(kd.structure.bounds)};
}
inline const auto& kernels_of(const KernelTable& table, const PatchedKdView<8>&) {
  return kd_patch_kernels(table.isa).by8;
}
inline const auto& kernels_of(const KernelTable& table, const PatchedKdView<16>&) {
  return kd_patch_kernels(table.isa).by16;
}

}  // namespace tessera::core
