// SPDX-License-Identifier: Apache-2.0
// BSDFs of one surface at a time, as the renderer computes them, for tests of their values.
// Threads. One at a time.
#pragma once

#include "slave/core/bsdf/specular.h"
#include "slave/core/integrate/bsdf_packet.h"
#include "slave/core/simd/isa_support.h"

namespace tessera::test {

struct BsdfValue {
  Vec3f times_pi;  // BSDF times pi: a diffuse surface's is its albedo
  float pdf = 0;   // of sampling this direction, by solid angle
};

struct BsdfSample {
  Vec3f direction;  // unit
  Vec3f weight;     // BSDF times cosine over pdf; zero: nothing comes from there
  float pdf = 0;    // by solid angle; 0 where it is the only direction (mirror, glass)
  bool is_delta = false;
  bool is_through = false;
};

inline const core::KernelTable& widest_kernels() {
  static const core::KernelTable& kTable =
      core::kernels_for(widest_isa(core::cpu_isas() & core::compiled_isas()));
  return kTable;
}
// One packet is kept, since making one takes longer than what is asked of it.
inline core::BsdfPacket& empty_packet() {
  static core::BsdfPacket packet;
  packet.clear();
  return packet;
}

// Requires: no delta BSDF and no optional lobes; to_light is above the shading normal.
inline BsdfValue evaluate(core::Surface s, Vec3f to_viewer, Vec3f to_light) {
  if (s.bsdf == BsdfKind::kDiffuse)
    return {s.albedo, 0.318309886f * dot(s.shading_normal, to_light)};
  s.to_viewer = to_viewer;
  core::BsdfPacket& packet = empty_packet();
  packet.add(s, nullptr, to_light);
  packet.evaluate(widest_kernels(), core::slot_of(s));
  return {packet.times_pi(0), packet.pdf(0)};
}

inline BsdfSample sample(core::Surface s, Vec3f to_viewer, Vec2f square) {
  s.to_viewer = to_viewer;
  core::BsdfPacket& packet = empty_packet();
  switch (scattering_of(s.bsdf)) {
    case Scattering::kEven:
      packet.add_diffuse(s.shading_normal, square);
      packet.sample_diffuse(widest_kernels());
      return {packet.direction(0), s.albedo, packet.pdf(0), false, false};
    case Scattering::kLobes:
      packet.add(s, nullptr, square);
      packet.sample(widest_kernels(), core::slot_of(s));
      return {packet.direction(0), packet.weight(0), packet.pdf(0), false, false};
    case Scattering::kDelta:
      break;
  }
  const core::SpecularSample out = core::sample_specular(s, to_viewer, square);
  return {out.direction, out.weight, 0, true, out.is_through};
}

}  // namespace tessera::test
