// SPDX-License-Identifier: Apache-2.0
#include "slave/core/integrate/igi/vpl_set.h"

#include <algorithm>
#include <bit>
#include <limits>

#include "slave/core/bsdf/specular.h"
#include "slave/core/light/light_subpaths.h"
#include "slave/core/sampling/dimension.h"
#include "slave/core/sampling/hemisphere.h"
#include "slave/core/sampling/sample_sequence.h"
#include "slave/core/scene/met_surfaces.h"

namespace tessera::core {
namespace {

constexpr float kInvPi = 0.318309886f;
constexpr int kPilotWalks = 128;

double luminance(const float (&c)[3]) { return 0.2126 * c[0] + 0.7152 * c[1] + 0.0722 * c[2]; }

// Key of the random numbers of a frame that are not a pixel's.
std::uint32_t frame_key(const FrameSettings& settings) {
  return hash_combine(mix_bits(settings.seed ^ 0x2545f491u), settings.pass);
}

}  // namespace

// A packet of walks that take their steps together.
class VplSets::Walks {
 public:
  Walks(const PreparedScene::Impl& scene, const SceneTracer& tracer, const LightSubpaths& light,
        std::uint32_t key)
      : tracer_(tracer), light_(light), key_(key), met_(scene, tracer, memory_) {
    for (int i = 0; i < kPacketRays; ++i) surface_at_[i] = &surface_[i];
    std::fill_n(rays_.t_min, kPacketRays, 0.0f);
    std::fill_n(rays_.t_max, kPacketRays, std::numeric_limits<float>::infinity());
  }

  // Starts the walks number first, first + 1... of the sequence.
  void start(std::uint32_t first, int count, Dimension pick, Dimension direction) {
    first_ = first;
    rays_.active = 0;
    for (int i = 0; i < count; ++i) {
      const std::uint32_t number = first + static_cast<std::uint32_t>(i);
      const std::optional<LightRay> ray =
          light_.ray(shuffled_2d(hash_combine(key_, dimension(pick)), number),
                     shuffled_2d(hash_combine(key_, dimension(direction)), number));
      if (ray) put(i, ray->origin, ray->direction, ray->flux);
    }
  }

  // Takes all walks to their next surface. point [kPacketRays]: the VPLs left there, each as if its
  // walk were the only one. Returns: bits of the walks that left a VPL.
  std::uint64_t step(std::uint32_t depth, std::uint64_t& ray_count, LightPoint* point) {
    if (rays_.active == 0) return 0;
    tracer_.closest(rays_, hits_);
    ray_count += static_cast<std::uint64_t>(std::popcount(rays_.active));
    met_.find(rays_, hits_);
    std::uint64_t left = 0, met = met_.points().met;
    met_.make(rays_, hits_, met, nullptr, surface_at_);
    rays_.active = 0;
    for (; met != 0; met &= met - 1) {
      const int i = std::countr_zero(met);
      if (arrive(i, surface_[i], depth, point[i])) left |= std::uint64_t{1} << i;
    }
    return left;
  }

 private:
  void put(int i, Vec3f origin, Vec3f direction, Vec3f flux) {
    if (is_black(flux) || !is_finite(flux)) return;
    for (int a = 0; a < 3; ++a) {
      rays_.origin[a][i] = origin[a];
      rays_.direction[a][i] = direction[a];
    }
    flux_[i] = flux;
    rays_.active |= std::uint64_t{1} << i;
  }

  // A camera's ray weighs what it sees by the cosine to the shading normal; the pdf of walks that
  // arrive is that of the geometric one. The quotient is what makes both agree (Veach, thesis,
  // 1997, section 5.3). Returns: whether the walk leaves a VPL.
  bool arrive(int i, const Surface& s, std::uint32_t depth, LightPoint& point) {
    const Vec3f d{rays_.direction[0][i], rays_.direction[1][i], rays_.direction[2][i]};
    const Vec2f x = shuffled_2d(hash_combine(key_, dimension(Dimension::kVplBounce, depth)),
                                first_ + static_cast<std::uint32_t>(i));
    if (is_specular(s)) {
      pass(i, s, x);
      return false;
    }
    const float shading = -dot(s.shading_normal, d), geometric = -dot(s.normal, d);
    if (!(shading > 0 && geometric > 0)) return false;
    const Vec3f flux = flux_[i] * s.albedo * (shading / geometric);
    const Vec3f start = s.point + s.normal * s.offset;
    point = {};
    point.kind = LightPointKind::kSurface;
    point.triangle = s.sound_triangle;
    for (int a = 0; a < 3; ++a) {
      point.position[a] = start[a];
      point.normal[a] = s.normal[a];
      point.rgb[a] = flux[a] * kInvPi;
    }
    const Vec3f next = cosine_direction(s.normal, x);
    if (dot(next, s.normal) > 0) put(i, start, next, flux);
    return is_finite(flux) && !is_black(flux);
  }

  // Sends light on over mirrors and through glass; no VPL is left there.
  void pass(int i, const Surface& s, Vec2f x) {
    const SpecularSample next = sample_specular(s, s.to_viewer, x);
    const float side = next.is_through ? -1.0f : 1.0f;
    put(i, s.point + s.normal * (side * s.offset), next.direction,
        flux_[i] * next.weight * s.weight);
  }

  const SceneTracer& tracer_;
  const LightSubpaths& light_;
  const std::uint32_t key_;
  std::uint32_t first_ = 0;
  RayPacket rays_;
  PacketHits hits_;
  MetSurfaces::Memory memory_;
  MetSurfaces met_;
  Surface surface_[kPacketRays];
  Surface* surface_at_[kPacketRays];
  Vec3f flux_[kPacketRays];
};

namespace {

void scale(LightPoint& point, float by) {
  for (float& c : point.rgb) c *= by;
}

// Shares `budget` VPLs out to the depths: by power, at least one each, and no more than the depth
// before, since walks of that depth have to pass it. Shape: power [depth]. power[0] == 0: no VPLs
// of depth 0.
std::vector<int> shared_out(const std::vector<double>& power, int budget) {
  double total = 0;
  for (const double p : power) total += p;
  std::vector<int> counts(power.size(), 0);
  const auto depths = static_cast<int>(power.size()) - (power[0] > 0 ? 0 : 1);
  const int free = std::max(0, budget - depths);
  int spent = 0;
  for (std::size_t d = 0; d < power.size(); ++d) {
    if (d == 0 && !(power[0] > 0)) continue;
    counts[d] = 1 + (total > 0 ? static_cast<int>(free * (power[d] / total)) : 0);
    if (d > 1) counts[d] = std::min(counts[d], counts[d - 1]);
    spent += counts[d];
  }
  const std::size_t first = power[0] > 0 ? 0 : 1;
  if (first < counts.size()) counts[first] += std::max(0, budget - spent);
  return counts;
}

}  // namespace

std::vector<double> VplSets::power_by_depth(Walks& walks, const LightSubpaths& light,
                                            std::size_t depths) {
  std::vector<double> power(depths, 0.0);
  power[0] = light.placed_power();
  LightPoint points[kPacketRays];
  for (std::uint32_t first = 0; first < kPilotWalks && depths > 1; first += kPacketRays) {
    walks.start(first, kPacketRays, Dimension::kVplPilotPick, Dimension::kVplPilotFirst);
    for (std::size_t d = 1; d < depths; ++d) {
      std::uint64_t left = walks.step(static_cast<std::uint32_t>(d), ray_count_, points);
      for (; left != 0; left &= left - 1)
        power[d] += luminance(points[std::countr_zero(left)].rgb) / (kInvPi * kPilotWalks);
    }
  }
  return power;
}

// A set takes an aligned run of the sequence, so that all sets together are spread evenly, too.
void VplSets::make_set(Walks& walks, const LightSubpaths& light, std::uint32_t key,
                       const std::vector<int>& counts, std::size_t k) {
  const int walk_count = counts.size() > 1 ? counts[1] : 0;
  const int longest = std::max({1, counts[0], walk_count});
  const std::uint32_t begin =
      static_cast<std::uint32_t>(k) * std::bit_ceil(static_cast<std::uint32_t>(longest));
  std::vector<LightPoint>& set = sets_[k];
  for (int i = 0; i < counts[0]; ++i) {
    const std::uint32_t number = begin + static_cast<std::uint32_t>(i);
    set.push_back(
        light.place(shuffled_2d(hash_combine(key, dimension(Dimension::kVplPlace)), number)));
    scale(set.back(), 1 / static_cast<float>(counts[0]));
  }
  std::vector<std::vector<LightPoint>> by_depth(counts.size());
  LightPoint points[kPacketRays];
  for (int first = 0; first < walk_count; first += kPacketRays) {
    walks.start(begin + static_cast<std::uint32_t>(first),
                std::min(kPacketRays, walk_count - first), Dimension::kVplPick,
                Dimension::kVplFirst);
    for (std::size_t d = 1; d < counts.size() && counts[d] > first; ++d) {
      std::uint64_t left = walks.step(static_cast<std::uint32_t>(d), ray_count_, points);
      for (; left != 0; left &= left - 1) {
        const int i = std::countr_zero(left);
        if (first + i >= counts[d]) break;
        by_depth[d].push_back(points[i]);
        scale(by_depth[d].back(), 1 / static_cast<float>(counts[d]));
      }
    }
  }
  for (const auto& of_depth : by_depth) set.insert(set.end(), of_depth.begin(), of_depth.end());
}

VplSets::VplSets(const PreparedScene::Impl& scene, const SceneTracer& tracer,
                 const FrameSettings& settings)
    : sets_(static_cast<std::size_t>(settings.interleave * settings.interleave)) {
  const LightSubpaths light(scene.lights, tracer.bounds());
  each_ = light.each();
  if (!(light.power() > 0)) return;
  const std::uint32_t key = frame_key(settings);
  Walks walks(scene, tracer, light, key);
  const std::vector<int> counts = shared_out(
      power_by_depth(walks, light, static_cast<std::size_t>(settings.bounces) + 1), settings.vpls);
  for (std::size_t k = 0; k < sets_.size(); ++k) make_set(walks, light, key, counts, k);
}

}  // namespace tessera::core
