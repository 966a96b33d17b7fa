// SPDX-License-Identifier: Apache-2.0
// Counter-based samples: a pure function of (seed, pixel, dimension, index), so that a pixel is the
// same in every tile, on every slave and at every attempt.
//
// The sequence is the (0,2)-sequence of van der Corput and Sobol with random digit scrambling,
// after Kollig and Keller, "Efficient multidimensional sampling", 2002. Any run of 2^k indices from
// a multiple of 2^k is stratified in all elementary intervals of area 2^-k.
#pragma once

#include <cstdint>

#include "common/math/vec3.h"

namespace tessera::core {

// A 32-bit mix with full avalanche (the finaliser of MurmurHash3; Appleby 2011).
constexpr std::uint32_t mix_bits(std::uint32_t h) {
  h ^= h >> 16;
  h *= 0x85ebca6bu;
  h ^= h >> 13;
  h *= 0xc2b2ae35u;
  h ^= h >> 16;
  return h;
}

constexpr std::uint32_t hash_combine(std::uint32_t h, std::uint32_t value) {
  return mix_bits(h ^ (value + 0x9e3779b9u + (h << 6) + (h >> 2)));
}

// 24 high bits to [0, 1): exact, never 1.
constexpr float unit_float(std::uint32_t bits) {
  return static_cast<float>(bits >> 8) * (1.0f / 16777216.0f);
}

constexpr std::uint32_t van_der_corput_bits(std::uint32_t i) {
  i = (i << 16) | (i >> 16);
  i = ((i & 0x00ff00ffu) << 8) | ((i & 0xff00ff00u) >> 8);
  i = ((i & 0x0f0f0f0fu) << 4) | ((i & 0xf0f0f0f0u) >> 4);
  i = ((i & 0x33333333u) << 2) | ((i & 0xccccccccu) >> 2);
  return ((i & 0x55555555u) << 1) | ((i & 0xaaaaaaaau) >> 1);
}

// Sobol's second dimension has Pascal's triangle modulo 2 as its matrix: bit j of the index goes with all
// bits whose number holds that of j (Lucas), which five steps sum up.
constexpr std::uint32_t sobol2_bits(std::uint32_t i) {
  i ^= i >> 1 & 0x55555555u;
  i ^= i >> 2 & 0x33333333u;
  i ^= i >> 4 & 0x0f0f0f0fu;
  i ^= i >> 8 & 0x00ff00ffu;
  i ^= i >> 16;
  return van_der_corput_bits(i);
}

// Another order of the indices: aligned runs of 2^k stay together, and within them every order is as
// likely. Uses of one index in several dimensions are to go through keys of their own, or else the
// dimensions are not independent, however their points are scrambled. Burley, "Practical hash-based
// Owen scrambling", JCGT 9(4), 2020, with the hash of Laine and Karras, 2011.
constexpr std::uint32_t shuffled_index(std::uint32_t index, std::uint32_t key) {
  std::uint32_t x = van_der_corput_bits(index);
  x += key;
  x ^= x * 0x6c50b47cu;
  x ^= x * 0xb82f1e52u;
  x ^= x * 0xc7afe638u;
  x ^= x * 0x8d22f6e6u;
  return van_der_corput_bits(x);
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
  // In [0, 1)^2.
  Vec2f scrambled(std::uint32_t key) const {
    return {unit_float(x_ ^ key), unit_float(y_ ^ mix_bits(key))};
  }

 private:
  std::uint32_t x_, y_;
};

// Point `index` of the sequence scrambled by key, in [0, 1)^2.
inline Vec2f sample_2d(std::uint32_t key, std::uint32_t index) {
  return SequencePoint(index).scrambled(key);
}

// As sample_2d(), the points in another order: for each of several uses of one index.
inline Vec2f shuffled_2d(std::uint32_t key, std::uint32_t index) {
  return sample_2d(key, shuffled_index(index, hash_combine(key, 0x68bc21ebu)));
}

}  // namespace tessera::core
