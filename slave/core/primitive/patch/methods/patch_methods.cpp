// SPDX-License-Identifier: Apache-2.0
#include "slave/core/primitive/patch/methods/patch_methods.h"

#include "slave/core/primitive/patch/methods/clip.h"
#include "slave/core/primitive/patch/methods/krawczyk_boxes.h"
#include "slave/core/primitive/patch/methods/method_answer.h"
#include "slave/core/primitive/patch/methods/newton.h"
#include "slave/core/primitive/patch/methods/refine_walk.h"

namespace tessera::core {
namespace {

struct KrawczykHow {};

void krawczyk(const KrawczykHow&, const Patch& patch, const SubPatch&, const RaySight& sight,
              NearestRoot& to) {
  krawczyk_roots<ClippedBounds>(patch, sight, to);
}

constexpr RefineHow kRefine;
constexpr NewtonHow kNewton;
constexpr KrawczykHow kKrawczyk;
constexpr ClipHow kClip;
constexpr PatchMethodCall kCalls[] = {{nullptr, nullptr},
                                      {method_answer<refined_roots<BilinearFacet>>, &kRefine},
                                      {method_answer<newton_roots>, &kNewton},
                                      {method_answer<krawczyk>, &kKrawczyk},
                                      {method_answer<clip_roots>, &kClip}};

}  // namespace

const PatchMethodCall* patch_method_call(PatchMethod method) {
  return method == PatchMethod::kAuto ? nullptr : &kCalls[static_cast<int>(method)];
}

PatchAnswer answer_by(PatchMethod method, const Patch& patch, const SubPatch& part,
                      const float* origin, const float* direction, float t_min) {
  const PatchMethodCall* const call = patch_method_call(method);
  return call == nullptr ? patch_answer(patch, part, origin, direction, t_min)
                         : call->answer(call->how, patch, part, origin, direction, t_min);
}

double method_error(PatchMethod method, const Patch& patch) {
  if (method == PatchMethod::kAuto) return 0;
  if (method == PatchMethod::kRefine) return facet_error(kRefine, patch);
  return 4 * kMethodAccuracy * patch.extent;
}

}  // namespace tessera::core
