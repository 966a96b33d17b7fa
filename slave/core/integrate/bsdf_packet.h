// SPDX-License-Identifier: Apache-2.0
// BSDFs of some surfaces at a time, for the kernels (slave/core/bsdf/glossy-inl.h).
//
// Threads. One object per thread.
#pragma once

#include <memory>

#include "slave/core/kernels/kernel_table.h"
#include "slave/core/simd/axis_arrays.h"
#include "slave/core/surface/surface.h"
#include "slave/core/surface/surface_lobes.h"

namespace tessera::core {

// Either diffuse surfaces, or glossy ones, or glossy ones with optional lobes; of all the same is asked.
class BsdfPacket {
 public:
  static constexpr int kMax = kBsdfPoints;

  void clear() { points_.count = 0; }
  int count() const { return points_.count; }

  // Return: the number of the surface, from 0. Require: count() < kMax.
  int add_diffuse(Vec3f shading_normal, Vec2f square);
  int add_glossy(const Surface& s, Vec2f square);    // to be sampled
  int add_glossy(const Surface& s, Vec3f to_light);  // to be evaluated

  int add_layered(const Surface& s, const SurfaceLobes& lobes, Vec2f square);
  int add_layered(const Surface& s, const SurfaceLobes& lobes, Vec3f to_light);

  void sample_diffuse(const KernelTable& kernels);
  void sample_glossy(const KernelTable& kernels);
  void evaluate_glossy(const KernelTable& kernels);
  void sample_layered(const KernelTable& kernels);
  void evaluate_layered(const KernelTable& kernels);

  // To the light, unit.
  Vec3f direction(int i) const { return vector_at(points_.direction, i); }
  // BSDF times cosine over pdf: of glossy ones that were sampled. Zero: nothing comes from there.
  Vec3f weight(int i) const { return vector_at(points_.value, i); }
  // Of the BSDF, of glossy ones that were evaluated: a diffuse surface's is its albedo.
  Vec3f times_pi(int i) const { return vector_at(points_.value, i); }
  // With which the direction is sampled, by solid angle.
  float pdf(int i) const { return points_.pdf[i]; }

 private:
  int add(Vec3f shading_normal);
  void put_glossy(const Surface& s, int i);
  void put_lobes(const SurfaceLobes& lobes, int i);

  BsdfPoints points_{};
  std::unique_ptr<LobePoints> lobes_;  // made where there are any
  bool has_sheen_ = false;             // whether a layered point ever had one
};

}  // namespace tessera::core
