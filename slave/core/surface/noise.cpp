#include "slave/core/surface/noise.h"

#include <algorithm>
#include <cmath>

#include "slave/core/sampling/sample_sequence.h"

namespace tessera::core {
namespace {

constexpr int kOctaves = 6;
// Of |noise| over space, measured once; what a faded octave leaves.
constexpr float kMeanSize = 0.21f;

float fade(float t) { return t * t * t * (t * (t * 6 - 15) + 10); }
float mixed(float t, float a, float b) { return a + t * (b - a); }

// Component along the gradient of a lattice point: one of 12 edge directions, four of them twice.
float along_gradient(std::uint32_t hash, float x, float y, float z) {
  const std::uint32_t h = hash >> 28;
  const float u = h < 8 ? x : y;
  const float v = h < 4 ? y : h == 12 || h == 14 ? x : z;
  return ((h & 1u) != 0 ? -u : u) + ((h & 2u) != 0 ? -v : v);
}

}  // namespace

float gradient_noise(Vec3f p, std::uint32_t seed) {
  constexpr float kFar = 4194304;
  if (!(std::fabs(p.x) < kFar && std::fabs(p.y) < kFar && std::fabs(p.z) < kFar)) return 0;
  const float fx = std::floor(p.x), fy = std::floor(p.y), fz = std::floor(p.z);
  const float x = p.x - fx, y = p.y - fy, z = p.z - fz;
  const auto lattice = [](float f) { return static_cast<std::uint32_t>(static_cast<int>(f)); };
  const std::uint32_t ix = lattice(fx), iy = lattice(fy), iz = lattice(fz);
  // One mix a corner: products with odd numbers keep neighbours apart (Teschner et al., "Optimized
  // spatial hashing", 2003), the mix makes chance of it.
  const std::uint32_t at_x[2] = {ix * 73856093u + seed, (ix + 1) * 73856093u + seed};
  const std::uint32_t at_y[2] = {iy * 19349663u, (iy + 1) * 19349663u};
  const std::uint32_t at_z[2] = {iz * 83492791u, (iz + 1) * 83492791u};
  float corner[8];
  for (std::uint32_t i = 0; i < 8; ++i) {
    const std::uint32_t dx = i & 1u, dy = i >> 1 & 1u, dz = i >> 2;
    corner[i] = along_gradient(mix_bits(at_x[dx] ^ at_y[dy] ^ at_z[dz]), x - static_cast<float>(dx),
                               y - static_cast<float>(dy), z - static_cast<float>(dz));
  }
  const float u = fade(x), v = fade(y), w = fade(z);
  const float low = mixed(v, mixed(u, corner[0], corner[1]), mixed(u, corner[2], corner[3]));
  const float high = mixed(v, mixed(u, corner[4], corner[5]), mixed(u, corner[6], corner[7]));
  return std::clamp(mixed(w, low, high), -1.0f, 1.0f);
}

float turbulence(Vec3f p, std::uint32_t seed, float footprint) {
  float sum = 0, amplitude = 1;
  for (std::uint32_t octave = 0; octave < kOctaves; ++octave) {
    // An octave's wave is one unit: gone where two of them are not as wide as the footprint.
    const float shown = std::clamp(2 - 2 * footprint, 0.0f, 1.0f);
    const float size =
        shown > 0 ? std::fabs(gradient_noise(p, seed + octave)) * shown + kMeanSize * (1 - shown)
                  : kMeanSize;
    sum += amplitude * size;
    amplitude *= 0.5f;
    p = p * 2;
    footprint *= 2;
  }
  return sum;
}

}  // namespace tessera::core
