// SPDX-License-Identifier: Apache-2.0
// Brick: courses of `width` x `height` with joints of mortar, every second course moved by half a
// brick, laid on the two axes that the surface faces least. The material's albedo is the brick,
// whose stones differ by `variation`.
#include <algorithm>
#include <cmath>

#include "slave/core/sampling/sample_sequence.h"
#include "slave/core/surface/programs.h"

namespace tessera::core {
namespace {

// The part of [x - w / 2, x + w / 2] that lies in the joints, at every whole number, `joint` wide
// (all in bricks): exact for a box as wide as the footprint.
float joint_share(float x, float joint, float w) {
  const auto covered = [joint](float t) {  // of [0, t]
    const float whole = std::floor(t + 0.5f);
    return whole * joint + std::clamp(t - whole, -joint / 2, joint / 2);
  };
  w = std::max(w, 1e-3f);  // a joint's edge is never sharper than a thousandth of a brick
  return std::clamp((covered(x + w / 2) - covered(x - w / 2)) / w, 0.0f, 1.0f);
}

Vec3f sizes_of(Vec3f v) { return {std::fabs(v.x), std::fabs(v.y), std::fabs(v.z)}; }

std::uint32_t number_of(float f) {
  return static_cast<std::uint32_t>(static_cast<int>(std::clamp(f, -1e9f, 1e9f)));
}

}  // namespace

void apply_brick(const SurfaceParameters& parameters, const SurfacePlaces& places) {
  const float width = parameters[0], height = parameters[1], joint = parameters[2];
  const Vec3f mortar{parameters[4], parameters[5], parameters[6]};
  for (std::size_t i = 0; i < places.surface.size(); ++i) {
    const auto at = [i](const SurfacePlaces::Axes& v) { return Vec3f{v[0][i], v[1][i], v[2][i]}; };
    const Vec3f n = sizes_of(at(places.normal)), p = at(places.point);
    const float footprint = places.footprint[i];
    // Courses lie level on walls, whose y axis points up; on floors they run along x.
    const bool is_floor = n.y >= n.x && n.y >= n.z;
    const float up = is_floor ? p.z : p.y, level = !is_floor && n.x > n.z ? p.z : p.x;
    const float y = up / height, course = std::floor(y);
    const bool is_moved = (number_of(course) & 1u) != 0;
    const float x = level / width + (is_moved ? 0.5f : 0.0f);
    const float across = joint_share(y, std::min(joint / height, 1.0f), footprint / height);
    const float along = joint_share(x, std::min(joint / width, 1.0f), footprint / width);
    const float share = 1 - (1 - across) * (1 - along);
    const std::uint32_t stone =
        hash_combine(hash_combine(0x62726963u, number_of(std::floor(x))), number_of(course));
    const float shown = std::clamp(2 - 2 * footprint / height, 0.0f, 1.0f);
    const float dark = 1 - parameters[3] * (0.5f + (unit_float(stone) - 0.5f) * shown);
    Vec3f& albedo = places.surface[i]->albedo;
    albedo = albedo * (dark * (1 - share)) + mortar * share;
  }
}

}  // namespace tessera::core
