// SPDX-License-Identifier: Apache-2.0
// Makes the answer of a sub-patch of a method that finds its roots.
// Threads. Pure functions.
#pragma once

#include "slave/core/primitive/patch/methods/patch_method_abi.h"
#include "slave/core/primitive/patch/methods/ray_sight.h"

namespace tessera::core {

template <class Function>
struct HowOf;
template <class Result, class How>
struct HowOf<Result (*)(const How&, const Patch&, const SubPatch&, const RaySight&, NearestRoot&)> {
  using Type = How;
};

// kRoots: a function of the settings, the patch, the sub-patch and the ray that adds roots. Fits
// PatchMethodCall::answer.
template <auto kRoots>
PatchAnswer method_answer(const void* how, const Patch& patch, const SubPatch& part,
                          const float* origin, const float* direction, float t_min) {
  const RaySight sight(origin, direction);
  NearestRoot nearest(patch, part, sight, t_min);
  kRoots(*static_cast<const typename HowOf<decltype(kRoots)>::Type*>(how), patch, part, sight,
         nearest);
  return nearest.answer();
}

}  // namespace tessera::core
