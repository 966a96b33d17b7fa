// SPDX-License-Identifier: Apache-2.0
#include "tests/support/closed_solid.h"

#include <cmath>
#include <utility>

#include "common/math/bounds3.h"
#include "slave/core/simd/isa_support.h"

namespace tessera::test {
namespace {

constexpr std::size_t kDoubtsMax = 100;  // each of them builds a scene
constexpr int kPassesMax = 64;           // of one ray, which may run along an edge
constexpr std::size_t kLeakedMax = 4;    // that are kept

std::shared_ptr<const core::PreparedScene> prepared(PatchSurface surface) {
  Scene scene;
  scene.materials.resize(1);
  surface.materials = {0};
  scene.surfaces = {std::make_shared<const PatchSurface>(std::move(surface))};
  scene.instances = {{0, {}, ObjectKind::kPatchSurface}};
  return core::PreparedScene::build(scene, {}).value();
}

std::vector<core::CastHit> cast(const core::PreparedScene& scene,
                                const std::vector<core::CastRay>& rays) {
  core::CastOptions options;
  options.isa = widest_isa(core::cpu_isas());
  std::vector<core::CastHit> hits(rays.size());
  cast_rays(scene, rays, options, hits);
  return hits;
}

Vec3d direction(Choices& choices) {
  while (true) {
    const Vec3d d{double{choices.sign()}, double{choices.sign()}, double{choices.sign()}};
    const double square = dot(d, d);
    if (square > 0.01 && square <= 1) return (1 / std::sqrt(square)) * d;
  }
}

bool leaves(const core::CastRay& ray, const core::CastHit& hit) {
  return hit.is_hit && dot(ray.direction, hit.normal) > 0;
}

}  // namespace

ClosedSolid::ClosedSolid(const PatchSurface& surface, double size, double reach)
    : surface_(surface), size_(size), reach_(reach) {
  solid_ = prepared(surface);
  PatchSurface without = surface;
  without.trim_widths.clear();
  without_widths_ = prepared(std::move(without));
}

// Ends at t = 1 at a place between those of the two faces, or a bit beside them.
core::CastRay ClosedSolid::ray_at(const EdgePlace& place, Choices& choices) const {
  Vec3d d = direction(choices);
  while (!(dot(d, place.normal[0]) > 0 || dot(d, place.normal[1]) > 0)) d = direction(choices);
  const double share = 1.4 * double{choices.share()} - 0.2;
  const Vec3d at = place.on[0] + share * (place.on[1] - place.on[0]);
  // Rays that begin within a border's reach do not meet it.
  const double away = reach_ + size_ * double{choices.power(-3, -0.5f)};
  const Vec3f origin = rounded(at - away * d);
  return {origin, rounded(at - widened(origin)), 0, Bounds3f::kInf};
}

LeakCounts ClosedSolid::cast(const std::function<EdgePlace()>& place, std::size_t count,
                             Choices& choices) const {
  constexpr std::size_t kBatch = 4096;
  LeakCounts counts;
  for (int round = 0; round < 1000 && counts.rays < count; ++round) {
    std::vector<core::CastRay> rays;
    for (std::size_t i = 0; i < kBatch; ++i) rays.push_back(ray_at(place(), choices));
    rays = inside(rays, choices);
    counts.outside += kBatch - rays.size();
    counts.rays += rays.size();
    cast_all(rays, counts);
  }
  return counts;
}

std::vector<core::CastRay> ClosedSolid::inside(const std::vector<core::CastRay>& rays,
                                               Choices& choices) const {
  constexpr std::size_t kProbes = 6;  // three lines, both ways
  std::vector<core::CastRay> probes;
  for (const core::CastRay& ray : rays)
    for (std::size_t k = 0; k < kProbes; k += 2) {
      const Vec3f d = rounded(direction(choices));
      probes.push_back({ray.origin, d, 0, Bounds3f::kInf});
      probes.push_back({ray.origin, -d, 0, Bounds3f::kInf});
    }
  const std::vector<core::CastHit> hits = test::cast(*solid_, probes);
  std::vector<core::CastRay> those;
  for (std::size_t i = 0; i < rays.size(); ++i) {
    bool is_inside = true;
    for (std::size_t k = kProbes * i; k < kProbes * (i + 1); ++k)
      is_inside = is_inside && leaves(probes[k], hits[k]);
    if (is_inside) those.push_back(rays[i]);
  }
  return those;
}

// Of two faces at one place, of which one is met, the other one is asked for without it.
bool ClosedSolid::is_on_another(const core::CastRay& ray, const core::CastHit& hit) const {
  PatchSurface without = surface_;
  for (PatchCursor at(surface_); at.is_any(); at.advance()) {
    if (at.patch() != hit.primitive) continue;
    const std::size_t width = at.form().is_rational != 0 ? 4 : 3;
    for (std::size_t i = 0; i < at.form().point_count(); ++i)
      without.numbers[at.first_number() + width * i] += static_cast<float>(100 * size_);
  }
  const core::CastHit other = test::cast(*prepared(std::move(without)), {ray})[0];
  return leaves(ray, other) && std::fabs(other.t - hit.t) <= 0x1p-20f * hit.t;
}

void ClosedSolid::cast_all(const std::vector<core::CastRay>& rays, LeakCounts& counts) const {
  std::vector<Walk> walks;
  for (const core::CastRay& ray : rays) walks.push_back({ray});
  const auto leak = [&](const Walk& walk) {
    if (walk.has_met_border) {
      ++counts.held;
      return;
    }
    ++counts.leaks;
    if (counts.leaked.size() < kLeakedMax) counts.leaked.push_back(walk.ray);
  };
  for (int pass = 0; pass < kPassesMax && !walks.empty(); ++pass) {
    std::vector<core::CastRay> at;
    for (const Walk& walk : walks) at.push_back(walk.ray);
    const std::vector<core::CastHit> hits = test::cast(*solid_, at);
    const std::vector<core::CastHit> plain = test::cast(*without_widths_, at);
    std::vector<Walk> further;
    for (std::size_t i = 0; i < walks.size(); ++i) {
      if (leaves(at[i], hits[i])) continue;
      const bool is_beyond_loop = hits[i].is_hit && !(plain[i].is_hit && plain[i].t <= hits[i].t);
      const double from_edge = std::fabs(double{hits[i].t} - 1) * length(widened(at[i].direction));
      bool is_passed = is_beyond_loop || (hits[i].is_hit && from_edge <= reach_);
      if (!is_passed && hits[i].is_hit && counts.doubted < kDoubtsMax) {
        ++counts.doubted;
        is_passed = is_on_another(at[i], hits[i]);
      }
      if (!is_passed) {
        leak(walks[i]);
        continue;
      }
      ++counts.passed;
      walks[i].has_met_border = walks[i].has_met_border || is_beyond_loop;
      walks[i].ray.t_min = std::nextafter(hits[i].t, Bounds3f::kInf);
      further.push_back(walks[i]);
    }
    walks = std::move(further);
  }
  for (const Walk& walk : walks) leak(walk);
}

}  // namespace tessera::test
