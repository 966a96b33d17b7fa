// SPDX-License-Identifier: Apache-2.0
#include "slave/core/integrate/igi/vpl_set.h"

#include <algorithm>
#include <bit>
#include <memory>
#include <utility>

#include "slave/core/bsdf/specular.h"
#include "slave/core/light/light_subpaths.h"
#include "slave/core/ray/ray_bits.h"
#include "slave/core/ray/ray_list.h"
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

// Walks that take their steps together.
class VplSets::Walks {
 public:
  static constexpr int kMost = RayList::kRaysMax;

  Walks(const PreparedScene::Impl& scene, const SceneTracer& tracer, const LightSubpaths& light,
        std::uint32_t key)
      : tracer_(tracer), light_(light), key_(key), met_(scene, tracer, memory_) {
    for (int i = 0; i < kPacketRays; ++i) surface_at_[i] = &surface_[i];
  }

  void clear() {
    count_ = 0;
    next_->clear();
  }
  // Walks since clear().
  int count() const { return count_; }
  // Starts a walk by its number in the sequence, to as many surfaces, in the next place. Requires:
  // count() < kMost, and clear() was called after the last step.
  void start(std::uint32_t number, std::uint32_t surfaces, Dimension pick, Dimension direction) {
    const std::optional<LightRay> ray =
        light_.ray(shuffled_2d(hash_combine(key_, dimension(pick)), number),
                   shuffled_2d(hash_combine(key_, dimension(direction)), number));
    const int place = count_++;
    number_[place] = number;
    surfaces_[place] = surfaces;
    if (ray && surfaces > 0) put(place, ray->origin, ray->direction, ray->flux);
  }

  // Takes all walks to their next surface, number `depth` of each. Calls left(place, point) for
  // each VPL that is left there, as if its walk were the only one. Returns: rays traced.
  template <class Left>
  std::uint64_t step(std::uint32_t depth, const Left& left) {
    std::swap(rays_, next_);
    next_->clear();
    if (rays_->packet_count() == 0) return 0;
    tracer_.closest(rays_->many(), found_.arrays());
    std::uint64_t ray_count = 0;
    for (int p = 0; p < rays_->packet_count(); ++p) {
      if (rays_->active(p) == 0) continue;
      ray_count += static_cast<std::uint64_t>(std::popcount(rays_->active(p)));
      rays_->copy_packet(p, packet_);
      found_.copy_packet(p, hits_);
      met_.find(packet_, hits_);
      met_.make(packet_, hits_, met_.points().met, nullptr, surface_at_);
      for_each_ray(met_.points().met, [&](int i) {
        LightPoint point{};
        const int place = p * kPacketRays + i;
        if (arrive(place, surface_[i], depth, point)) left(place, point);
      });
    }
    return ray_count;
  }

 private:
  void put(int place, Vec3f origin, Vec3f direction, Vec3f flux) {
    if (is_black(flux) || !is_finite(flux)) return;
    next_->put(place, origin, direction);
    flux_[place] = flux;
  }
  // Sends a walk on that has been at surface number `depth`.
  void go_on(int place, std::uint32_t depth, Vec3f origin, Vec3f direction, Vec3f flux) {
    if (depth < surfaces_[place]) put(place, origin, direction, flux);
  }

  // A camera's ray weighs what it sees by the cosine to the shading normal; the pdf of walks that
  // arrive is that of the geometric one. The quotient is what makes both agree (Veach, thesis,
  // 1997, section 5.3). Returns: whether the walk leaves a VPL.
  bool arrive(int i, const Surface& s, std::uint32_t depth, LightPoint& point) {
    const Vec3f d = rays_->direction(i);
    const Vec2f x =
        shuffled_2d(hash_combine(key_, dimension(Dimension::kVplBounce, depth)), number_[i]);
    if (is_specular(s)) {
      pass(i, s, depth, x);
      return false;
    }
    const float shading = -dot(s.shading_normal, d), geometric = -dot(s.normal, d);
    if (!(shading > 0 && geometric > 0)) return false;
    const Vec3f flux = flux_[i] * s.albedo * (shading / geometric);
    const Vec3f start = s.point + s.normal * s.offset;
    point.kind = LightPointKind::kSurface;
    point.primitive = s.sound_primitive;
    point.horizon = s.horizon;
    for (int a = 0; a < 3; ++a) {
      point.position[a] = start[a];
      point.normal[a] = s.normal[a];
      point.rgb[a] = flux[a] * kInvPi;
    }
    const Vec3f next = cosine_direction(s.normal, x);
    if (dot(next, s.normal) > 0) go_on(i, depth, start, next, flux);
    return is_finite(flux) && !is_black(flux);
  }

  // Sends light on over mirrors and through glass; no VPL is left there.
  void pass(int i, const Surface& s, std::uint32_t depth, Vec2f x) {
    const SpecularSample next = sample_specular(s, s.to_viewer, x);
    const float side = next.is_through ? -1.0f : 1.0f;
    go_on(i, depth, s.point + s.normal * (side * s.offset), next.direction,
          flux_[i] * next.weight * s.weight);
  }

  const SceneTracer& tracer_;
  const LightSubpaths& light_;
  const std::uint32_t key_;
  int count_ = 0;
  RayList lists_[2];
  RayList *rays_ = &lists_[0], *next_ = &lists_[1];  // of this step, and of the next
  ListHits found_;
  RayPacket packet_;
  PacketHits hits_;
  MetSurfaces::Memory memory_;
  MetSurfaces met_;
  Surface surface_[kPacketRays];
  Surface* surface_at_[kPacketRays];
  // By place.
  std::uint32_t number_[kMost], surfaces_[kMost];
  Vec3f flux_[kMost];
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
  static_assert(kPilotWalks <= Walks::kMost);
  const auto surfaces = static_cast<std::uint32_t>(depths - 1);
  walks.clear();
  for (std::uint32_t i = 0; i < kPilotWalks; ++i)
    walks.start(i, surfaces, Dimension::kVplPilotPick, Dimension::kVplPilotFirst);
  for (std::uint32_t d = 1; d <= surfaces; ++d) {
    ray_count_ += walks.step(d, [&](int, const LightPoint& point) {
      power[d] += luminance(point.rgb) / (kInvPi * kPilotWalks);
    });
  }
  return power;
}

// The VPLs that walks leave, by set and depth. Walks of all sets take their steps together.
class VplSets::WalkedPoints {
 public:
  // counts: of VPLs of each set, by depth.
  WalkedPoints(Walks& walks, const std::vector<int>& counts, std::size_t sets)
      : walks_(walks), counts_(counts), points_(sets * counts.size()) {
    walks.clear();
  }

  // Adds walk i of a set, by its number in the sequence. It goes on as long as its set wants VPLs
  // of it.
  void add(std::size_t set, int i, std::uint32_t number) {
    if (walks_.count() == Walks::kMost) finish();
    set_[walks_.count()] = set;
    std::uint32_t surfaces = 0;
    while (surfaces + 1 < counts_.size() && counts_[surfaces + 1] > i) ++surfaces;
    walks_.start(number, surfaces, Dimension::kVplPick, Dimension::kVplFirst);
  }
  // Takes the walks that were added to their ends. To be called after the last one, too.
  void finish() {
    for (std::uint32_t d = 1; d < counts_.size(); ++d) {
      ray_count_ += walks_.step(d, [&](int place, const LightPoint& point) {
        std::vector<LightPoint>& of = points_[set_[place] * counts_.size() + d];
        of.push_back(point);
        scale(of.back(), 1 / static_cast<float>(counts_[d]));
      });
    }
    walks_.clear();
  }
  void append_to(std::vector<LightPoint>& points, std::size_t set) const {
    for (std::size_t d = 0; d < counts_.size(); ++d) {
      const std::vector<LightPoint>& of = points_[set * counts_.size() + d];
      points.insert(points.end(), of.begin(), of.end());
    }
  }
  std::uint64_t ray_count() const { return ray_count_; }

 private:
  Walks& walks_;
  const std::vector<int>& counts_;
  std::vector<std::vector<LightPoint>> points_;
  std::size_t set_[Walks::kMost];  // by place
  std::uint64_t ray_count_ = 0;
};

// A set takes an aligned run of the sequence, so that all sets together are spread evenly, too.
void VplSets::make_sets(Walks& walks, const LightSubpaths& light, std::uint32_t key,
                        const std::vector<int>& counts) {
  const int walk_count = counts.size() > 1 ? counts[1] : 0;
  const int longest = std::max({1, counts[0], walk_count});
  const auto begin_of = [&](std::size_t k) {
    return static_cast<std::uint32_t>(k) * std::bit_ceil(static_cast<std::uint32_t>(longest));
  };
  const auto walked = std::make_unique<WalkedPoints>(walks, counts, sets_.size());
  for (std::size_t k = 0; k < sets_.size(); ++k) {
    for (int i = 0; i < walk_count; ++i)
      walked->add(k, i, begin_of(k) + static_cast<std::uint32_t>(i));
  }
  walked->finish();
  ray_count_ += walked->ray_count();
  for (std::size_t k = 0; k < sets_.size(); ++k) {
    std::vector<LightPoint>& set = sets_[k];
    for (int i = 0; i < counts[0]; ++i) {
      const std::uint32_t number = begin_of(k) + static_cast<std::uint32_t>(i);
      set.push_back(
          light.place(shuffled_2d(hash_combine(key, dimension(Dimension::kVplPlace)), number)));
      scale(set.back(), 1 / static_cast<float>(counts[0]));
    }
    walked->append_to(set, k);
  }
}

VplSets::VplSets(const PreparedScene::Impl& scene, const SceneTracer& tracer,
                 const FrameSettings& settings)
    : sets_(static_cast<std::size_t>(settings.interleave * settings.interleave)) {
  const LightSubpaths light(scene.lights, tracer.bounds());
  each_ = light.each();
  if (!(light.power() > 0)) return;
  const std::uint32_t key = frame_key(settings);
  const auto walks = std::make_unique<Walks>(scene, tracer, light, key);
  const std::vector<int> counts = shared_out(
      power_by_depth(*walks, light, static_cast<std::size_t>(settings.bounces) + 1), settings.vpls);
  make_sets(*walks, light, key, counts);
}

}  // namespace tessera::core
