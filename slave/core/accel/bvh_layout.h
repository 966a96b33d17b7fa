// SPDX-License-Identifier: Apache-2.0
// Memory layout of the wide bounding volume hierarchy, shared by the builder (scalar) and the
// kernels (SIMD). Fixed-size types only and no functions (see kd_layout.h).
//
// A node holds the boxes of W children side by side, so that one register of W lanes tests them at
// once, and has the alignment of that register. A leaf is a run of blocks of primitives. After
// Wald, Benthin, Boulos, "Getting rid of packets", 2008.
#pragma once

#include <stdint.h>

namespace tessera::core {

// child: bit 31 clear: the number of a node.
//        bit 31 set:   bits 27-30 blocks of the leaf less one, bits 0-26 its first block.
inline constexpr uint32_t kBvhLeaf = 0x80000000u;
inline constexpr uint32_t kBvhCountShift = 27;
inline constexpr uint32_t kBvhBlockMask = (1u << kBvhCountShift) - 1;
inline constexpr uint32_t kBvhLeafBlocksMax = 16;
inline constexpr uint32_t kBvhNoChild = 0xffffffffu;  // its box is empty: lower > upper

// Deepest node (the root has depth 0). A step down pushes at most W - 1 children.
inline constexpr int kBvhDepthMax = 60;

// Kernels load whole registers of W lanes with aligned loads.
template <int W>
struct alignas(W * sizeof(float)) BvhNode {
  float lower[3][W];
  float upper[3][W];
  uint32_t child[W];
};

static_assert(sizeof(BvhNode<8>) == 224 && sizeof(BvhNode<16>) == 448);

}  // namespace tessera::core
