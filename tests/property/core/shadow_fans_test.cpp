// SPDX-License-Identifier: Apache-2.0
// Property: of rays that leave one point in any directions, shadow fans block those that are
// blocked alone: whatever their number, and with rays among them that are none.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>
#include <memory>
#include <random>
#include <vector>

#include "slave/core/primitive/primitive_index.h"
#include "slave/core/primitive/triangle/triangle_store.h"
#include "slave/core/trace/scene_tracer.h"
#include "tests/support/packets.h"
#include "tests/support/seed.h"
#include "tests/support/test_meshes.h"

namespace tessera::core {
namespace {

constexpr float kInf = std::numeric_limits<float>::infinity();
constexpr float kNan = std::numeric_limits<float>::quiet_NaN();

// Lengths of directions that are out of the ordinary, or of no ray; a fan may have none of these.
constexpr float kOdd[] = {0, kInf, kNan, 1e-30f, 1e30f, 1e-38f};

struct World {
  explicit World(int cells) : mesh(test::make_terrain(cells, 2)) {}

  Mesh mesh;
  std::vector<Bounds3f> boxes;
  TriangleStore store = make_triangle_store(test::make_scene(mesh), boxes);
  IndexedBvh<8> bvh = std::move(*index_by_bvh<8>(boxes, store.vertices, {1, nullptr}));
  IndexedKd<16> kd = std::move(*index_by_kd<16>(boxes, store.vertices, {1, nullptr}));
};

Vec3f any_direction(std::mt19937& random) {
  std::normal_distribution<float> normal;
  return {normal(random), normal(random), normal(random)};
}

// Rays to all sides, or to one, spread about it; every so many of them is odd (0: none).
void fill(FanTargets& targets, int count, bool is_wide, int odd_every, std::mt19937& random,
          float width = 0.1f) {
  std::uniform_real_distribution<float> unit(-1, 1);
  Vec3f main = any_direction(random);
  main.y = -std::fabs(main.y);  // where the ground is
  targets.count = count;
  for (int i = 0; i < count; ++i) {
    const Vec3f spread = any_direction(random) * width;
    Vec3f d = (is_wide ? any_direction(random) : main + spread) * 30.0f;
    if (odd_every > 0 && i % odd_every == odd_every - 1) {
      const float odd = kOdd[random() % std::size(kOdd)];
      if (random() % 2 == 0) {
        d = d * odd;
      } else {
        (&d.x)[random() % 3] = odd;
      }
    }
    for (int a = 0; a < 3; ++a) targets.direction[a][i] = d[a];
  }
}

// Returns: how many rays are blocked.
template <class View>
int check(const KernelTable& table, const View& view, const ShadowFans& fans) {
  const FanTargets& targets = *fans.targets;
  const auto& kernels = kernels_of(table, view);
  std::vector<std::uint64_t> blocked(static_cast<std::size_t>(targets.group_count));
  kernels.occluded_fans(view, fans, blocked.data());
  std::vector<int> seen(static_cast<std::size_t>(targets.count));
  int count = 0;
  for (int g = 0; g < targets.group_count; ++g) {
    for (int i = targets.group[g]; i < targets.group[g + 1]; ++i) {
      const int ray = targets.order[i];
      ++seen[static_cast<std::size_t>(ray)];
      SingleRay alone{{fans.origin[0], fans.origin[1], fans.origin[2]}, {}, fans.t_min, fans.t_max};
      for (int a = 0; a < 3; ++a) alone.direction[a] = targets.direction[a][ray];
      const bool is_blocked = kernels_of(kernels_for(Isa::kScalar), view).occluded_ray(view, alone);
      const std::uint64_t bit = blocked[static_cast<std::size_t>(g)] >> (i - targets.group[g]) & 1u;
      EXPECT_EQ(bit, is_blocked ? 1u : 0u) << isa_name(table.isa) << " ray " << ray;
      count += is_blocked ? 1 : 0;
    }
  }
  EXPECT_EQ(std::count(seen.begin(), seen.end(), 1), targets.count);
  return count;
}

TEST(ShadowFans, BlockTheRaysThatAreBlockedAlone) {
  const World world(300);
  const auto targets = std::make_unique<FanTargets>();
  std::mt19937 random(test::seed(17));
  int blocked = 0, all = 0;
  for (int number = 0; number < 60; ++number) {
    const int counts[] = {1, 3, 4, 17, 64, 65, 200, kFanTargetsMax};
    const int count = counts[number % 8];
    fill(*targets, count, number % 3 == 0, number % 5 < 2 ? 5 : 0, random);
    const Vec3f middle = world.mesh.positions[random() % world.mesh.positions.size()];
    ShadowFans fans{targets.get(), {middle.x, middle.y + 1.5f, middle.z}, 0, 1};
    if (number % 5 == 1) fans.t_min = 0.3f;
    if (number % 5 == 2) fans.t_max = kInf;
    if (number % 20 == 7) fans.t_max = -1;
    if (number % 20 == 8) fans.origin[1] = kNan;
    for (const Isa isa : test::isas_here()) {
      const KernelTable& table = kernels_for(isa);
      table.group_fans(*targets);
      blocked += check(table, view_of(world.bvh), fans);
      blocked += check(table, view_of(world.kd), fans);
      all += 2 * count;
      if (HasFailure()) return;
    }
  }
  EXPECT_GT(blocked, all / 200);
  EXPECT_LT(blocked, all - all / 10);
}

// Fans have little to do there, and are traced by twos where registers are wide.
TEST(ShadowFans, BlockTheSameRaysWhereTrianglesAreWide) {
  const World world(60);
  const auto targets = std::make_unique<FanTargets>();
  std::mt19937 random(test::seed(19));
  int blocked = 0, all = 0;
  for (int number = 0; number < 48; ++number) {
    const float widths[] = {0.2f, 0.1f, 0.05f, 0.02f};
    fill(*targets, kFanTargetsMax, false, number % 3 == 1 ? 300 : 0, random, widths[number % 4]);
    const Vec3f middle = world.mesh.positions[random() % world.mesh.positions.size()];
    ShadowFans fans{targets.get(), {middle.x, middle.y + 1.5f, middle.z}, 0, 1};
    if (number % 5 == 1) fans.t_min = 0.05f;
    for (const Isa isa : test::isas_here()) {
      const KernelTable& table = kernels_for(isa);
      table.group_fans(*targets);
      blocked += check(table, view_of(world.bvh), fans);
      all += kFanTargetsMax;
      if (HasFailure()) return;
    }
  }
  EXPECT_GT(blocked, all / 20);
  EXPECT_LT(blocked, all - all / 20);
}

}  // namespace
}  // namespace tessera::core
