// SPDX-License-Identifier: Apache-2.0
// Entry points of the kernels for one instruction set. All other code calls through this table. The
// set is a property of the frame, so it is an argument and no global choice: slaves of one process
// may differ. A call covers a bundle, so its indirect jump costs well under 1 % of the work.
//
// Threads. Tables are constant; kernels read the scene and write only what they are given.
#pragma once

#include "common/base/isa.h"
#include "slave/core/bsdf/lobes_layout.h"
#include "slave/core/camera/camera_layout.h"
#include "slave/core/kernels/view_tables_layout.h"
#include "slave/core/light/emitter_layout.h"
#include "slave/core/light/gather_layout.h"
#include "slave/core/light/sky_layout.h"
#include "slave/core/ray/packet_layout.h"
#include "slave/core/sampling/sample_layout.h"
#include "slave/core/surface/detail_layout.h"
#include "slave/core/surface/noise_layout.h"
#include "slave/core/surface/surface_layout.h"

namespace tessera::core {

struct KernelTable {
  Isa isa;
  int lane_count;  // rays per register: 1, 4, 8, 16

  // Makes the directions of one sample of each pixel, and rays.active. keys [kPacketRays]: becomes
  // pixel_key() of the pixels in the sample's key_dimension.
  void (*camera_rays)(const CameraView& camera, const PixelSample& sample,
                      const PacketPixels& pixels, FanPacket& rays, uint32_t* keys);

  // Finds where the rays have hit triangles. vertices [triangle][corner][axis], world units: those
  // of all triangles that the hits may name. Requires: the hits are those of these rays.
  void (*fan_points)(const float* vertices, const FanPacket& rays, const PacketHits& hits,
                     PacketPoints& points);
  void (*packet_points)(const float* vertices, const RayPacket& rays, const PacketHits& hits,
                        PacketPoints& points);

  void (*surface_detail)(const DetailGroup& group, DetailPoints& points);

  // For each of points.wanted, sky_light() turns a direction into radiance and pdf; sky_samples()
  // turns a point of the square into direction, radiance and angle.
  void (*sky_light)(const SkyView& sky, SkyPoints& points);
  void (*sky_samples)(const SkyView& sky, SkyPoints& points);

  // Points of the sequence: shuffled_2d(hash_combine(key, dimension), index).
  void (*sample_points)(uint32_t dimension, uint32_t index, SamplePoints& points);
  void (*emitter_samples)(const LitSurfaces& surfaces, EmitterSamples& samples);

  NoiseKernel noise;  // see noise_layout.h and slave/core/surface/noise.h

  // Groups rays by the face of a cube around their origin that they leave through; then halves the
  // longer extent of a group on its face until at most kPacketRays are left. Order is kept within a
  // group. Every ray is in one group, whether it is valid or not.
  void (*group_fans)(FanTargets& targets);

  // Finds the bounds that begin_gather() looks at. Requires: there are points.
  void (*bound_points)(GatherPoints& points);
  // Finds rays.strength and the shadow rays, from the light to the points, which tell whether a
  // point gets its strength. Strengths of lights on surfaces are at most `clamp`. For kFar,
  // light.position is a place far back along the rays, from which they are to be grouped. Returns:
  // whether there are any rays.
  bool (*begin_gather)(const GatherPoints& points, const LightPoint& light, float clamp,
                       GatherRays& rays);
  // Adds strength times light.rgb to the points' light. The caller has set the strength of points
  // in shadow to 0.
  void (*end_gather)(const LightPoint& light, const GatherRays& rays, GatherPoints& points);
  // Adds to planes.sum what pixels reflect: the mean of their neighbours' light times albedo, for
  // width x height pixels from (x, y) on. Sums of some pixels to the right of these are lost.
  // Requires: distance is set there and `radius` further on all sides.
  void (*filter)(FilterPlanes& planes, int radius, int x, int y, int width, int height);

  ViewKernels<TriangleBvh<8>> bvh8;
  ViewKernels<TriangleBvh<16>> bvh16;
  ViewKernels<TriangleKd<8>> kd8;
  ViewKernels<TriangleKd<16>> kd16;
  ViewKernels<InstancedView<8>> instanced8;
  ViewKernels<InstancedView<16>> instanced16;
  ViewKernels<PatchedView<8>> patched8;
  ViewKernels<PatchedView<16>> patched16;

  BsdfKernels bsdfs;  // indexed by slot_of() a surface
};

// Requires: isa is in supported_isas().
const KernelTable& kernels_for(Isa isa);

// Instruction sets compiled into this build, whether this CPU has them or not.
IsaMask compiled_isas();

}  // namespace tessera::core
