// SPDX-License-Identifier: Apache-2.0
#include "master/loader/mesh_maker.h"

#include <cmath>

namespace tessera::master {
namespace {
constexpr float kTau = 6.2831853f;
// A quad is bent where the normals of its halves differ by more than this. Rounding of corners and
// products is some 2^-20 for the flattest of our boxes, and a twentieth of a degree is not seen.
constexpr float kBent = 0x1p-10f;
}  // namespace

std::uint32_t MeshMaker::vertex(Vec3f position, Vec3f normal, Vec2f uv) {
  mesh_.positions.push_back(position);
  mesh_.normals.push_back(normalize(normal));
  mesh_.uvs.push_back(uv);
  return static_cast<std::uint32_t>(mesh_.positions.size() - 1);
}

void MeshMaker::face(std::uint32_t a, std::uint32_t b, std::uint32_t c, std::uint32_t material) {
  mesh_.triangles.push_back({a, b, c});
  mesh_.materials.push_back(material);
}

void MeshMaker::triangle(Vec3f a, Vec3f b, Vec3f c, std::uint32_t material) {
  const Vec3f n = cross(b - a, c - a);
  const std::uint32_t first = vertex(a, n, {0, 0});
  vertex(b, n, {1, 0});
  vertex(c, n, {1, 1});
  face(first, first + 1, first + 2, material);
}

void MeshMaker::quad(Vec3f a, Vec3f b, Vec3f c, Vec3f d, std::uint32_t material) {
  const Vec3f n = normalize(cross(b - a, c - a)), m = normalize(cross(c - a, d - a));
  const std::uint32_t first = vertex(a, n, {0, 0});
  vertex(b, n, {1, 0});
  vertex(c, n, {1, 1});
  face(first, first + 1, first + 2, material);
  if (!(length(m - n) > kBent)) {
    vertex(d, n, {0, 1});
    face(first, first + 2, first + 3, material);
  } else {  // bent: both halves are flat
    vertex(a, m, {0, 0});
    vertex(c, m, {1, 1});
    vertex(d, m, {0, 1});
    face(first + 3, first + 4, first + 5, material);
  }
}

void MeshMaker::box(Vec3f lower, Vec3f upper, std::uint32_t material, float angle) {
  const Vec3f centre = 0.5f * (lower + upper);
  const float c = std::cos(angle), s = std::sin(angle);
  Vec3f p[8];
  for (int i = 0; i < 8; ++i) {
    const Vec3f q{(i & 1) != 0 ? upper.x : lower.x, (i & 2) != 0 ? upper.y : lower.y,
                  (i & 4) != 0 ? upper.z : lower.z};
    const float x = q.x - centre.x, z = q.z - centre.z;
    p[i] = {centre.x + c * x + s * z, q.y, centre.z - s * x + c * z};
  }
  quad(p[0], p[4], p[6], p[2], material);  // -x
  quad(p[1], p[3], p[7], p[5], material);  // +x
  quad(p[0], p[1], p[5], p[4], material);  // -y
  quad(p[2], p[6], p[7], p[3], material);  // +y
  quad(p[0], p[2], p[3], p[1], material);  // -z
  quad(p[4], p[5], p[7], p[6], material);  // +z
}

void MeshMaker::lathe(Vec3f base, const std::vector<Vec2f>& profile, int segments,
                      std::uint32_t material) {
  const int rows = static_cast<int>(profile.size()) - 1;
  std::vector<Vec3f> points;
  for (const Vec2f& p : profile) {
    for (int i = 0; i <= segments; ++i) {
      const float a = -kTau * static_cast<float>(i % segments) / static_cast<float>(segments);
      points.push_back(base + Vec3f{p.x * std::cos(a), p.y, p.x * std::sin(a)});
    }
  }
  grid(rows, segments, points, material);
}

void MeshMaker::tube(const std::vector<Vec3f>& path, float radius, int sides,
                     std::uint32_t material) {
  std::vector<Vec3f> points;
  for (std::size_t i = 0; i < path.size(); ++i) {
    const Vec3f along = normalize(path[std::min(i + 1, path.size() - 1)] - path[i > 0 ? i - 1 : 0]);
    const Vec3f side =
        normalize(cross(along, std::abs(along.y) < 0.9f ? Vec3f{0, 1, 0} : Vec3f{1, 0, 0}));
    const Vec3f up = cross(side, along);
    for (int k = 0; k <= sides; ++k) {
      const float a = kTau * static_cast<float>(k % sides) / static_cast<float>(sides);
      points.push_back(path[i] + radius * (std::cos(a) * side + std::sin(a) * up));
    }
  }
  grid(static_cast<int>(path.size()) - 1, sides, points, material);
}

void MeshMaker::grid(int rows, int columns, const std::vector<Vec3f>& points,
                     std::uint32_t material, float uv_scale) {
  const int stride = columns + 1;
  const auto at = [&](int r, int c) { return points[static_cast<std::size_t>(r * stride + c)]; };
  const auto first = static_cast<std::uint32_t>(mesh_.positions.size());
  const bool is_closed = at(0, 0) == at(0, columns) && at(rows, 0) == at(rows, columns);
  for (int r = 0; r <= rows; ++r) {
    for (int c = 0; c <= columns; ++c) {
      const int left = c > 0 ? c - 1 : is_closed ? columns - 1 : 0;
      const int right = c < columns ? c + 1 : is_closed ? 1 : columns;
      const Vec3f across = at(r, right) - at(r, left);
      const Vec3f along = at(std::min(r + 1, rows), c) - at(std::max(r - 1, 0), c);
      vertex(at(r, c), cross(across, along),
             {uv_scale * static_cast<float>(c) / static_cast<float>(columns),
              uv_scale * static_cast<float>(r) / static_cast<float>(rows)});
    }
  }
  for (int r = 0; r < rows; ++r) {
    for (int c = 0; c < columns; ++c) {
      const auto a = first + static_cast<std::uint32_t>(r * stride + c);
      const auto d = a + static_cast<std::uint32_t>(stride);
      face(a, a + 1, d + 1, material);
      face(a, d + 1, d, material);
    }
  }
}

}  // namespace tessera::master
