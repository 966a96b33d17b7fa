// SPDX-License-Identifier: Apache-2.0
#include "master/import/gltf/tangent_space.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <map>
#include <unordered_map>

namespace tessera::import {
namespace {

using Corner = std::size_t;  // 3 * triangle + 0..2
constexpr std::uint32_t kNone = 0xffffffffu;

// The bits of a number; -0 has those of 0.
std::uint32_t bits(float x) {
  const float plain = x == 0 ? 0.0f : x;
  std::uint32_t value = 0;
  std::memcpy(&value, &plain, sizeof(value));
  return value;
}

using VertexKey = std::array<std::uint32_t, 8>;
struct HashOfKey {
  std::size_t operator()(const VertexKey& key) const {
    std::uint64_t hash = 0x9e3779b97f4a7c15u;
    for (const std::uint32_t word : key)
      hash = (hash ^ word) * 0xff51afd7ed558ccdu, hash ^= hash >> 32;
    return static_cast<std::size_t>(hash);
  }
};

Vec3f unit_or_zero(Vec3f v) {
  const float l = length(v);
  return l > 0 && std::isfinite(l) ? v * (1 / l) : Vec3f{};
}
Vec3f on_plane(Vec3f v, Vec3f normal) { return v - dot(normal, v) * normal; }

class TangentMaker {
 public:
  TangentMaker(Mesh& mesh, const std::vector<Vec2f>& uvs)
      : mesh_(mesh), uvs_(uvs), corner_count_(3 * mesh.triangles.size()) {}

  void run() {
    weld();
    measure_triangles();
    find_neighbours();
    form_groups();
    sum_groups();
    write();
  }

 private:
  struct Triangle {
    Vec3f along_u;               // unit, or zero
    bool turns_left = false;     // its coordinates go counter-clockwise
    bool fits_any = false;       // no area in the picture: it may turn either way
    bool is_degenerate = false;  // two corners have the same position
  };
  struct Group {
    bool turns_left = false;
    Vec3f sum;
  };

  std::uint32_t vertex_of(Corner c) const { return mesh_.triangles[c / 3][c % 3]; }
  Vec3f position(Corner c) const { return mesh_.positions[vertex_of(c)]; }
  static Corner next(Corner c) { return c % 3 == 2 ? c - 2 : c + 1; }

  void weld() {
    std::unordered_map<VertexKey, std::uint32_t, HashOfKey> known;
    std::vector<std::uint32_t> welded(mesh_.positions.size());
    for (std::size_t v = 0; v < welded.size(); ++v) {
      const Vec3f p = mesh_.positions[v], n = mesh_.normals[v];
      const VertexKey key{bits(p.x), bits(p.y), bits(p.z),       bits(n.x),
                          bits(n.y), bits(n.z), bits(uvs_[v].x), bits(uvs_[v].y)};
      welded[v] = known.try_emplace(key, static_cast<std::uint32_t>(v)).first->second;
    }
    welded_.resize(corner_count_);
    for (Corner c = 0; c < corner_count_; ++c) welded_[c] = welded[vertex_of(c)];
  }

  // Chapter 4.1: the direction of the derivative of the position by u.
  void measure_triangles() {
    triangles_.resize(mesh_.triangles.size());
    for (std::size_t t = 0; t < triangles_.size(); ++t) {
      const auto& [a, b, c] = mesh_.triangles[t];
      const Vec3f edge1 = mesh_.positions[b] - mesh_.positions[a];
      const Vec3f edge2 = mesh_.positions[c] - mesh_.positions[a];
      const float u1 = uvs_[b].x - uvs_[a].x, v1 = uvs_[b].y - uvs_[a].y;
      const float u2 = uvs_[c].x - uvs_[a].x, v2 = uvs_[c].y - uvs_[a].y;
      const float area = u1 * v2 - v1 * u2;
      Triangle& triangle = triangles_[t];
      triangle.turns_left = area > 0;
      triangle.along_u = unit_or_zero(v2 * edge1 - v1 * edge2) * (area > 0 ? 1.0f : -1.0f);
      triangle.fits_any = !(std::fabs(area) > 0) || triangle.along_u == Vec3f{};
      const std::uint32_t i = welded_[3 * t], j = welded_[3 * t + 1], k = welded_[3 * t + 2];
      triangle.is_degenerate = mesh_.positions[i] == mesh_.positions[j] ||
                               mesh_.positions[j] == mesh_.positions[k] ||
                               mesh_.positions[k] == mesh_.positions[i];
    }
  }

  // Finds the triangle beyond each edge: one that has the edge the other way round. Each edge of a
  // triangle has one neighbour at most.
  void find_neighbours() {
    struct Edge {
      std::uint32_t low, high;
      Corner corner;  // where the edge begins
    };
    std::vector<Edge> edges;
    for (Corner c = 0; c < corner_count_; ++c) {
      if (triangles_[c / 3].is_degenerate) continue;
      edges.push_back(
          {std::min(welded_[c], welded_[next(c)]), std::max(welded_[c], welded_[next(c)]), c});
    }
    std::sort(edges.begin(), edges.end(), [](const Edge& a, const Edge& b) {
      return std::tie(a.low, a.high, a.corner) < std::tie(b.low, b.high, b.corner);
    });
    beyond_.assign(corner_count_, kNone);
    for (std::size_t i = 0; i < edges.size(); ++i) {
      if (beyond_[edges[i].corner] != kNone) continue;
      // Where thousands of triangles share an edge the search ends after some of them.
      constexpr std::size_t kSearchedMax = 64;
      for (std::size_t j = i + 1; j < std::min(edges.size(), i + kSearchedMax); ++j) {
        if (edges[j].low != edges[i].low || edges[j].high != edges[i].high) break;
        const bool is_other_way = welded_[edges[j].corner] != welded_[edges[i].corner];
        if (!is_other_way || beyond_[edges[j].corner] != kNone) continue;
        beyond_[edges[i].corner] = static_cast<std::uint32_t>(edges[j].corner);
        beyond_[edges[j].corner] = static_cast<std::uint32_t>(edges[i].corner);
        break;
      }
    }
  }

  void form_groups() {
    group_.assign(corner_count_, kNone);
    for (Corner c = 0; c < corner_count_; ++c) {
      const Triangle& triangle = triangles_[c / 3];
      if (triangle.fits_any || triangle.is_degenerate || group_[c] != kNone) continue;
      groups_.push_back({triangle.turns_left, {}});
      spread(c);
    }
  }

  // Goes round the vertex from `start`, over edges, as far as triangles turn the same way.
  void spread(Corner start) {
    const auto group = static_cast<std::uint32_t>(groups_.size() - 1);
    std::vector<Corner> open{start};
    while (!open.empty()) {
      const Corner c = open.back();
      open.pop_back();
      Triangle& triangle = triangles_[c / 3];
      if (group_[c] != kNone) continue;
      const Corner first = c / 3 * 3;
      const bool is_free =
          group_[first] == kNone && group_[first + 1] == kNone && group_[first + 2] == kNone;
      if (triangle.fits_any && is_free) triangle.turns_left = groups_[group].turns_left;
      if (triangle.turns_left != groups_[group].turns_left) continue;
      group_[c] = group;
      // Two edges meet here: the one that begins at c, and the one that ends at c.
      if (const std::uint32_t e = beyond_[c]; e != kNone) open.push_back(next(e));
      if (const std::uint32_t e = beyond_[next(next(c))]; e != kNone) open.push_back(e);
    }
  }

  // Chapter 4.2: the mean of the triangles' tangents, weighted by angles in the normal's plane.
  void sum_groups() {
    for (Corner c = 0; c < corner_count_; ++c) {
      const Triangle& triangle = triangles_[c / 3];
      if (group_[c] == kNone || triangle.fits_any) continue;
      const Vec3f normal = normalize(mesh_.normals[vertex_of(c)]);
      const Vec3f along = unit_or_zero(on_plane(triangle.along_u, normal));
      const Vec3f to1 = unit_or_zero(on_plane(position(next(c)) - position(c), normal));
      const Vec3f to2 = unit_or_zero(on_plane(position(next(next(c))) - position(c), normal));
      const float angle = std::acos(std::clamp(dot(to1, to2), -1.0f, 1.0f));
      groups_[group_[c]].sum = groups_[group_[c]].sum + angle * along;
    }
  }

  Vec4f tangent_of(Corner c) const {
    const Vec3f normal = normalize(mesh_.normals[vertex_of(c)]);
    Vec3f along;
    bool turns_left = true;
    if (group_[c] != kNone) {
      along = unit_or_zero(groups_[group_[c]].sum);
      turns_left = groups_[group_[c]].turns_left;
    }
    if (along == Vec3f{}) along = any_across(normal);
    return {along.x, along.y, along.z, turns_left ? 1.0f : -1.0f};
  }
  static Vec3f any_across(Vec3f normal) {
    const Vec3f across = std::fabs(normal.x) < 0.9f ? Vec3f{1, 0, 0} : Vec3f{0, 1, 0};
    const Vec3f along = unit_or_zero(on_plane(across, normal));
    return along == Vec3f{} ? Vec3f{1, 0, 0} : along;
  }

  // A corner without a group takes the tangent of another corner of its vertex, if there is one.
  void write() {
    mesh_.tangents.assign(mesh_.positions.size(), Vec4f{});
    std::vector<bool> has(mesh_.positions.size(), false);
    std::map<std::pair<std::uint32_t, std::uint32_t>, std::uint32_t> copies;  // vertex, group
    std::vector<std::uint32_t> first_group(mesh_.positions.size(), kNone);
    for (const bool is_grouped : {true, false}) {
      for (Corner c = 0; c < corner_count_; ++c) {
        if ((group_[c] != kNone) != is_grouped) continue;
        std::uint32_t& vertex = mesh_.triangles[c / 3][c % 3];
        if (!has[vertex]) {
          mesh_.tangents[vertex] = tangent_of(c);
          first_group[vertex] = group_[c];
          has[vertex] = true;
        } else if (is_grouped && first_group[vertex] != group_[c]) {
          const auto [copy, is_new] = copies.try_emplace(
              {vertex, group_[c]}, static_cast<std::uint32_t>(mesh_.positions.size()));
          if (is_new) copy_vertex(vertex, tangent_of(c));
          vertex = copy->second;
        }
      }
    }
    for (std::size_t v = 0; v < has.size(); ++v) {
      if (!has[v]) mesh_.tangents[v] = {1, 0, 0, 1};  // no triangle uses it
    }
  }

  void copy_vertex(std::uint32_t vertex, const Vec4f& tangent) {
    const auto copy = [vertex](auto& values) {
      if (values.empty()) return;
      const auto value = values[vertex];
      values.push_back(value);
    };
    copy(mesh_.positions);
    copy(mesh_.normals);
    copy(mesh_.uvs);
    copy(mesh_.uvs1);
    copy(mesh_.colors);
    mesh_.tangents.push_back(tangent);
  }

  Mesh& mesh_;
  const std::vector<Vec2f>& uvs_;
  const std::size_t corner_count_;
  std::vector<std::uint32_t> welded_;  // [corner]: the first vertex that is equal to its own
  std::vector<Triangle> triangles_;
  std::vector<std::uint32_t> beyond_;  // [corner]: the corner where the edge from it begins again
  std::vector<std::uint32_t> group_;   // [corner]
  std::vector<Group> groups_;
};

}  // namespace

void make_tangents(Mesh& mesh, const std::vector<Vec2f>& uvs) { TangentMaker(mesh, uvs).run(); }

}  // namespace tessera::import
