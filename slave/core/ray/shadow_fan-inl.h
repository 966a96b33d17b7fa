// SPDX-License-Identifier: Apache-2.0
// One of the fans of ShadowFans, as those that trace it take it.
//
// Threads. A plain value; the fans have to outlive it.
#include "slave/core/ray/packet_layout.h"

#if defined(TESSERA_CORE_SHADOW_FAN_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef TESSERA_CORE_SHADOW_FAN_INL_H_
#undef TESSERA_CORE_SHADOW_FAN_INL_H_
#else
#define TESSERA_CORE_SHADOW_FAN_INL_H_
#endif

#include "slave/core/simd/real-inl.h"

HWY_BEFORE_NAMESPACE();
namespace tessera::core {
namespace HWY_NAMESPACE {

struct ShadowFan {
  HWY_INLINE ShadowFan(const ShadowFans& all, int g)
      : fans(all),
        first(static_cast<size_t>(all.targets->group[g])),
        count(static_cast<size_t>(all.targets->group[g + 1]) - first),
        face(all.targets->face[g]),
        active(~uint64_t{0} >> (kPacketRays - count)) {}

  const ShadowFans& fans;
  size_t first, count;  // of `order`
  int face;
  uint64_t active;
};

}  // namespace HWY_NAMESPACE
}  // namespace tessera::core
HWY_AFTER_NAMESPACE();

#endif  // per-target include guard
