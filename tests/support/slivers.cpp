// SPDX-License-Identifier: Apache-2.0
#include "tests/support/slivers.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>

namespace tessera::test {
namespace {

// The next point of a rim.
Vec3f next_to(Choices& any, Vec3f p, const Slivers& slivers, bool is_on_grid) {
  if (!is_on_grid) return any.beside(p);
  const float unit = slivers.size * 0x1p-12f;
  const auto step = [&] { return unit * (static_cast<float>(any.below(5)) - 2); };
  return p + Vec3f{step(), step(), step()};
}

void add_triangle(Choices& any, Slivers& slivers, std::size_t k) {
  Vec3f corner[3] = {slivers.a, slivers.rim[k], slivers.rim[k + 1]};
  if (any.one_in(2)) std::swap(corner[1], corner[2]);
  const unsigned first = any.below(3);
  const auto number = static_cast<std::uint32_t>(slivers.mesh.positions.size());
  for (unsigned c = 0; c < 3; ++c) slivers.mesh.positions.push_back(corner[(first + c) % 3]);
  slivers.mesh.triangles.push_back({number, number + 1, number + 2});
}

// An origin: anywhere near, next to or in a corner, and in the plane of a triangle, exactly so on a
// grid, or next to that.
Vec3f make_origin(Choices& any, const Slivers& s) {
  const auto k = any.below(static_cast<unsigned>(s.rim.size()) - 1);
  const Vec3f b = s.rim[k], c = s.rim[k + 1];
  const auto whole = [&](int most) {
    return static_cast<float>(static_cast<int>(any.below(2u * static_cast<unsigned>(most) + 1)) -
                              most);
  };
  switch (any.below(8)) {
    case 0:
      return any.one_in(2) ? s.a : b;
    case 1:
      return any.beside(s.a + (b - s.a) * any.share());
    case 2:
      return s.a + (b - s.a) * whole(3) + (c - s.a) * whole(3);
    case 3:  // far along its plane, as rounded
      return s.a + (b - s.a) * (4 * any.share() - 2) + (c - b) * (any.sign() * any.power(0, 7));
    case 4:
      return any.beside(s.a + (b - s.a) * (4 * any.share() - 2) +
                        (c - b) * (any.sign() * any.power(0, 7)));
    case 5:
      return s.a + (b - s.a) * any.share() + (c - s.a) * (any.sign() * any.power(0, 6));
    default:
      return s.middle + any.point(2 * s.size);
  }
}

}  // namespace

Slivers make_slivers(Choices& any, unsigned triangle_count) {
  Slivers s;
  s.size = any.power(-6, 6);
  const bool is_on_grid = any.one_in(4);
  if (is_on_grid) s.size = std::exp2(std::round(std::log2(s.size)));
  if (any.one_in(2)) s.middle = any.point(s.size * any.power(0, 4));
  const auto placed = [&](Vec3f p) {
    if (!is_on_grid) return p;
    const float unit = s.size * 0x1p-8f;
    return Vec3f{std::round(p.x / unit) * unit, std::round(p.y / unit) * unit,
                 std::round(p.z / unit) * unit};
  };
  s.middle = placed(s.middle);
  s.a = placed(s.middle + any.point(s.size));
  s.rim = {any.one_in(2) ? placed(s.middle + any.point(s.size))
                         : s.a + any.point(s.size * any.power(-3, 0))};
  for (unsigned k = 0; k < triangle_count; ++k)
    s.rim.push_back(next_to(any, s.rim.back(), s, is_on_grid));
  if (any.one_in(4)) {  // all of it in a plane of the world's axes
    const unsigned axis = any.below(3);
    for (Vec3f& p : s.rim) (&p.x)[axis] = (&s.a.x)[axis];
  }
  for (unsigned k = 0; k < triangle_count; ++k) {
    add_triangle(any, s, k);
    if (triangle_count > 1 && any.one_in(3)) add_triangle(any, s, any.below(k + 1));
  }
  s.mesh.materials = {0};
  return s;
}

NeighbourRays make_rays(Choices& any, const Slivers& s) {
  NeighbourRays made;
  made.is_fan = any.one_in(2);
  const Vec3f origin = make_origin(any, s);
  const float share = any.share(), spread = any.one_in(4) ? 1 : any.power(-7, 0);
  const float apart = any.power(-8, -1);
  const float begins[] = {0, 0, 1e-4f, 0.5f, 1, std::nextafter(1.0f, 0.0f), 2};
  const float common_begin = begins[any.below(7)];
  for (core::SingleRay& ray : made.rays) {
    const auto k = any.below(static_cast<unsigned>(s.rim.size()) - 1);
    const Vec3f b = s.rim[k], c = s.rim[k + 1];
    const float along = std::clamp(share + spread * any.sign(), 0.0f, 1.0f);
    Vec3f target = any.one_in(8) ? s.a : any.one_in(4) ? b : s.a + (b - s.a) * along;
    if (any.one_in(2)) target = target + (c - b) * (along * any.share());
    if (any.one_in(8)) target = any.beside(target);
    Vec3f from = origin;
    if (!made.is_fan && any.one_in(2)) from = any.beside(origin);
    if (!made.is_fan && any.one_in(2)) from = from + any.point(s.size * apart);
    Vec3f direction = target - from;
    if (any.one_in(4)) direction = direction * (any.one_in(2) ? 0.5f + any.share() : 0.5f);
    ray = {{from.x, from.y, from.z}, {direction.x, direction.y, direction.z}, common_begin, 0};
    if (!made.is_fan && any.one_in(2)) ray.t_min = begins[any.below(7)];
    ray.t_max = any.one_in(8) ? std::max(ray.t_min, 1.0f) : std::numeric_limits<float>::infinity();
  }
  return made;
}

}  // namespace tessera::test
