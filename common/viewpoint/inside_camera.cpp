// SPDX-License-Identifier: Apache-2.0
#include "common/viewpoint/inside_camera.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "common/viewpoint/interior.h"

namespace tessera {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr double kAngleStep = 2 * std::numbers::pi / kSights;

std::size_t at(int sight) {
  return static_cast<std::size_t>((sight % kSights + kSights) % kSights);
}

// Distance of the nearest surface at either of the two heights.
double clearance(const EyePlace& place) {
  const auto nearest = [](const Sights& sights) {
    return *std::min_element(sights.distance.begin(), sights.distance.end());
  };
  return std::min(nearest(place.eye), nearest(place.below));
}

// Area of the floor plan that a picture shows, as a sum of sectors.
double area_seen(const Sights& sights, int direction, int sights_to_a_side) {
  double area = 0;
  for (int i = -sights_to_a_side; i <= sights_to_a_side; ++i) {
    const double sight = sights.distance[at(direction + i)];
    if (sight < kInfinity) area += 0.5 * kAngleStep * sight * sight;
  }
  return area;
}

// What the six rays from a point say of the room around it.
struct RoomAround {
  double down, height, eye_height;

  RoomAround(const AxisRays& rays, int index) {
    const Vec3d p = rays.point(index), low = widened(rays.bounds().lower),
                high = widened(rays.bounds().upper);
    // A ray that leaves reaches as far as the box.
    const auto reach = [&](Axis axis, double to_side) {
      const AxisRays::Met met = rays.met(index, axis);
      return met.is_any() ? double{met.distance} : to_side;
    };
    down = reach(Axis::kDown, p.y - low.y);
    height = down + reach(Axis::kUp, high.y - p.y);
    const double width = reach(Axis::kRight, high.x - p.x) + reach(Axis::kLeft, p.x - low.x);
    const double depth = reach(Axis::kBack, high.z - p.z) + reach(Axis::kAhead, p.z - low.z);
    eye_height = 0.5 * std::min({height, width, depth});
  }
};

}  // namespace

Vec3d sight_direction(int i) { return {std::sin(i * kAngleStep), 0, -std::cos(i * kAngleStep)}; }

std::vector<EyePlace> eye_places(const AxisRays& rays) {
  std::vector<EyePlace> places;
  if (rays.is_empty()) return places;
  for (int i = 0; i < AxisRays::kPoints; ++i) {
    if (!is_in_room(rays, i) || !rays.met(i, Axis::kDown).is_any()) continue;
    const RoomAround room(rays, i);
    if (!(std::abs(room.down - room.eye_height) <= 0.5 * rays.step().y)) continue;
    EyePlace place;
    place.eye.from = rays.point(i);
    place.eye.from.y += room.eye_height - room.down;
    place.below.from = place.eye.from - Vec3d{0, 0.5 * room.eye_height, 0};
    place.above_floor = room.eye_height;
    place.below_ceiling = room.height - room.eye_height;
    if (place.below_ceiling > 0) places.push_back(place);
  }
  if (places.size() > kEyePlacesMax) {
    for (std::size_t i = 0; i < kEyePlacesMax; ++i)
      places[i] = places[i * places.size() / kEyePlacesMax];
    places.resize(kEyePlacesMax);
  }
  return places;
}

namespace {

// The two ends of the line in which a triangle cuts the level plane of an eye, from the eye.
struct Cut {
  std::array<Vec3d, 2> end;
  bool is_any = false;

  Cut(const std::array<Vec3d, 3>& triangle, Vec3d eye) {
    std::size_t count = 0;
    for (std::size_t i = 0; i < 3 && count < 2; ++i) {
      const Vec3d p = triangle[i] - eye, q = triangle[(i + 1) % 3] - eye;
      if ((p.y < 0) == (q.y < 0)) continue;
      const double share = p.y / (p.y - q.y);
      end[count++] = {p.x + share * (q.x - p.x), 0, p.z + share * (q.z - p.z)};
    }
    is_any = count == 2;
  }
};

void see(const Cut& cut, Sights& sights) {
  // Angles as sight_direction() counts them; the line covers the lesser of the two ranges.
  const auto angle = [](Vec3d v) { return std::atan2(v.x, -v.z) / kAngleStep; };
  double low = angle(cut.end[0]), high = angle(cut.end[1]);
  if (low > high) std::swap(low, high);
  if (high - low > kSights / 2.0) {
    low += kSights;
    std::swap(low, high);
  }
  const Vec3d a = cut.end[0], ab = cut.end[1] - a;
  for (int i = static_cast<int>(std::ceil(low)); i <= static_cast<int>(std::floor(high)); ++i) {
    const Vec3d d = sight_direction(i);
    const double across = d.z * ab.x - d.x * ab.z;
    if (across == 0) continue;
    const double t = (a.x * ab.z - a.z * ab.x) / -across;
    if (t > 0) sights.distance[at(i)] = std::min(sights.distance[at(i)], t);
  }
}

}  // namespace

void measure_sights(const Scene& scene, std::vector<EyePlace>& places) {
  std::vector<Sights*> by_height;
  for (EyePlace& place : places) {
    for (Sights* sights : {&place.eye, &place.below}) {
      sights->distance.fill(kInfinity);
      by_height.push_back(sights);
    }
  }
  std::sort(by_height.begin(), by_height.end(),
            [](const Sights* a, const Sights* b) { return a->from.y < b->from.y; });
  for (const Instance& instance : scene.instances) {
    if (instance.kind != ObjectKind::kMesh) continue;
    const Mesh& mesh = *scene.meshes[instance.mesh];
    for (const auto& corners : mesh.triangles) {
      std::array<Vec3d, 3> triangle;
      for (std::size_t i = 0; i < 3; ++i)
        triangle[i] = widened(instance.object_to_world.point(mesh.positions[corners[i]]));
      const auto [low, high] = std::minmax({triangle[0].y, triangle[1].y, triangle[2].y});
      auto next = std::lower_bound(by_height.begin(), by_height.end(), low,
                                   [](const Sights* a, double y) { return a->from.y < y; });
      for (; next != by_height.end() && (*next)->from.y <= high; ++next) {
        if (const Cut cut(triangle, (*next)->from); cut.is_any) see(cut, **next);
      }
    }
  }
}

Camera inside_camera(std::span<const EyePlace> places, double vfov_degrees, double aspect) {
  const double half_width =
      std::atan(aspect * std::tan(vfov_degrees * std::numbers::pi / 360)) / kAngleStep;
  const int sights_to_a_side = static_cast<int>(half_width);
  double clearance_max = 0;
  for (const EyePlace& place : places) clearance_max = std::max(clearance_max, clearance(place));
  const EyePlace* best = &places.front();
  int best_direction = 0;
  double best_volume = -1;
  for (const EyePlace& place : places) {
    if (clearance(place) < std::min(0.25 * place.above_floor, 0.5 * clearance_max)) continue;
    for (int direction = 0; direction < kSights; ++direction) {
      const double volume = (place.above_floor + place.below_ceiling) *
                            (area_seen(place.eye, direction, sights_to_a_side) +
                             area_seen(place.below, direction, sights_to_a_side));
      if (!(volume > best_volume)) continue;
      best_volume = volume;
      best = &place;
      best_direction = direction;
    }
  }
  const double distance =
      0.5 * std::min({clearance(*best), best->above_floor, best->below_ceiling});
  Camera camera;
  camera.eye = rounded(best->eye.from);
  camera.target = rounded(best->eye.from + distance * sight_direction(best_direction));
  camera.up = {0, 1, 0};
  camera.vfov_degrees = static_cast<float>(vfov_degrees);
  return camera;
}

}  // namespace tessera
