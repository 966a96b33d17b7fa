// SPDX-License-Identifier: Apache-2.0
// BSDFs of some surfaces at a time, for the kernels (slave/core/bsdf/bsdfs-inl.h).
//
// Threads. One object per thread.
#pragma once

#include <array>
#include <cstdint>
#include <memory>

#include "slave/core/kernels/kernel_table.h"
#include "slave/core/simd/axis_arrays.h"
#include "slave/core/surface/surface.h"
#include "slave/core/surface/surface_lobes.h"

namespace tessera::core {

inline constexpr int kDiffuseSlot = static_cast<int>(BsdfKind::kDiffuse);
static_assert(kBsdfSlots <= 32);  // BsdfPackets::used_ has one bit for each

// The slot of KernelTable::bsdfs that computes a surface's BSDF.
inline int slot_of(const Surface& s) {
  return s.lobes == kNoLobes ? static_cast<int>(s.bsdf) : kLayeredSlot;
}

// Surfaces of one slot. All of them are either sampled or evaluated.
class BsdfPacket {
 public:
  static constexpr int kMax = kBsdfPoints;

  void clear() { points_.count = 0; }
  int count() const { return points_.count; }

  // Returns: the number of the surface, from 0. Requires: count() < kMax.
  int add_diffuse(Vec3f shading_normal, Vec2f square);
  // lobes: those of a surface in kLayeredSlot, else null.
  int add(const Surface& s, const SurfaceLobes* lobes, Vec2f square);    // to be sampled
  int add(const Surface& s, const SurfaceLobes* lobes, Vec3f to_light);  // to be evaluated

  // slot: that of all the surfaces.
  void sample(const KernelTable& kernels, int slot);
  void evaluate(const KernelTable& kernels, int slot);
  void sample_diffuse(const KernelTable& kernels);

  // Direction towards the light, unit.
  Vec3f direction(int i) const { return vector_at(points_.direction, i); }
  // BSDF times cosine over pdf, of a sampled surface. Zero: no light comes from that direction.
  // Requires: the surface is not diffuse; the weight of a diffuse one is its albedo.
  Vec3f weight(int i) const { return vector_at(points_.value, i); }
  // BSDF times pi, of an evaluated surface. For a diffuse surface that is its albedo.
  Vec3f times_pi(int i) const { return vector_at(points_.value, i); }
  // Pdf with which the BSDF samples the direction, by solid angle.
  float pdf(int i) const { return points_.pdf[i]; }

 private:
  int add(Vec3f shading_normal);
  void put(const Surface& s, const SurfaceLobes* lobes, int i);
  void put_lobes(const SurfaceLobes& lobes, int i);

  BsdfPoints points_{};
  std::unique_ptr<LobePoints> lobes_;  // allocated for the first layered surface
  bool has_sheen_ = false;             // whether any layered surface so far had a sheen
  bool has_coat_ = false;              // likewise, varnish
};

// Surfaces of any kind except specular ones, sorted into a packet for each slot. Packets are made
// when they are first needed.
class BsdfPackets {
 public:
  struct Place {
    const BsdfPacket* packet;
    int number;
  };

  void clear();
  // Requires: fewer than BsdfPacket::kMax of the slot.
  Place add(const Surface& s, const SurfaceLobes* lobes, Vec2f square) {
    const int slot = slot_of(s);
    std::unique_ptr<BsdfPacket>& packet = packets_[static_cast<std::size_t>(slot)];
    if (packet == nullptr) [[unlikely]]
      packet = std::make_unique<BsdfPacket>();
    used_ |= 1u << slot;
    if (slot == kDiffuseSlot) return {packet.get(), packet->add_diffuse(s.shading_normal, square)};
    return {packet.get(), packet->add(s, lobes, square)};
  }
  void sample(const KernelTable& kernels);

 private:
  std::array<std::unique_ptr<BsdfPacket>, kBsdfSlots> packets_;
  std::uint32_t used_ = 0;  // bits of slots
};

}  // namespace tessera::core
