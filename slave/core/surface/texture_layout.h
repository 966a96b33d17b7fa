// SPDX-License-Identifier: Apache-2.0
// Textures as the kernels see them.
// Fixed-size types only and no functions.
#pragma once

#include <stdint.h>

namespace tessera::core {

inline constexpr int kTextureLevelsMax = 32;

// TextureWrap of common/scene/scene.h.
enum class EdgeWrap : int32_t { kRepeat = 0, kMirror = 1, kClamp = 2 };

// A mip map of sides of at most 2^14.
struct TextureView {
  // RGBA of 8 or 16 bits a channel, rows from the top. Level 0 is the texture itself; sides of
  // level i are shifted right by i, and at least 1.
  const void* level[kTextureLevelsMax];
  int32_t width, height;    // of level 0
  int32_t last;             // number of the last level
  const float* srgb_table;  // [256] or [65536], linear light of RGB; null: linear, the highest is 1
  EdgeWrap wrap_u, wrap_v;
  bool is_nearest;  // level 0 is not interpolated
  bool is_wide;     // 16 bits a channel
};

}  // namespace tessera::core
