// SPDX-License-Identifier: Apache-2.0
// GGX microfacets for plain numbers, from the text of microfacet-inl.h.
// Threads. Pure functions.
#pragma once

#define TESSERA_PLAIN_TEXT

#include "common/math/vec3.h"
#include "slave/core/bsdf/microfacet-inl.h"

namespace tessera::core {

using plain::alpha_of;
using plain::kAlphaMin;
using plain::schlick_rise;
using plain::shadowing_weight;
using plain::smith_root;

inline Vec3f visible_normal(Vec3f to_viewer, float alpha, Vec2f square) {
  return plain::visible_normal(to_viewer, alpha, square.x, square.y);
}

}  // namespace tessera::core
