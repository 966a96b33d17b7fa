// SPDX-License-Identifier: Apache-2.0
// Property: what patches answer to rays is what extended precision says: no root that has to be met
// is missed, none nearer is passed over, nothing is met where there is no root; t, u, v and the
// point are as near as is promised. Rays from outside, from inside, at borders, grazing and far, at
// shapes that are smooth, rational, folded, flat, collapsed, far away and tiny. TESSERA_LONG=1 asks
// for 20 times as many rays.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <memory>
#include <ostream>
#include <string>

#include "slave/core/primitive/patch/patch_decision.h"
#include "slave/core/primitive/patch/sub_patch_range.h"
#include "tests/support/patch_rays.h"
#include "tests/support/patch_reference.h"

namespace tessera {
namespace {

using core::PatchRay;
using test::PatchRays;

int rays(int few) { return std::getenv("TESSERA_LONG") == nullptr ? few : 20 * few; }

struct Class {
  const char* shape;
  PatchRays kind;
  int count;
  float scale = 1, shift = 0;
};
void PrintTo(const Class& c, std::ostream* out) {
  *out << c.shape << " kind " << static_cast<int>(c.kind) << " scale " << c.scale << " shift "
       << c.shift;
}

struct Counts {
  std::size_t missed = 0, wrong = 0, false_hits = 0, hits = 0;
  double t_norm = 0, uv = 0, uv_norm = 0, residual = 0;
};

double length_of(const PatchRay& ray) {
  return std::hypot(double{ray.direction[0]}, double{ray.direction[1]}, double{ray.direction[2]});
}

class Judge {
 public:
  explicit Judge(const test::PatchScene& scene) : scene_(scene) {
    diagonal_ = length(widened(scene.bounds().extent()));
  }

  void judge(const PatchRay& ray, const test::PatchScene::Hit& hit) {
    roots_.clear();
    owners_.clear();
    for (std::size_t p = 0; p < scene_.patch_count(); ++p) {
      if (!test::passes(ray, scene_.bounds(p), 0x1p-16 * diagonal_, double{ray.t_max})) continue;
      reference_.solve(scene_.patch(p), ray, roots_);
      owners_.resize(roots_.size(), static_cast<std::uint32_t>(p));
    }
    const test::PatchRoot* must = nullptr;
    for (const test::PatchRoot& root : roots_)
      if (!root.is_fragile && !root.is_edge && root.t > double{ray.t_min} + root.allowed_t &&
          (must == nullptr || root.t < must->t))
        must = &root;
    if (hit.is_hit) {
      ++counts.hits;
      judge_hit(ray, hit);
      counts.wrong += must != nullptr && hit.t > must->t + must->allowed_t;
    } else {
      counts.missed += must != nullptr;
    }
  }

  Counts counts;

 private:
  // Where patches meet, any of them may report the point. A fragile root is a whole stretch: a
  // shift of 16 u s of the ray moves it by the root of that, 2^-10 of a size.
  void judge_hit(const PatchRay& ray, const test::PatchScene::Hit& hit) {
    double best = INFINITY;
    std::size_t met = 0;
    for (std::size_t k = 0; k < roots_.size(); ++k) {
      const double stretch = roots_[k].is_fragile ? 0x1p-10 * diagonal_ / length_of(ray) : 0;
      const double off = std::fabs(roots_[k].t - hit.t) / (roots_[k].allowed_t + stretch);
      if (off < best) {
        best = off;
        met = k;
      }
    }
    const test::LongJet jet = test::long_jet(scene_.patch(hit.patch), hit.u, hit.v);
    for (int a = 0; a < 3; ++a) {
      const long double off =
          jet.point[a] - ray.origin[a] - static_cast<long double>(hit.t) * ray.direction[a];
      counts.residual = std::max(counts.residual, static_cast<double>(std::fabs(off)) / diagonal_);
    }
    if (!(best <= 1)) {
      ++counts.false_hits;
    } else if (!roots_[met].is_fragile) {
      counts.t_norm = std::max(counts.t_norm, 8 * best);
      if (owners_[met] == hit.patch) judge_place(ray, hit, roots_[met]);
    }
  }

  // u and v are off by the end of the iteration; where the root is beyond the part's border by what
  // ranges overlap by, by that; by what noise moves the root by; and, where the complete solver
  // ends by size, by the size of what is flat (complete_solver.h).
  void judge_place(const PatchRay& ray, const test::PatchScene::Hit& hit,
                   const test::PatchRoot& root) {
    const core::SubPatchRange range(scene_.parts().parts[hit.part]);
    double far = 0;
    for (int a = 0; a < 3; ++a)
      far = std::max({far, std::fabs(double{scene_.bounds(hit.patch).lower[a] - ray.origin[a]}),
                      std::fabs(double{scene_.bounds(hit.patch).upper[a] - ray.origin[a]})});
    const double shift = 0x1p-31 * scene_.patch(hit.patch).extent + 0x1p-40 * far;
    const double off[2] = {std::fabs(root.u - hit.u), std::fabs(root.v - hit.v)};
    const double half[2] = {range.half_u, range.half_v};
    const double x[2] = {(root.u - range.middle_u) / half[0], (root.v - range.middle_v) / half[1]};
    for (int k = 0; k < 2; ++k) {
      const double allowed =
          half[k] * (core::plain::kPatchStep + std::max(std::fabs(x[k]) - 1, 0.0)) +
          shift * root.by_shift[k];
      counts.uv = std::max(counts.uv, off[k]);
      counts.uv_norm = std::max(counts.uv_norm, off[k] / allowed);
    }
  }

  const test::PatchScene& scene_;
  double diagonal_ = 0;
  test::PatchReference reference_;
  std::vector<test::PatchRoot> roots_;
  std::vector<std::uint32_t> owners_;
};

class PatchAnswers : public testing::TestWithParam<Class> {};

TEST_P(PatchAnswers, AreThoseOfExtendedPrecision) {
  const Class c = GetParam();
  auto patches = test::patch_shape(c.shape);
  if (c.scale != 1 || c.shift != 0) patches = test::moved(patches, c.scale, c.shift);
  test::PatchScene scene(std::move(patches));
  test::PatchRayMaker maker(scene, std::string(c.shape) == "torus", 20081, c.scale, c.shift);
  const auto solver = std::make_unique<core::CompleteSolver>();
  Judge judge(scene);
  const int count = rays(c.count);
  for (int k = 0; k < count; ++k) {
    const PatchRay ray = maker.next(c.kind);
    judge.judge(ray, scene.trace(ray, *solver));
    const Counts& n = judge.counts;
    ASSERT_TRUE(n.missed == 0 && n.wrong == 0 && n.false_hits == 0)
        << "ray " << k << ": missed " << n.missed << ", wrong " << n.wrong << ", false "
        << n.false_hits << "\n"
        << std::hexfloat << ray.origin[0] << " " << ray.origin[1] << " " << ray.origin[2] << "  "
        << ray.direction[0] << " " << ray.direction[1] << " " << ray.direction[2];
  }
  const Counts& n = judge.counts;
  std::cout << "hits " << n.hits << " of " << count << ", t " << n.t_norm << " of 8, uv " << n.uv
            << ", " << n.uv_norm << " of what is derived, residual " << n.residual << ", open rays "
            << scene.open_ray_count() << "\n";
  EXPECT_GT(n.hits, static_cast<std::size_t>(count) / 16);  // the class is not all misses
  // Rays that are neither tangent nor aimed at borders are decided without the complete solver,
  // wherever the shape lies and how large it is; but weights 2^12 apart squeeze the surface into
  // parts that are smaller than parts become.
  const bool is_plain = c.kind == PatchRays::kCamera || c.kind == PatchRays::kInside;
  if (is_plain && std::string(c.shape) != "weights") {
    EXPECT_LT(scene.open_ray_count(), static_cast<std::size_t>(count) / 25);
  }
  // Within the promises: t by 8 u s as the surface is seen, u and v and the point far better.
  EXPECT_LT(n.t_norm, 8);
  EXPECT_LT(n.uv, 2e-4);
  EXPECT_LE(n.uv_norm, 1);
  EXPECT_LT(n.residual, 1e-6);
}

INSTANTIATE_TEST_SUITE_P(
    All, PatchAnswers,
    testing::Values(
        Class{"teapot", PatchRays::kCamera, 20'000}, Class{"teapot", PatchRays::kBorder, 6'000},
        Class{"teapot", PatchRays::kGrazing, 50}, Class{"teapot", PatchRays::kFar, 3'000},
        Class{"teapot", PatchRays::kCamera, 4'000, 1e-6f},
        Class{"teapot", PatchRays::kCamera, 4'000, 1, 1e5f},
        Class{"sphere", PatchRays::kInside, 10'000},
        Class{"sphere", PatchRays::kInsideAtBorder, 6'000},
        Class{"sphere", PatchRays::kGrazing, 100},
        Class{"cylinder", PatchRays::kInsideAtBorder, 6'000},
        Class{"cylinder", PatchRays::kGrazing, 200}, Class{"cone", PatchRays::kCamera, 6'000},
        Class{"cone", PatchRays::kInsideAtBorder, 6'000}, Class{"torus", PatchRays::kCamera, 8'000},
        Class{"torus", PatchRays::kGrazing, 100}, Class{"torus", PatchRays::kInsideAtBorder, 4'000},
        Class{"torus", PatchRays::kCamera, 4'000, 1, 1e4f},
        Class{"torus", PatchRays::kCamera, 4'000, 1e-20f},
        Class{"plane", PatchRays::kCamera, 2'000}, Class{"plane", PatchRays::kGrazing, 500},
        Class{"plane33", PatchRays::kCamera, 2'000}, Class{"cusp", PatchRays::kCamera, 3'000},
        Class{"fold", PatchRays::kCamera, 3'000}, Class{"sheets", PatchRays::kCamera, 3'000},
        Class{"sheets", PatchRays::kGrazing, 200}, Class{"weights", PatchRays::kCamera, 2'000},
        Class{"weights", PatchRays::kBorder, 1'000}, Class{"weights4x5", PatchRays::kCamera, 2'000},
        Class{"degree15x9", PatchRays::kCamera, 1'000},
        Class{"degree15x9", PatchRays::kBorder, 500}));

// A ray of a plane in which it lies has roots everywhere: whatever it gets, the work is bounded.
TEST(PatchAnswersBounded, RaysInTheSurfaceEnd) {
  test::PatchScene scene(test::patch_shape("plane33"));
  const auto solver = std::make_unique<core::CompleteSolver>();
  const PatchRay ray{{-1, 0.3f, 0.25f}, {1, 0.1f, 0}};
  for (const core::SubPatch& part : scene.parts().parts) {
    core::PatchWay way{};
    const core::PatchHit hit = core::patch_hit(scene.patch(0), part, ray, *solver, &way);
    EXPECT_EQ(way, core::PatchWay::kCompleteSolver);
    EXPECT_LE(solver->box_count(), core::CompleteSolver::kBoxesMax + 1);
    EXPECT_TRUE(!hit.is_hit || (hit.t >= 1 && hit.t <= 2));
  }
}

// What no bound decides is at most 1 % of the rays of a picture of the teapot, misses included.
TEST(PatchAnswersBounded, FewRaysOfAPictureAreOpen) {
  test::PatchScene scene(test::patch_shape("teapot"));
  const auto solver = std::make_unique<core::CompleteSolver>();
  const Bounds3f& box = scene.bounds();
  const Vec3d middle = 0.5 * (widened(box.lower) + widened(box.upper));
  const double radius = 0.5 * length(widened(box.extent()));
  const Vec3d eye = middle + 2.2 * radius * normalize(Vec3d{0.3, -0.85, 0.43});
  const Vec3d forward = normalize(middle - eye);
  const Vec3d right = 0.42 * normalize(cross(forward, Vec3d{0, 0, 1})), up = cross(right, forward);
  constexpr int kSize = 256;
  std::size_t hits = 0;
  for (int y = 0; y < kSize; ++y)
    for (int x = 0; x < kSize; ++x) {
      const Vec3d d =
          forward + (2 * (x + 0.5) / kSize - 1) * right + (1 - 2 * (y + 0.5) / kSize) * up;
      PatchRay ray{};
      for (int a = 0; a < 3; ++a) {
        ray.origin[a] = static_cast<float>(eye[a]);
        ray.direction[a] = static_cast<float>(d[a]);
      }
      hits += scene.trace(ray, *solver).is_hit;
    }
  std::cout << "hits " << hits << ", open " << scene.open_ray_count() << " of " << scene.ray_count()
            << "\n";
  EXPECT_GT(hits, scene.ray_count() / 5);
  EXPECT_LT(scene.open_ray_count(), scene.ray_count() / 100);
}

TEST(PatchAnswersBounded, RaysThatAreNoneMiss) {
  test::PatchScene scene(test::patch_shape("plane"));
  const auto solver = std::make_unique<core::CompleteSolver>();
  const PatchRay good{{0.5f, 0.5f, 1}, {0, 0, -1}};
  ASSERT_TRUE(scene.trace(good, *solver).is_hit);
  for (int a = 0; a < 3; ++a)
    for (const float bad : {NAN, INFINITY, -INFINITY}) {
      PatchRay ray = good;
      ray.origin[a] = bad;
      EXPECT_FALSE(core::patch_hit(scene.patch(0), scene.parts().parts[0], ray, *solver).is_hit);
      ray = good;
      ray.direction[a] = bad;
      EXPECT_FALSE(core::patch_hit(scene.patch(0), scene.parts().parts[0], ray, *solver).is_hit);
    }
  PatchRay still = good;
  still.direction[2] = -0.0f;
  EXPECT_FALSE(core::patch_hit(scene.patch(0), scene.parts().parts[0], still, *solver).is_hit);
  PatchRay ends = good;
  ends.t_max = 0.5f;
  EXPECT_FALSE(scene.trace(ends, *solver).is_hit);
  ends = good;
  ends.t_min = 0.8f;
  EXPECT_FALSE(scene.trace(ends, *solver).is_hit);
}

}  // namespace
}  // namespace tessera
