// SPDX-License-Identifier: Apache-2.0
// Pictures that vary what emitters emit.
// Threads. Pure functions.
#pragma once

#include "slave/core/light/emitter.h"

namespace tessera::core {

// About the mean of what a triangle shows of a map: over the texels of the box around it, and those
// that bilinear lookups reach, in a mip level where they are few. Levels are rounded to bytes;
// where a level is black and the base is not, the mean is taken for half the least byte. It is zero
// only where all is black.
Vec3f mean_over(const MipMap& map, const EmitterTexture& at);

}  // namespace tessera::core
