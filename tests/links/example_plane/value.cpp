// SPDX-License-Identifier: Apache-2.0
// Linked in place of slave/core/integrate/planes/more_plane_values.cpp.
#include "slave/core/integrate/planes/plane_values.h"

namespace tessera::core {
namespace {

// Cosine between the normal and the way to the camera; 0 where nothing is hit.
void facing(const CameraSample& sample, float* to) {
  if (sample.surface == nullptr) return;
  *to = dot(sample.surface->shading_normal, normalize(sample.eye - sample.surface->point));
}

constexpr PlaneValue kValues[] = {facing};

}  // namespace

std::span<const PlaneValue> more_plane_values() { return kValues; }

}  // namespace tessera::core
