// SPDX-License-Identifier: Apache-2.0
#include "tests/support/hard_cases.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <random>
#include <sstream>

#include "common/math/bounds3.h"
#include "tests/support/test_meshes.h"

namespace tessera::test {
namespace {

class Maker {
 public:
  Maker(std::size_t ray_count, std::uint32_t seed) : count_(ray_count), random_(seed) {}

  float unit() { return std::uniform_real_distribution<float>(-1, 1)(random_); }
  Vec3f vector() { return {unit(), unit(), unit()}; }
  bool one_in(unsigned n) { return random_() % n == 0; }
  std::size_t pick(std::size_t n) { return random_() % n; }

  Vec3f corner(const Mesh& mesh) { return mesh.positions[pick(mesh.positions.size())]; }
  // A point on an edge, often exactly a corner or the middle.
  Vec3f on_edge(const Mesh& mesh) {
    const auto& t = mesh.triangles[pick(mesh.triangles.size())];
    const std::size_t k = pick(3);
    const Vec3f a = mesh.positions[t[k]], b = mesh.positions[t[(k + 1) % 3]];
    if (one_in(4)) return a;
    return a + (b - a) * (one_in(3) ? 0.5f : (unit() + 1) / 2);
  }
  Vec3f within(const Mesh& mesh) {
    const auto& t = mesh.triangles[pick(mesh.triangles.size())];
    const Vec3f a = mesh.positions[t[0]];
    const float u = (unit() + 1) / 2, v = (1 - u) * (unit() + 1) / 2;
    return a + (mesh.positions[t[1]] - a) * u + (mesh.positions[t[2]] - a) * v;
  }

  // Rays in runs of 64 that start at one point, at points next to each other, or anywhere.
  std::vector<Ray> rays(const std::function<Vec3f()>& origin, float size,
                        const std::function<Vec3f()>& target) {
    std::vector<Ray> rays;
    Vec3f base;
    for (std::size_t i = 0; i < count_; ++i) {
      if (i % 64 == 0) base = origin();
      const std::size_t kind = i / 64 % 3;
      const Vec3f from = kind == 0 ? base : kind == 1 ? base + vector() * (0.01f * size) : origin();
      rays.push_back({from, target() - from, 0, Bounds3f::kInf});
    }
    return rays;
  }

 private:
  std::size_t count_;
  std::mt19937 random_;
};

struct Place {
  float scale = 1;
  Vec3f offset{};
};

HardCase closed(Maker& m, Mesh mesh, Vec3f inside, float radius, const Place& place) {
  test::place(mesh, place.scale, place.offset);
  HardCase hard;
  hard.is_closed = true;
  const Vec3f centre = inside * place.scale + place.offset;
  hard.rays = m.rays([&] { return centre + m.vector() * (radius * place.scale); },
                     place.scale * radius, [&] { return m.on_edge(mesh); });
  hard.mesh = std::move(mesh);
  return hard;
}

HardCase outside(Maker& m, Mesh mesh, const Place& place) {
  test::place(mesh, place.scale, place.offset);
  HardCase hard;
  hard.rays = m.rays([&] { return m.vector() * (3 * place.scale) + place.offset; }, place.scale,
                     [&] { return m.one_in(3) ? m.on_edge(mesh) : m.within(mesh); });
  hard.mesh = std::move(mesh);
  return hard;
}

HardCase edge_on(Maker& m) {
  HardCase hard = outside(m, make_terrain(14, 3), {});
  for (Ray& ray : hard.rays) {  // along the plane of a triangle, or nearly
    const auto& t = hard.mesh.triangles[m.pick(hard.mesh.triangles.size())];
    const Vec3f a = hard.mesh.positions[t[0]], b = hard.mesh.positions[t[1]],
                c = hard.mesh.positions[t[2]];
    const Vec3f inside = (a + b + c) * (1 / 3.0f);
    const Vec3f along = (b - a) * m.unit() + (c - a) * m.unit();
    ray.origin = inside - along * 2 + m.vector() * (m.one_in(2) ? 0 : 1e-6f);
    ray.direction = inside - ray.origin;
    if (!(length(ray.direction) > 0)) ray.direction = {0, 1, 0};
  }
  return hard;
}

HardCase slivers(Maker& m, float share) {
  Mesh mesh = make_random_triangles(400, 0.5f, 5);
  for (auto& [a, b, c] : mesh.triangles)
    mesh.positions[c] = mesh.positions[b] + (mesh.positions[c] - mesh.positions[b]) * share;
  return outside(m, std::move(mesh), {});
}

// Directions are very long or very short: bounds that hold for length 1 have to be scaled.
HardCase long_and_short(Maker& m) {
  HardCase hard = slivers(m, 1e-7f);
  for (std::size_t i = 0; i < hard.rays.size(); ++i)
    hard.rays[i].direction = hard.rays[i].direction * (i / 64 % 2 == 0 ? 1e6f : 1e-6f);
  return hard;
}

HardCase mixed_scales(Maker& m) {
  Mesh mesh = make_random_triangles(300, 0.3f, 6);
  for (std::size_t t = 0; t < mesh.triangles.size(); t += 3) {
    const float scale = t % 2 == 0 ? 1e-4f : 1e4f;
    const Vec3f a = mesh.positions[mesh.triangles[t][0]];
    for (std::size_t k = 1; k < 3; ++k) {
      Vec3f& p = mesh.positions[mesh.triangles[t][k]];
      p = a + (p - a) * scale;
    }
  }
  return outside(m, std::move(mesh), {});
}

// Everything on a grid: rays in faces, edges and split planes, with zeros of both signs and
// denormals.
HardCase axis_parallel(Maker& m) {
  Mesh mesh = make_random_triangles(300, 0.8f, 7);
  const auto on_grid = [](float x) { return std::round(x * 8) / 8; };
  for (Vec3f& p : mesh.positions) p = {on_grid(p.x), on_grid(p.y), on_grid(p.z)};
  HardCase hard = outside(m, std::move(mesh), {});
  static constexpr float kSmall[] = {0.0f, -0.0f, 1e-45f, -1e-40f, 1e-38f, -1e-30f};
  for (Ray& ray : hard.rays) {
    float o[3], d[3];
    for (int a = 0; a < 3; ++a) {
      o[a] = on_grid(ray.origin[a] / 3);
      d[a] = kSmall[m.pick(6)];
    }
    d[m.pick(3)] = m.one_in(2) ? 1.0f : -1.0f;
    if (m.one_in(3)) d[m.pick(3)] = m.unit();
    ray.origin = {o[0], o[1], o[2]};
    ray.direction = {d[0], d[1], d[2]};
    if (ray.direction == Vec3f{}) ray.direction.x = 1;
  }
  return hard;
}

HardCase planar(Maker& m) {
  Mesh mesh = make_random_triangles(300, 0.5f, 8);
  for (Vec3f& p : mesh.positions) p.y = 0.25f;
  const auto once = mesh.triangles;  // duplicates in one plane
  mesh.triangles.insert(mesh.triangles.end(), once.begin(), once.end());
  mesh.triangles.push_back({0, 0, 1});  // and some without area
  mesh.triangles.push_back({2, 2, 2});
  return outside(m, std::move(mesh), {});
}

HardCase range_ends(Maker& m) {
  HardCase hard = outside(m, make_random_triangles(300, 0.5f, 9), {});
  for (Ray& ray : hard.rays) {
    ray.t_min = m.one_in(2) ? 0 : m.one_in(2) ? 1 : std::fabs(m.unit());
    ray.t_max = ray.t_min + (m.one_in(4) ? 0 : 2 * std::fabs(m.unit()));
  }
  return hard;
}

HardCase silhouettes(Maker& m) {
  HardCase hard = outside(m, make_icosphere(2), {});
  for (Ray& ray : hard.rays) {  // just past corners that are seen against the sky
    const Vec3f target = m.corner(hard.mesh);
    ray.origin = target + cross(target, m.vector());
    ray.direction = (target - ray.origin) * (1 + m.unit()) + m.vector() * 1e-6f;
    if (!(length(ray.direction) > 0)) ray.direction = {1, 0, 0};
  }
  return hard;
}

HardCase invalid(Maker& m) {
  HardCase hard = outside(m, make_icosphere(2), {});
  const float nan = std::numeric_limits<float>::quiet_NaN(), inf = Bounds3f::kInf;
  for (Ray& ray : hard.rays) {
    if (m.one_in(2)) continue;
    switch (m.pick(6)) {
      case 0:
        ray.origin.x = m.one_in(2) ? nan : inf;
        break;
      case 1:
        ray.direction.y = m.one_in(2) ? nan : -inf;
        break;
      case 2:
        ray.direction = {0, -0.0f, 0};
        break;
      case 3:
        ray.t_min = nan;
        break;
      case 4:
        ray.t_max = nan;
        break;
      default:
        ray.t_max = -1;
        break;
    }
  }
  hard.has_invalid = true;
  return hard;
}

struct Named {
  const char* name;
  HardCase (*make)(Maker&);
};

const Named kCases[] = {
    {"closed, edges and corners",
     [](Maker& m) { return closed(m, make_icosphere(3), {}, 0.5f, {}); }},
    {"closed, cube", [](Maker& m) { return closed(m, make_cube(), {}, 0.8f, {}); }},
    {"closed, torus",
     [](Maker& m) {
       return closed(m, make_torus(40, 20), {1, 0, 0}, 0.2f, {});
     }},
    {"closed, 1e6 away",
     [](Maker& m) {
       return closed(m, make_icosphere(3), {}, 0.5f, {3e3f, {1e6f, 1e6f, -1e6f}});
     }},
    {"closed, unit a millionth",
     [](Maker& m) {
       return closed(m, make_icosphere(3), {}, 0.5f, {1e-6f, {}});
     }},
    {"closed, unit a million",
     [](Maker& m) {
       return closed(m, make_icosphere(3), {}, 0.5f, {1e6f, {}});
     }},
    {"closed, unit 10 to the -20",
     [](Maker& m) {
       return closed(m, make_icosphere(2), {}, 0.5f, {1e-20f, {}});
     }},
    {"closed, unit 10 to the 15",
     [](Maker& m) {
       return closed(m, make_icosphere(2), {}, 0.5f, {1e15f, {}});
     }},
    {"triangles, from outside",
     [](Maker& m) { return outside(m, make_random_triangles(500, 0.3f, 4), {}); }},
    {"edge-on", edge_on},
    {"slivers 1e3", [](Maker& m) { return slivers(m, 1e-3f); }},
    {"slivers 1e7", [](Maker& m) { return slivers(m, 1e-7f); }},
    {"slivers 1e7, long and short rays", long_and_short},
    {"very large and very small", mixed_scales},
    {"axis-parallel, on planes", axis_parallel},
    {"one plane, duplicates, degenerate", planar},
    {"ends of the range", range_ends},
    {"silhouettes", silhouettes},
    {"invalid rays", invalid},
};

bool is_valid(const Ray& ray) {
  return is_finite(ray.origin) && is_finite(ray.direction) && !(ray.direction == Vec3f{}) &&
         ray.t_min <= ray.t_max;
}

std::string text_of(const Ray& ray) {
  std::ostringstream out;
  out << std::hexfloat;
  for (const Vec3f v : {ray.origin, ray.direction}) out << v.x << " " << v.y << " " << v.z << " ";
  out << ray.t_min << " " << ray.t_max;
  return out.str();
}

// u and v where the ray's line meets the triangle's plane, in long double.
void reference_uv(const Ray& ray, const ReferenceTriangle& triangle, double& u, double& v) {
  using Real = long double;
  struct V {
    Real x, y, z;
  };
  const auto minus = [](Vec3f p, Vec3f q) {
    return V{Real{p.x} - q.x, Real{p.y} - q.y, Real{p.z} - q.z};
  };
  const auto cross3 = [](V p, V q) {
    return V{p.y * q.z - p.z * q.y, p.z * q.x - p.x * q.z, p.x * q.y - p.y * q.x};
  };
  const auto dot3 = [](V p, V q) { return p.x * q.x + p.y * q.y + p.z * q.z; };
  const V e1 = minus(triangle.b, triangle.a), e2 = minus(triangle.c, triangle.a),
          s = minus(ray.origin, triangle.a);
  const V d{ray.direction.x, ray.direction.y, ray.direction.z};
  const V p = cross3(d, e2);
  const Real volume = dot3(e1, p);
  u = static_cast<double>(dot3(s, p) / volume);
  v = static_cast<double>(dot3(d, cross3(s, e1)) / volume);
}

}  // namespace

std::vector<std::string> hard_case_names() {
  std::vector<std::string> names;
  for (const Named& named : kCases) names.push_back(named.name);
  return names;
}

HardCase make_hard_case(const std::string& name, std::size_t ray_count, std::uint32_t seed) {
  Maker maker(ray_count, seed);
  for (const Named& named : kCases) {
    if (named.name != name) continue;
    HardCase hard = named.make(maker);
    hard.name = name;
    return hard;
  }
  return {};
}

Verdicts judge_all(const HardCase& hard, const std::vector<Answer>& answers) {
  Verdicts sum;
  std::vector<ReferenceTriangle> triangles;
  for (const auto& t : hard.mesh.triangles)
    triangles.push_back(
        {hard.mesh.positions[t[0]], hard.mesh.positions[t[1]], hard.mesh.positions[t[2]]});
  for (std::size_t i = 0; i < hard.rays.size(); ++i) {
    const Ray& ray = hard.rays[i];
    const Answer& answer = answers[i];
    ++sum.rays;
    if (!is_valid(ray)) {
      sum.invalid += answer.is_hit ? 1u : 0u;
      continue;
    }
    if (hard.is_closed && !answer.is_hit) ++sum.leaks;
    double nearest_sure = std::numeric_limits<double>::infinity();
    for (const ReferenceTriangle& triangle : triangles) {
      const ReferenceAnswer reference = reference_hit(ray, triangle);
      if (reference.verdict == Verdict::kHit)
        nearest_sure = std::min(nearest_sure, reference.t + reference.t_error);
    }
    if (!answer.is_hit) {
      sum.missed += std::isfinite(nearest_sure) ? 1u : 0u;
      continue;
    }
    if (answer.primitive >= triangles.size() || !(answer.t >= ray.t_min && answer.t <= ray.t_max)) {
      ++sum.invalid;
      continue;
    }
    const ReferenceTriangle& own = triangles[answer.primitive];
    const ReferenceAnswer reference = reference_hit(ray, own);
    if (reference.verdict == Verdict::kMiss) ++sum.false_hits;
    if (reference.t - reference.t_error > nearest_sure) ++sum.wrong;
    if (reference.verdict != Verdict::kHit || !(reference.t_error > 0)) continue;
    const double error = std::fabs(static_cast<double>(answer.t) - reference.t);
    const double normed = 16 * error / reference.t_error;  // t_error is 16 u s / (|D| cos)
    sum.t_relative.push_back(reference.t != 0 ? error / std::fabs(reference.t) : error);
    sum.t_normed.push_back(normed);
    double u = 0, v = 0;
    reference_uv(ray, own, u, v);
    sum.uv.push_back(std::max(std::fabs(u - static_cast<double>(answer.u)),
                              std::fabs(v - static_cast<double>(answer.v))));
    if (normed > sum.worst) {
      sum.worst = normed;
      sum.worst_ray = text_of(ray);
    }
  }
  return sum;
}

}  // namespace tessera::test
