// SPDX-License-Identifier: Apache-2.0
#include "common/viewpoint/interior.h"

namespace tessera {
namespace {

constexpr int kSide = AxisRays::kSide;
constexpr int kFrontsMin = 5;

// Area of the surface that one ray of a bundle along the axis stands for.
double area_per_ray(const AxisRays& rays, std::size_t along) {
  const Vec3d step = rays.step();
  return step[static_cast<int>((along + 1) % 3)] * step[static_cast<int>((along + 2) % 3)];
}

// Calls visit(index) for one point on each ray of the axis.
template <class Visit>
void for_each_ray(std::size_t along, const Visit& visit) {
  for (int v = 0; v < kSide; ++v) {
    for (int u = 0; u < kSide; ++u) {
      std::array<int, 3> place{};
      place[(along + 1) % 3] = u;
      place[(along + 2) % 3] = v;
      visit(AxisRays::index(place[0], place[1], place[2]));
    }
  }
}

}  // namespace

bool is_in_room(const AxisRays& rays, int index) {
  int fronts = 0;
  for (const Axis axis : kAxes) {
    const AxisRays::Met met = rays.met(index, axis);
    fronts += met.is_any() && met.is_front;
  }
  return fronts >= kFrontsMin;
}

// The surface is measured by how often rays cross it (M. Crofton, 1868), between neighbours on a
// ray: each crossing is a share of the area that is seen from the side it is met on.
InteriorEvidence evidence_of(const AxisRays& rays) {
  InteriorEvidence evidence;
  if (rays.is_empty()) return evidence;
  double inside = 0, outside = 0;
  int in_rooms = 0;
  for (int i = 0; i < AxisRays::kPoints; ++i) {
    const bool is_room = is_in_room(rays, i);
    in_rooms += is_room;
    for (const Axis axis : kAxes) {
      const std::size_t along = static_cast<std::size_t>(axis) / 2;
      const AxisRays::Met met = rays.met(i, axis);
      if (!met.is_any() || !met.is_front) continue;
      if (met.distance > rays.step()[static_cast<int>(along)]) continue;
      (is_room ? inside : outside) += area_per_ray(rays, along);
    }
  }
  for (const Axis axis : kAxes) {
    const auto way = static_cast<std::size_t>(axis), along = way / 2;
    const double step = rays.step()[static_cast<int>(along)];
    int deep = 0, met_any = 0, met_front = 0;
    for_each_ray(along, [&](int index) {
      const AxisRays::Met met = rays.met_from_outside(index, axis);
      met_any += met.is_any();
      if (!met.is_any() || !met.is_front) return;
      ++met_front;
      if (met.distance <= 0.5 * step) outside += area_per_ray(rays, along);
      deep += met.distance > 0.5 * kSide * step;
    });
    evidence.depth[way] = deep / double{kSide * kSide};
    evidence.fronts[way] = met_any > 0 ? met_front / double(met_any) : 0;
  }
  evidence.room_volume = in_rooms / double{AxisRays::kPoints};
  evidence.room_surface = inside > 0 ? inside / (inside + outside) : 0;
  return evidence;
}

}  // namespace tessera
