// SPDX-License-Identifier: Apache-2.0
// The entry points of a structure, for the instruction set that is being compiled.
//
// Threads. Constants.
#include "slave/core/kernels/view_tables_layout.h"

#if defined(TESSERA_CORE_VIEW_KERNELS_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef TESSERA_CORE_VIEW_KERNELS_INL_H_
#undef TESSERA_CORE_VIEW_KERNELS_INL_H_
#else
#define TESSERA_CORE_VIEW_KERNELS_INL_H_
#endif

#include "slave/core/traverse/entry-inl.h"
#include "slave/core/traverse/many_call-inl.h"

HWY_BEFORE_NAMESPACE();
namespace tessera::core {
namespace HWY_NAMESPACE {

template <class View>
void enter_fans(const View& scene, const FanWindow& window, FanEntry& entry) {
  find_entry(scene, window, entry);
}

template <class View>
constexpr ViewKernels<View> kKernels{closest_ray<View>,  occluded_ray<View>, enter_fans<View>,
                                     closest_fan<View>,  occluded_fan<View>, occluded_fans<View>,
                                     closest_many<View>, occluded_many<View>};

template <template <int> class View>
constexpr ViewTables<View> view_tables() {
  return {kKernels<View<8>>, kKernels<View<16>>};
}

}  // namespace HWY_NAMESPACE
}  // namespace tessera::core
HWY_AFTER_NAMESPACE();

#endif  // per-target include guard
