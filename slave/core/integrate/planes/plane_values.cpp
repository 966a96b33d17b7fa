// SPDX-License-Identifier: Apache-2.0
#include "slave/core/integrate/planes/plane_values.h"

#include <array>
#include <limits>

#include "common/base/check.h"
#include "slave/core/surface/surface_lobes.h"

namespace tessera::core {
namespace {

void put(Vec3f v, float* to) {
  for (int a = 0; a < 3; ++a) to[a] = v[a];
}

void alpha(const CameraSample& sample, float* to) { *to = sample.surface != nullptr ? 1 : 0; }

void albedo(const CameraSample& sample, float* to) {
  if (sample.surface == nullptr) return put({}, to);
  const Surface& s = *sample.surface;
  const Material& m = *s.material;
  if (m.is_unlit) return put(s.emission, to);  // set by make_seen()
  if (scattering_of(m.bsdf) == Scattering::kDelta) return put(m.specular, to);
  // Some rays that meet a rough surface with transmission see no base (transmission.h).
  put(passes_light(m) && is_black(s.albedo) ? m.albedo : s.albedo, to);
}

void normal(const CameraSample& sample, float* to) {
  put(sample.surface != nullptr ? sample.surface->shading_normal : Vec3f{}, to);
}

void depth(const CameraSample& sample, float* to) {
  *to = sample.surface != nullptr ? dot(sample.surface->point - sample.eye, sample.view)
                                  : std::numeric_limits<float>::infinity();
}

void position(const CameraSample& sample, float* to) {
  put(sample.surface != nullptr ? sample.surface->point : Vec3f{}, to);
}

// A float holds whole numbers up to 2^24 exactly.
static_assert(std::numeric_limits<float>::digits == 24);
void object(const CameraSample& sample, float* to) { *to = static_cast<float>(sample.object); }
void material(const CameraSample& sample, float* to) { *to = static_cast<float>(sample.material); }

void samples(const CameraSample&, float* to) { *to = 1; }

// Values of the planes, by number of the plane.
constexpr std::array kValues{alpha, albedo, normal, depth, position, object, material, samples};
static_assert(kValues.size() == kPlaneRows.size(), "a plane has a row and a value");

}  // namespace

PlaneValue plane_value(Plane plane) {
  const auto number = static_cast<std::size_t>(plane);
  if (number < kValues.size()) return kValues[number];
  const std::span<const PlaneValue> more = more_plane_values();
  TESSERA_CHECK_LT(number - kValues.size(), more.size());
  return more[number - kValues.size()];
}

}  // namespace tessera::core
