// Entry points of the kernels for one instruction set. All other code calls through this table. The
// set is a property of the frame, so it is an argument and no global choice: slaves of one process
// may differ. A call covers a bundle, so its indirect jump costs well under 1 % of the work.
//
// Threads. Tables are constant; kernels read the scene and write only what they are given.
#pragma once

#include "common/base/isa.h"
#include "slave/core/kernel/packet_layout.h"

namespace tessera::core {

struct KernelTable {
  Isa isa;
  int lane_count;  // rays per register: 1, 4, 8, 16

  // Tells rays apart by the face of a cube around their origin that they leave through, then halves
  // the longer extent of a group on its face until at most kPacketRays are left. Order is kept
  // within a group. Every ray is in one group, also those that are not valid.
  void (*group_fans)(FanTargets& targets);

  // By structure, with blocks of 8 and of 16 triangles.
  ViewKernels<BvhView<8>> bvh8;
  ViewKernels<BvhView<16>> bvh16;
  ViewKernels<KdView<8>> kd8;
  ViewKernels<KdView<16>> kd16;
};

// Requires: isa is in supported_isas().
const KernelTable& kernels_for(Isa isa);

// Instruction sets compiled into this build, whether this CPU has them or not.
IsaMask compiled_isas();

}  // namespace tessera::core
