// SPDX-License-Identifier: Apache-2.0
#include "slave/core/integrate/bsdf_packet.h"

#include <bit>

#include "slave/core/bsdf/albedo_table.h"
#include "slave/core/bsdf/coat_table.h"
#include "slave/core/bsdf/sheen_table.h"
#include "slave/core/simd/axis_arrays.h"

namespace tessera::core {
namespace {

// The tables of sheens and of varnish take longer to make than a small picture, so they are made
// only where a point has a sheen or varnish. Elsewhere their values count for nothing, and any
// table serves.
LobeTables lobe_tables(bool has_sheen, bool has_coat) {
  const AlbedoView facets = AlbedoTable::shared().view();
  return {facets, has_sheen ? SheenTable::shared().view() : facets,
          has_coat ? CoatTable::shared().view() : CoatTable::none()};
}

}  // namespace

int BsdfPacket::add(Vec3f shading_normal) {
  const int i = points_.count++;
  put_vector(shading_normal, points_.normal, i);
  return i;
}

int BsdfPacket::add_diffuse(Vec3f shading_normal, Vec2f square) {
  const int i = add(shading_normal);
  points_.square[0][i] = square.x;
  points_.square[1][i] = square.y;
  return i;
}

void BsdfPacket::put(const Surface& s, const SurfaceLobes* lobes, int i) {
  put_vector(s.to_viewer, points_.to_viewer, i);
  put_vector(s.albedo, points_.albedo, i);
  put_vector(s.material->specular, points_.specular, i);
  points_.roughness[i] = s.roughness;
  points_.metalness[i] = s.metalness;
  if (lobes != nullptr) put_lobes(*lobes, i);
}

int BsdfPacket::add(const Surface& s, const SurfaceLobes* lobes, Vec2f square) {
  const int i = add_diffuse(s.shading_normal, square);
  put(s, lobes, i);
  return i;
}

int BsdfPacket::add(const Surface& s, const SurfaceLobes* lobes, Vec3f to_light) {
  const int i = add(s.shading_normal);
  put(s, lobes, i);
  put_vector(to_light, points_.direction, i);
  return i;
}

void BsdfPacket::put_lobes(const SurfaceLobes& lobes, int i) {
  if (lobes_ == nullptr) lobes_ = std::make_unique<LobePoints>();
  LobePoints& to = *lobes_;
  put_vector(lobes.specular, points_.specular, i);
  to.specular_f90[i] = lobes.specular_f90;
  to.coat[i] = lobes.coat;
  has_coat_ = has_coat_ || lobes.coat > 0;
  to.coat_roughness[i] = lobes.coat_roughness;
  put_vector(lobes.coat_normal, to.coat_normal, i);
  put_vector(lobes.sheen, to.sheen, i);
  has_sheen_ = has_sheen_ || !is_black(lobes.sheen);
  to.sheen_roughness[i] = lobes.sheen_roughness;
  to.stretch[i] = lobes.stretch;
  put_vector(lobes.tangent, to.tangent, i);
}

void BsdfPacket::sample(const KernelTable& kernels, int slot) {
  kernels.bsdfs.of[slot].sample(lobe_tables(has_sheen_, has_coat_), lobes_.get(), points_);
}
void BsdfPacket::evaluate(const KernelTable& kernels, int slot) {
  kernels.bsdfs.of[slot].evaluate(lobe_tables(has_sheen_, has_coat_), lobes_.get(), points_);
}
void BsdfPacket::sample_diffuse(const KernelTable& kernels) {
  kernels.bsdfs.of[kDiffuseSlot].sample({}, nullptr, points_);
}

void BsdfPackets::clear() {
  for (; used_ != 0; used_ &= used_ - 1)
    packets_[static_cast<std::size_t>(std::countr_zero(used_))]->clear();
}

void BsdfPackets::sample(const KernelTable& kernels) {
  for (std::uint32_t left = used_; left != 0; left &= left - 1) {
    const int slot = std::countr_zero(left);
    BsdfPacket& packet = *packets_[static_cast<std::size_t>(slot)];
    slot == kDiffuseSlot ? packet.sample_diffuse(kernels) : packet.sample(kernels, slot);
  }
}

}  // namespace tessera::core
