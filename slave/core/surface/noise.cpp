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
  float corner[8];
  for (std::uint32_t dx = 0; dx < 2; ++dx) {
    const std::uint32_t of_x = hash_combine(seed, ix + dx);
    for (std::uint32_t dy = 0; dy < 2; ++dy) {
      const std::uint32_t of_xy = hash_combine(of_x, iy + dy);
      for (std::uint32_t dz = 0; dz < 2; ++dz) {
        corner[dx | dy << 1 | dz << 2] =
            along_gradient(hash_combine(of_xy, iz + dz), x - static_cast<float>(dx),
                           y - static_cast<float>(dy), z - static_cast<float>(dz));
      }
    }
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
