// SPDX-License-Identifier: Apache-2.0
// Property: fans, bundles, rays in flight and single rays find what patch_hit() finds in all
// sub-patches, to the bit, on every instruction set; of equal t the lowest sub-patch. Any-hit finds
// whether there is one. The complete solver of cubics has one answer on all sets.
#include <gtest/gtest.h>

#include <bit>
#include <cmath>
#include <cstdlib>

#include "slave/core/kernels/kernel_table.h"
#include "slave/core/primitive/freeform/patched_index.h"
#include "slave/core/primitive/patch/cubic_solver_abi.h"
#include "slave/core/primitive/patch/patch_evaluation.h"
#include "slave/core/trace/scene_tracer.h"
#include "tests/support/packets.h"
#include "tests/support/patch_rays.h"
#include "tests/support/render.h"
#include "tests/support/seed.h"

namespace tessera::core {
namespace {

using test::PatchRays;

// 64 rays that are traced together.
struct Group {
  PatchRay ray[kPacketRays];
  bool is_fan = false;
  std::uint64_t active = ~std::uint64_t{0};
};

// Rays of the kinds in turns: all on their own, a bundle, a fan; and bounces from where a ray hits.
std::vector<Group> groups_of(test::PatchScene& scene, bool is_ring, std::size_t count) {
  constexpr PatchRays kKinds[] = {PatchRays::kCamera, PatchRays::kBorder, PatchRays::kInside,
                                  PatchRays::kGrazing};
  test::PatchRayMaker maker(scene, is_ring, test::seed(77));
  const auto solver = std::make_unique<CompleteSolver>();
  const auto number = [&] { return maker.any().share() - 0.5f; };
  std::vector<Group> groups(count);
  for (std::size_t g = 0; g < count; ++g) {
    const PatchRays kind = kKinds[g % 4];
    const PatchRay first = maker.next(kind);
    const auto hit = scene.trace(first, *solver);
    // All of a packet at one edge, too.
    const bool is_at_edge = kind == PatchRays::kBorder || kind == PatchRays::kGrazing;
    const float spread =
        std::ldexp(1.0f, -static_cast<int>(maker.any().below(is_at_edge ? 27 : 12)));
    groups[g].is_fan = g % 3 == 2;
    for (int i = 0; i < kPacketRays && g % 21 == 8; ++i)
      if (maker.any().one_in(3)) groups[g].active ^= std::uint64_t{1} << i;
    for (PatchRay& ray : groups[g].ray) {
      ray = first;
      if (g % 5 == 0) {
        ray = maker.next(kind);
      } else if (g % 5 == 1 && hit.is_hit && !groups[g].is_fan) {
        for (int a = 0; a < 3; ++a) {
          ray.origin[a] += static_cast<float>(hit.t) * ray.direction[a];
          ray.direction[a] = number();
        }
      } else {
        for (int a = 0; a < 3; ++a) {
          if (!groups[g].is_fan) ray.origin[a] += 0.1f * spread * number();
          ray.direction[a] += spread * number();
        }
      }
      if (groups[g].is_fan) std::copy_n(first.origin, 3, ray.origin);
      if (maker.any().one_in(8)) ray.t_max = 2 * maker.any().share();
      if (!groups[g].is_fan && maker.any().one_in(16)) ray.t_min = 0.3f;
      if (maker.any().one_in(64)) ray.direction[1] = 0;
    }
  }
  return groups;
}

struct Answer {
  bool is_hit = false;
  float t = 0;
  std::uint32_t part = kNoPrimitive;
  bool operator==(const Answer& other) const {
    return is_hit == other.is_hit && part == other.part &&
           std::bit_cast<std::uint32_t>(t) == std::bit_cast<std::uint32_t>(other.t);
  }
};

// Among rays that float32 tells apart, the nearest, then the lowest.
Answer brute_force(const test::PatchScene& scene, PatchRay ray, CompleteSolver& solver) {
  Answer best;
  const float t_max = ray.t_max;
  ray.t_max = std::numeric_limits<float>::infinity();
  const auto& parts = scene.parts();
  for (std::uint32_t k = 0; k < parts.parts.size(); ++k) {
    if (!test::passes(ray, parts.boxes[k], 1e-3, double{t_max} + 1)) continue;
    const PatchHit hit = patch_hit(scene.patch(parts.parts[k].patch), parts.parts[k], ray, solver);
    const auto t = static_cast<float>(hit.t);
    if (hit.is_hit && t >= ray.t_min && t <= t_max && (!best.is_hit || t < best.t))
      best = {true, t, k};
  }
  return best;
}

FanPacket fan_packet(const Group& group) {
  FanPacket packet;
  packet.active = group.active;
  packet.t_min = 0;
  std::copy_n(group.ray[0].origin, 3, packet.origin);
  for (std::size_t i = 0; i < kPacketRays; ++i) {
    for (int a = 0; a < 3; ++a) packet.direction[a][i] = group.ray[i].direction[a];
    packet.t_max[i] = group.ray[i].t_max;
  }
  return packet;
}

RayPacket ray_packet(const Group& group) {
  RayPacket packet{};
  packet.active = group.active;
  for (std::size_t i = 0; i < kPacketRays; ++i) {
    for (int a = 0; a < 3; ++a) {
      packet.origin[a][i] = group.ray[i].origin[a];
      packet.direction[a][i] = group.ray[i].direction[a];
    }
    packet.t_min[i] = group.ray[i].t_min;
    packet.t_max[i] = group.ray[i].t_max;
  }
  return packet;
}

// Counts answers that differ from the wanted ones.
class Comparison {
 public:
  Comparison(const SceneTracer& tracer, const Group& group, const Answer* wanted)
      : tracer_(tracer), group_(group), wanted_(wanted) {}

  std::size_t differences() {
    if (group_.is_fan) {
      together(fan_packet(group_));
    } else {
      together(ray_packet(group_));
    }
    for (std::size_t i = 0; i < kPacketRays; ++i) {
      const PatchRay& ray = group_.ray[i];
      const SingleRay single{{ray.origin[0], ray.origin[1], ray.origin[2]},
                             {ray.direction[0], ray.direction[1], ray.direction[2]},
                             ray.t_min,
                             ray.t_max};
      const SingleHit hit = tracer_.closest(single);
      count_ += !(answer(hit.t, hit.primitive) == wanted_[i]);
      count_ += tracer_.occluded(single) != wanted_[i].is_hit;
    }
    return count_;
  }

 private:
  static Answer answer(float t, std::uint32_t primitive) {
    return primitive == kNoPrimitive ? Answer{} : Answer{true, t, primitive};
  }
  template <class Packet>
  void together(const Packet& packet) {
    PacketHits hits;
    tracer_.closest(packet, hits);
    const std::uint64_t blocked = tracer_.occluded(packet);
    for (std::size_t i = 0; i < kPacketRays; ++i) {
      const bool is_active = (group_.active >> i & 1) != 0;
      const Answer wanted = is_active ? wanted_[i] : Answer{};
      count_ += !(answer(hits.t[i], hits.primitive[i]) == wanted);
      count_ += ((blocked >> i & 1) != 0) != wanted.is_hit;
    }
  }

  const SceneTracer& tracer_;
  const Group& group_;
  const Answer* wanted_;
  std::size_t count_ = 0;
};

PrimitiveIndex index_of(const test::PatchScene& scene, bool is_wide) {
  auto store = std::make_shared<PatchStore>();
  for (std::size_t p = 0; p < scene.patch_count(); ++p) store->patches.push_back(scene.patch(p));
  store->parts.assign(scene.parts().parts.begin(), scene.parts().parts.end());
  for (std::uint32_t k = 0; k < store->parts.size(); ++k) store->parts[k].primitive = k;
  const PatchedParts parts{{}, {}, {}, scene.parts().boxes};
  if (is_wide) return {std::move(*index_patches<16>(parts, store, {}))};
  return {std::move(*index_patches<8>(parts, store, {}))};
}

std::size_t group_count() { return std::getenv("TESSERA_LONG") != nullptr ? 2300 : 230; }

// 161,920 rays, or ten times as many, of seven shapes; four of them also as scenes of very many
// patches have theirs, whole for the most part.
TEST(PatchKernels, FindWhatPatchHitFinds) {
  const PatchSplitting usual, coarse{1, 1}, whole{3, 1};
  const std::pair<const char*, PatchSplitting> cases[] = {
      {"teapot", usual},      {"sphere", usual}, {"torus", usual}, {"cylinder", usual},
      {"degree15x9", coarse}, {"cusp", usual},   {"fold", usual},  {"teapot", whole},
      {"cusp", whole},        {"fold", whole},   {"sphere", whole}};
  for (const auto& [shape, splitting] : cases) {
    SCOPED_TRACE(shape);
    test::PatchScene scene(test::patch_shape(shape), splitting);
    const std::vector<Group> groups =
        groups_of(scene, std::string(shape) == "torus", group_count());
    const auto solver = std::make_unique<CompleteSolver>();
    std::vector<Answer> wanted;
    std::size_t hits = 0;
    for (const Group& group : groups)
      for (const PatchRay& ray : group.ray) {
        wanted.push_back(brute_force(scene, ray, *solver));
        hits += wanted.back().is_hit;
      }
    EXPECT_GT(hits, wanted.size() / 8);
    for (const Isa isa : test::isas_here()) {
      SCOPED_TRACE(isa_name(isa));
      const KernelTable& kernels = kernels_for(isa);
      const PrimitiveIndex index = index_of(scene, kernels.lane_count >= 16);
      const SceneTracer tracer(index, kernels);
      std::size_t differ = 0;
      for (std::size_t g = 0; g < groups.size(); ++g)
        differ += Comparison(tracer, groups[g], wanted.data() + g * kPacketRays).differences();
      EXPECT_EQ(differ, 0u);
    }
  }
}

// Shapes of degrees 1 to 3, rational and not, whole patches and parts of them.
TEST(PatchKernels, CubicSolverHasOneAnswerOnAllSets) {
  std::size_t hits = 0;
  for (const char* shape : {"teapot", "sphere", "cone", "cylinder", "cusp", "fold", "plane"}) {
    SCOPED_TRACE(shape);
    test::PatchScene scene(test::patch_shape(shape), PatchSplitting{1, 1});
    test::PatchRayMaker maker(scene, false, test::seed(78));
    for (int k = 0; k < 3000; ++k) {
      const PatchRay ray = maker.next(k % 2 == 0 ? PatchRays::kBorder : PatchRays::kGrazing);
      const std::size_t number =
          maker.any().below(static_cast<std::uint32_t>(scene.parts().parts.size()));
      const SubPatch& part = scene.parts().parts[number];
      const float range[2] = {ray.t_min, ray.t_max};
      SolvedPatch first{};
      bool is_first = true;
      for (const Isa isa : test::isas_here()) {
        SolvedPatch solved{};
        cubic_solver(isa)(scene.patch(part.patch), part, ray.origin, ray.direction, range, solved);
        if (is_first) first = solved;
        is_first = false;
        ASSERT_EQ(solved.is_hit, first.is_hit);
        ASSERT_EQ(solved.box_count, first.box_count);
        ASSERT_EQ(std::bit_cast<std::uint64_t>(solved.t), std::bit_cast<std::uint64_t>(first.t));
        ASSERT_EQ(std::bit_cast<std::uint64_t>(solved.u), std::bit_cast<std::uint64_t>(first.u));
        ASSERT_EQ(std::bit_cast<std::uint64_t>(solved.v), std::bit_cast<std::uint64_t>(first.v));
      }
      hits += first.is_hit;
    }
  }
  EXPECT_GT(hits, 500u);
}

// Questions side by side have the bits of each alone: of one part and of many, of one kind of patch
// and of all, for counts that fill registers and that do not.
TEST(PatchKernels, CubicSolversAnswerAsOneByOne) {
  constexpr int kMost = 70;
  std::size_t hits = 0, many = 0;
  std::vector<std::unique_ptr<test::PatchScene>> scenes;
  std::vector<test::PatchRayMaker> makers;
  std::vector<std::vector<Patch>> patches;
  for (const char* shape : {"teapot", "sphere", "cone", "cylinder", "cusp", "fold", "plane"}) {
    for (const PatchSplitting& splitting : {PatchSplitting{1, 1}, PatchSplitting{3, 1}}) {
      scenes.push_back(std::make_unique<test::PatchScene>(test::patch_shape(shape), splitting));
      makers.emplace_back(*scenes.back(), false, test::seed(79));
      std::vector<Patch>& of = patches.emplace_back();
      for (std::size_t p = 0; p < scenes.back()->patch_count(); ++p)
        of.push_back(scenes.back()->patch(p));
    }
  }
  test::PatchRayMaker& any = makers[0];
  for (std::uint32_t round = 0; round < 2400; ++round) {
    PatchQuestion questions[kMost];
    const int count = 1 + static_cast<int>(any.any().below(kMost));
    const bool is_one_part = any.any().one_in(2), is_mixed = any.any().one_in(4);
    std::size_t which = round % scenes.size();
    for (int k = 0; k < count; ++k) {
      if (is_mixed) which = any.any().below(static_cast<std::uint32_t>(scenes.size()));
      const auto& parts = scenes[which]->parts().parts;
      const PatchRays kinds[] = {PatchRays::kBorder, PatchRays::kGrazing, PatchRays::kCamera};
      const PatchRay ray = makers[which].next(kinds[any.any().below(3)]);
      PatchQuestion& question = questions[k];
      if (k == 0 || !is_one_part) {
        const SubPatch& part = parts[any.any().below(static_cast<std::uint32_t>(parts.size()))];
        question = {&patches[which][part.patch], &part, {}, {}, {ray.t_min, ray.t_max}};
      } else {
        question = questions[0];
      }
      std::copy_n(ray.origin, 3, question.origin);
      std::copy_n(ray.direction, 3, question.direction);
    }
    for (const Isa isa : test::isas_here()) {
      SolvedPatch solved[kMost] = {};
      cubic_solvers(isa)(questions, count, solved);
      for (int k = 0; k < count; ++k) {
        const PatchQuestion& q = questions[k];
        SolvedPatch alone{};
        cubic_solver(isa)(*q.patch, *q.part, q.origin, q.direction, q.t_range, alone);
        ASSERT_EQ(solved[k].is_hit, alone.is_hit);
        ASSERT_EQ(solved[k].box_count, alone.box_count);
        ASSERT_EQ(solved[k].is_exhausted, alone.is_exhausted);
        ASSERT_EQ(std::bit_cast<std::uint64_t>(solved[k].t), std::bit_cast<std::uint64_t>(alone.t));
        ASSERT_EQ(std::bit_cast<std::uint64_t>(solved[k].u), std::bit_cast<std::uint64_t>(alone.u));
        ASSERT_EQ(std::bit_cast<std::uint64_t>(solved[k].v), std::bit_cast<std::uint64_t>(alone.v));
        hits += alone.is_hit;
        many += alone.box_count > 8;
      }
    }
  }
  const std::size_t isas = test::isas_here().size();
  EXPECT_GT(hits, 2500 * isas);
  EXPECT_GT(many, 2500 * isas);
}

}  // namespace
}  // namespace tessera::core
