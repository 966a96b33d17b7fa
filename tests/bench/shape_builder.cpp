// SPDX-License-Identifier: Apache-2.0
#include "tests/bench/shape_builder.h"

namespace tessera::bench {

void ShapeBuilder::set_frame(Vec3f origin, float yaw, float scale) {
  origin_ = origin;
  cosine_ = std::cos(yaw);
  sine_ = std::sin(yaw);
  scale_ = scale;
}

std::uint32_t ShapeBuilder::add_vertex(Vec3f q) {
  mesh_.positions.push_back({origin_.x + scale_ * (cosine_ * q.x - sine_ * q.y),
                             origin_.y + scale_ * (sine_ * q.x + cosine_ * q.y),
                             origin_.z + scale_ * q.z});
  return static_cast<std::uint32_t>(mesh_.positions.size() - 1);
}

void ShapeBuilder::add_triangle(std::uint32_t a, std::uint32_t b, std::uint32_t c) {
  mesh_.triangles.push_back({a, b, c});
}

void ShapeBuilder::add_triangle_with_area(std::uint32_t a, std::uint32_t b, std::uint32_t c) {
  const auto& p = mesh_.positions;
  const Vec3f n = cross(p[b] - p[a], p[c] - p[a]);
  if (dot(n, n) > 0) add_triangle(a, b, c);
}

void ShapeBuilder::add_surface(int nu, int nv, const Surface& surface) {
  const auto first = static_cast<std::uint32_t>(mesh_.positions.size());
  const auto share = [](int i, int n) { return static_cast<float>(i) / static_cast<float>(n); };
  for (int j = 0; j <= nv; ++j) {
    for (int i = 0; i <= nu; ++i) add_vertex(surface(share(i, nu), share(j, nv)));
  }
  const auto width = static_cast<std::uint32_t>(nu) + 1;
  for (std::uint32_t j = 0; j < static_cast<std::uint32_t>(nv); ++j) {
    for (std::uint32_t i = 0; i + 1 < width; ++i) {
      const std::uint32_t k = first + j * width + i, m = k + width;
      add_triangle_with_area(k, k + 1, m + 1);
      add_triangle_with_area(k, m + 1, m);
    }
  }
}

void ShapeBuilder::add_quad(Vec3f corner, Vec3f a, Vec3f b) {
  add_surface(1, 1, [&](float u, float v) { return corner + a * u + b * v; });
}

void ShapeBuilder::add_box(Vec3f low, Vec3f high) {
  std::uint32_t corner[8];
  for (unsigned i = 0; i < 8; ++i) {
    corner[i] = add_vertex({(i & 1u) != 0 ? high.x : low.x, (i & 2u) != 0 ? high.y : low.y,
                            (i & 4u) != 0 ? high.z : low.z});
  }
  static constexpr int kFaces[6][4] = {{0, 2, 3, 1}, {4, 5, 7, 6}, {0, 1, 5, 4},
                                       {2, 6, 7, 3}, {0, 4, 6, 2}, {1, 3, 7, 5}};
  for (const auto& f : kFaces) {
    add_triangle(corner[f[0]], corner[f[1]], corner[f[2]]);
    add_triangle(corner[f[0]], corner[f[2]], corner[f[3]]);
  }
}

void ShapeBuilder::add_tube(const Curve& curve, float radius, int segments, int sides) {
  constexpr float kStep = 1e-3f;
  const auto unit = [](Vec3f a) { return a * (1.0f / std::sqrt(dot(a, a))); };
  add_surface(sides, segments, [&](float u, float v) {
    const float at = v < 0.5f ? v : v - kStep;
    const Vec3f along = unit(curve(at + kStep) - curve(at));
    const Vec3f aside = std::fabs(along.z) < 0.9f ? Vec3f{0, 0, 1} : Vec3f{1, 0, 0};
    const Vec3f n = unit(cross(along, aside)), b = cross(n, along);
    return curve(v) + n * (radius * std::cos(2 * kPi * u)) + b * (radius * std::sin(2 * kPi * u));
  });
}

void ShapeBuilder::add_rod(Vec3f from, Vec3f to, float radius, int segments, int sides) {
  add_tube([&](float s) { return from + (to - from) * s; }, radius, segments, sides);
}

void ShapeBuilder::add_superellipsoid(Vec3f centre, Vec3f radii, float e1, float e2, int nu,
                                      int nv) {
  const auto power = [](float w, float e) { return w < 0 ? -std::pow(-w, e) : std::pow(w, e); };
  add_surface(nu, nv, [&](float u, float v) {
    const float theta = 2 * kPi * u, phi = kPi * (v - 0.5f), ring = power(std::cos(phi), e1);
    return centre + Vec3f{radii.x * ring * power(std::cos(theta), e2),
                          radii.y * ring * power(std::sin(theta), e2),
                          radii.z * power(std::sin(phi), e1)};
  });
}

}  // namespace tessera::bench
