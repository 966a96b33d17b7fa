// SPDX-License-Identifier: Apache-2.0
// Counter-based samples: a pure function of (seed, pixel, dimension, index), so that a pixel is the
// same in every tile, on every slave and at every attempt.
//
// The sequence is the (0,2)-sequence of van der Corput and Sobol with random digit scrambling,
// after Kollig and Keller, "Efficient multidimensional sampling", 2002. Any run of 2^k indices from
// a multiple of 2^k is stratified in all elementary intervals of area 2^-k.
#pragma once

#define TESSERA_PLAIN_TEXT

#include <cstdint>

#include "common/math/vec3.h"
#include "slave/core/sampling/sequence-inl.h"

namespace tessera::core {

using plain::shuffled_index;
using plain::sobol2_bits;
using plain::unit_float;
using plain::van_der_corput_bits;

constexpr std::uint32_t mix_bits(std::uint32_t h) { return plain::mix_bits(h); }
constexpr std::uint32_t hash_combine(std::uint32_t h, std::uint32_t value) {
  return plain::hash_combine(h, value);
}

constexpr std::uint32_t frame_seed(std::uint32_t seed) { return mix_bits(seed ^ 0x5bd1e995u); }

// Independent scramble of one use of one pixel; dimensions are numbered by the renderer.
constexpr std::uint32_t pixel_key(std::uint32_t seed, int x_px, int y_px, std::uint32_t dimension) {
  std::uint32_t h = frame_seed(seed);
  h = hash_combine(h, static_cast<std::uint32_t>(x_px));
  h = hash_combine(h, static_cast<std::uint32_t>(y_px));
  return hash_combine(h, dimension);
}

// One point of the sequence, for many keys.
class SequencePoint {
 public:
  explicit SequencePoint(std::uint32_t index)
      : x_(van_der_corput_bits(index)), y_(sobol2_bits(index)) {}
  std::uint32_t x_bits() const { return x_; }
  std::uint32_t y_bits() const { return y_; }
  // The point scrambled by `key`, in [0, 1)^2.
  Vec2f scrambled(std::uint32_t key) const {
    const auto point = plain::scrambled_point(x_, y_, key);
    return {point.x, point.y};
  }

 private:
  std::uint32_t x_, y_;
};

// Point `index` of the sequence scrambled by key, in [0, 1)^2.
inline Vec2f sample_2d(std::uint32_t key, std::uint32_t index) {
  return SequencePoint(index).scrambled(key);
}

// As sample_2d(), but with the points in an order of the key, for each of several uses of one
// index.
inline Vec2f shuffled_2d(std::uint32_t key, std::uint32_t index) {
  const auto point = plain::shuffled_point(key, index);
  return {point.x, point.y};
}

}  // namespace tessera::core
