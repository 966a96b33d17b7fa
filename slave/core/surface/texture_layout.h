// Textures as the kernels see them.
// Fixed-size types only and no functions.
#pragma once

#include <stdint.h>

namespace tessera::core {

inline constexpr int kTextureLevelsMax = 32;

// A mip map of sides of at most 2^14.
struct TextureView {
  // RGBA, rows from the top. Level 0 is the texture itself; sides of level i are shifted right by i,
  // and at least 1.
  const uint8_t* level[kTextureLevelsMax];
  int32_t width, height;    // of level 0
  int32_t last;             // level
  const float* srgb_table;  // [256], linear light of bytes; null: they are linear, 255 is 1
};

}  // namespace tessera::core
