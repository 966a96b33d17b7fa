// SPDX-License-Identifier: Apache-2.0
#include "slave/core/light/light_subpaths.h"

#include <algorithm>
#include <cmath>

#include "slave/core/light/light_sampling.h"
#include "slave/core/sampling/hemisphere.h"

namespace tessera::core {
namespace {

constexpr float kPi = 3.14159274f;

// Least t of rays that leave a delta light. What lies nearer cannot be told from the light itself,
// and is taken for its housing.
constexpr float kHousing = 4 * kUnitRoundoff;

double luminance(Vec3f c) { return 0.2126 * c.x + 0.7152 * c.y + 0.0722 * c.z; }

void put(float (&to)[3], Vec3f from) {
  for (int a = 0; a < 3; ++a) to[a] = from[a];
}

// Solid angle of a spot's outer cone.
float cone_of(const Light& light) { return 2 * kPi * (1 - light.cos_outer); }

LightPoint point_of(const Light& light) {
  LightPoint p{};
  p.kind = light.kind == LightKind::kPoint  ? LightPointKind::kPoint
           : light.kind == LightKind::kSpot ? LightPointKind::kSpot
                                            : LightPointKind::kFar;
  put(p.position, light.position);
  put(p.normal, light.direction);
  put(p.rgb, light.intensity);
  p.cos_inner = light.cos_inner;
  p.cos_outer = light.cos_outer;
  p.t_min = light.kind == LightKind::kDirectional ? 0 : kHousing;
  return p;
}

void scale(LightPoint& point, float by) {
  for (float& c : point.rgb) c *= by;
}

// A direction, uniform in the cone of cosines above 1 - height; height 2: all directions.
Vec3f in_cone(Vec3f axis, float height, Vec2f square) {
  const Vec2f disk = concentric_disk(square);
  const float r2 = disk.x * disk.x + disk.y * disk.y;
  const float z = 1 - height * r2;
  // sin^2 = 1 - z^2 = height r2 (2 - height r2)
  const float stretch = std::sqrt(std::fmax(0.0f, height * (2 - height * r2)));
  const Basis basis = basis_about(axis);
  return basis.tangent * (disk.x * stretch) + basis.bitangent * (disk.y * stretch) + axis * z;
}

}  // namespace

LightSubpaths::LightSubpaths(const LightSet& lights, const Bounds3f& bounds) : lights_(lights) {
  if (!bounds.is_empty()) {
    centre_ = (bounds.lower + bounds.upper) * 0.5f;
    radius_ = 0.5f * length(bounds.extent());
  }
  const bool has_each = lights.lights.size() <= kLightsEachMax;
  if (has_each) {
    for (const Light& light : lights.lights) each_.push_back(point_of(light));
  }
  placed_ = shares(!has_each);
  all_ = shares(true);
}

LightSubpaths::Shares LightSubpaths::shares(bool has_each) const {
  Shares result;
  std::vector<double> power;
  double emitted = 0;
  for (const Emitter& e : lights_.emitters) emitted += luminance(e.emission) * e.area;
  power.push_back(emitted * kPi);
  const double disk = kPi * static_cast<double>(radius_) * radius_;
  for (const Light& light : lights_.lights) {
    const double shed = light.kind == LightKind::kDirectional ? disk
                        : light.kind == LightKind::kSpot      ? cone_of(light)
                                                              : 4 * kPi;
    power.push_back(has_each ? shed * luminance(light.intensity) : 0);
  }
  power.push_back(disk * sky_power());
  for (const double p : power) result.total += p;
  double sum = 0;
  for (const double p : power) {
    sum += p;
    result.cumulative.push_back(static_cast<float>(sum / result.total));
  }
  // Nothing is picked behind the last light that has any power.
  for (std::size_t i = power.size(); i-- > 0 && result.total > 0;) {
    result.cumulative[i] = 1;
    if (power[i] > 0) break;
  }
  return result;
}

// Power of the sky per unit of area that faces it.
double LightSubpaths::sky_power() const {
  if (!lights_.has_environment) return 0;
  const double brightness = luminance(lights_.environment);
  return brightness * (lights_.sky_map ? lights_.sky_map->power() : 4 * kPi);
}

// Samples the way of light from the sky, and what it brings to a surface that faces it.
LightSubpaths::FromSky LightSubpaths::from_sky(Vec2f x) const {
  if (!lights_.sky_map) return {in_cone({0, 0, 1}, 2, x), lights_.environment * (4 * kPi)};
  const SkyMap::Sample s = lights_.sky_map->sample(x);
  return {-s.direction, lights_.environment * s.radiance * s.angle};
}

LightSubpaths::Pick LightSubpaths::pick(const Shares& shares, Vec2f x) {
  const auto& sums = shares.cumulative;
  const auto it = std::upper_bound(sums.begin(), sums.end() - 1, x.x);
  const auto source = static_cast<std::size_t>(it - sums.begin());
  const float below = source == 0 ? 0 : sums[source - 1], chance = *it - below;
  constexpr float kBelowOne = 1 - kUnitRoundoff;
  const float rest = std::clamp((x.x - below) / chance, 0.0f, kBelowOne);
  return {source, chance, {rest, x.y}};
}

// A point, uniform on the disk that light from far away passes on its way to the scene. The disk
// lies twice its radius before the scene's middle.
Vec3f LightSubpaths::on_disk(Vec3f direction, Vec2f square) const {
  const Vec2f disk = concentric_disk(square);
  const Basis basis = basis_about(direction);
  return centre_ + (basis.tangent * disk.x + basis.bitangent * disk.y - direction * 2) * radius_;
}

LightPoint LightSubpaths::place(Vec2f x) const {
  const Pick p = pick(placed_, x);
  if (p.source == 0) {
    float rest = p.rest.x;
    const Emitter& e = lights_.pick(rest, rest);
    const EmitterPoint on = point_on(lights_, e, {rest, p.rest.y});
    LightPoint point{};
    point.kind = LightPointKind::kEmitter;
    put(point.position, on.at.point + on.normal * on.at.offset);
    put(point.normal, on.normal);
    if (!e.is_patch() && !is_sliver(e.edge_b, e.edge_c)) point.primitive = e.triangle;
    put(point.rgb, on.emission * (on.area / (e.share * p.chance)));
    return point;
  }
  if (p.source <= lights_.lights.size()) {
    LightPoint point = point_of(lights_.lights[p.source - 1]);
    scale(point, 1 / p.chance);
    return point;
  }
  LightPoint sky{};
  sky.kind = LightPointKind::kFar;
  const FromSky from = from_sky(p.rest);
  put(sky.normal, from.way);
  put(sky.rgb, from.irradiance * (1 / p.chance));
  return sky;
}

std::optional<LightRay> LightSubpaths::ray(Vec2f x, Vec2f direction) const {
  const Pick p = pick(all_, x);
  if (p.source == 0) {
    float rest = p.rest.x;
    const Emitter& e = lights_.pick(rest, rest);
    const EmitterPoint on = point_on(lights_, e, {rest, p.rest.y});
    const Vec3f d = cosine_direction(on.normal, direction);
    if (!(dot(d, on.normal) > 0)) return std::nullopt;
    return LightRay{on.at.point + on.normal * on.at.offset, d,
                    on.emission * (kPi * on.area / (e.share * p.chance))};
  }
  if (p.source > lights_.lights.size()) {
    const FromSky from = from_sky(p.rest);
    const float disk = kPi * radius_ * radius_;
    return LightRay{on_disk(from.way, direction), from.way, from.irradiance * (disk / p.chance)};
  }
  const Light& light = lights_.lights[p.source - 1];
  if (light.kind == LightKind::kDirectional) {
    const float disk = kPi * radius_ * radius_;
    return LightRay{on_disk(light.direction, direction), light.direction,
                    light.intensity * (disk / p.chance)};
  }
  const bool is_spot = light.kind == LightKind::kSpot;
  const Vec3f d = in_cone(is_spot ? light.direction : Vec3f{0, 0, 1},
                          is_spot ? 1 - light.cos_outer : 2, direction);
  const float falloff = is_spot ? spot_falloff(light, dot(light.direction, d)) : 1;
  if (!(falloff > 0)) return std::nullopt;
  const float angle = is_spot ? cone_of(light) : 4 * kPi;
  return LightRay{light.position, d, light.intensity * (angle * falloff / p.chance)};
}

}  // namespace tessera::core
