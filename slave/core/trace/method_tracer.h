// SPDX-License-Identifier: Apache-2.0
// Traces rays through a scene with patches by a method of the frame's, one by one.
//
// Threads. Constant after construction; any number of threads.
#pragma once

#include <optional>
#include <variant>

#include "slave/core/kernels/method_kernels.h"
#include "slave/core/primitive/primitive_index.h"

namespace tessera::core {

class MethodTracer {
 public:
  // Returns: nothing where the scene has no patches. Requires: the index and the call's settings
  // outlive it.
  static std::optional<MethodTracer> make(const PrimitiveIndex& index, const PatchMethodCall& call,
                                          Isa isa);

  SingleHit closest(const SingleRay& ray) const;
  bool occluded(const SingleRay& ray) const;

 private:
  template <class View>
  struct Way {
    View view;
    MethodKernels<View> kernels;
  };

  template <class AnyWay>
  explicit MethodTracer(const AnyWay& way) : way_(way) {}

  std::variant<Way<MethodView<8>>, Way<MethodView<16>>, Way<MethodPlacesView<8>>,
               Way<MethodPlacesView<16>>>
      way_;
};

}  // namespace tessera::core
