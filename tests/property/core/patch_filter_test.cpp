// SPDX-License-Identifier: Apache-2.0
// Property: what float32 proves of a question to the complete solver is its answer, to the bit, on
// every instruction set: misses, and hits with their t as a float32. It proves nearly all of what
// packets ask for, and leaves open what it has to. Nets are of all degrees of bending, from flat to
// folded many times, whole and in parts, near and far, large and small, away from the origin.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>

#include "slave/core/primitive/patch/cubic_solver_abi.h"
#include "tests/support/choices.h"
#include "tests/support/packets.h"
#include "tests/support/patch_shapes.h"
#include "tests/support/render.h"
#include "tests/support/seed.h"

namespace tessera::core {
namespace {

struct Counts {
  std::uint64_t asked = 0, hits = 0, known_hits = 0, known_misses = 0, known_of_any = 0;

  double known() const {
    return static_cast<double>(known_hits + known_misses) / static_cast<double>(asked);
  }
};

// A bicubic net over about [-1, 1]^2, whose points are off a plane by up to `bend`, and out of
// their places by up to `shear`.
CheckedPatch bent_patch(test::Choices& any, float bend, float shear) {
  CheckedPatch patch;
  patch.degree_u = patch.degree_v = 3;
  for (int i = 0; i < 4; ++i)
    for (int j = 0; j < 4; ++j) {
      const Vec3f off = any.point(1);
      const float places[2] = {2 * static_cast<float>(i) / 3 - 1,
                               2 * static_cast<float>(j) / 3 - 1};
      patch.numbers.insert(patch.numbers.end(),
                           {places[0] + shear * off.x, places[1] + shear * off.y, bend * off.z});
    }
  return patch;
}

void set_extent(CheckedPatch& patch) {
  for (int a = 0; a < 3; ++a) {
    float low = patch.numbers[static_cast<std::size_t>(a)], high = low;
    for (std::size_t k = 0; k < 16; ++k) {
      low = std::min(low, patch.numbers[3 * k + static_cast<std::size_t>(a)]);
      high = std::max(high, patch.numbers[3 * k + static_cast<std::size_t>(a)]);
    }
    patch.extent = std::max(patch.extent, double{high} - double{low});
  }
}

// Rays of all kinds at the patches of a scene, as questions, 64 at a time.
class Asker {
 public:
  explicit Asker(unsigned usual_seed) : any_(usual_seed) {}

  test::Choices& any() { return any_; }

  // far: distance of origins, in sizes of the patches.
  void ask(const test::PatchScene& scene, float far, float size, Counts& counts) {
    std::vector<Patch> patches;
    for (std::size_t p = 0; p < scene.patch_count(); ++p) patches.push_back(scene.patch(p));
    const auto& parts = scene.parts().parts;
    PatchQuestion questions[kQuickMost];
    const int count = 1 + static_cast<int>(any_.below(kQuickMost));
    int asked = 0;
    for (int k = 0; k < count; ++k) {
      const SubPatch& part = parts[any_.below(static_cast<unsigned>(parts.size()))];
      if (!part.has_frame) continue;
      PatchQuestion& question = questions[asked++];
      question = {&patches[part.patch], &part, {}, {}, {0, __builtin_inff()}};
      aim(question, far * size, size);
    }
    SolvedPatch solved[kQuickMost] = {};
    widest_cubic_solvers()(questions, asked, solved);
    compare(questions, solved, asked, counts);
    compare_any(questions, solved, asked, counts);
  }

 private:
  // At a point of the part's square or beside it; some along the surface.
  void aim(PatchQuestion& question, float far, float size) {
    const SubPatch& part = *question.part;
    const float half[2] = {0.5f / static_cast<float>(1u << part.level_u),
                           0.5f / static_cast<float>(1u << part.level_v)};
    const bool is_border = any_.one_in(5);
    float at[2] = {};
    for (int a = 0; a < 2; ++a) {
      const float x = is_border && a == 0 ? std::copysign(1.0f, any_.sign()) : 1.3f * any_.sign();
      at[a] = (2 * static_cast<float>(a == 0 ? part.column : part.row) + 1 + x) * half[a];
    }
    double point[3] = {};
    for (int i = 0; i < 4; ++i)
      for (int j = 0; j < 4; ++j) {
        const double weight = bernstein(i, double{at[0]}) * bernstein(j, double{at[1]});
        for (int a = 0; a < 3; ++a)
          point[a] += weight * double{question.patch->numbers[3 * (4 * i + j) + a]};
      }
    Vec3f direction = any_.point(1);
    if (any_.one_in(4)) {  // nearly across the normal
      const Vec3f normal{part.frame[2][0], part.frame[2][1], part.frame[2][2]};
      const float along = dot(normal, direction) / dot(normal, normal);
      direction = direction - (1 - any_.power(-5, 0)) * along * normal;
    }
    const float length = std::sqrt(dot(direction, direction));
    if (!(length > 0)) direction = {0, 0, 1};
    const float speed = any_.one_in(2) ? 1 / length : size;
    const float numbers[3] = {direction.x, direction.y, direction.z};
    for (int a = 0; a < 3; ++a) {
      question.direction[a] = speed * numbers[a];
      question.origin[a] =
          static_cast<float>(point[a] - double{far} * double{numbers[a]} / double{length});
    }
    // Some begin near where they hit, or behind it.
    if (any_.one_in(8)) question.t_range[0] = far / (speed * length) * (1 + 0.01f * any_.sign());
  }

  static double bernstein(int i, double x) {
    constexpr double kTimes[4] = {1, 3, 3, 1};
    return kTimes[i] * std::pow(x, i) * std::pow(1 - x, 3 - i);
  }

  static void compare(const PatchQuestion* questions, const SolvedPatch* solved, int count,
                      Counts& counts) {
    for (const Isa isa : test::isas_here()) {
      QuickAnswer answers[kQuickMost];
      quick_answers(isa)(questions, count, answers);
      for (int k = 0; k < count; ++k) {
        counts.asked += isa != Isa::kScalar;
        counts.hits += isa != Isa::kScalar && solved[k].is_hit;
        if (!answers[k].is_known) continue;
        ASSERT_EQ(answers[k].is_hit, solved[k].is_hit);
        if (solved[k].is_hit) {
          ASSERT_EQ(answers[k].t, static_cast<float>(solved[k].t));
        }
        ++(solved[k].is_hit ? counts.known_hits : counts.known_misses);
      }
    }
  }

  // Where any hit will do: rays that end behind, at or before what they meet first, or nowhere,
  // some among others.
  void compare_any(PatchQuestion* questions, const SolvedPatch* solved, int count, Counts& counts) {
    const bool is_mixed = any_.one_in(2);
    for (int k = 0; k < count; ++k) {
      const auto t = static_cast<float>(solved[k].t);
      const float ends[4] = {__builtin_inff(), t, std::nextafter(t, 0.0f), 1.001f * t};
      questions[k].is_any = !is_mixed || any_.one_in(2);
      if (questions[k].is_any && solved[k].is_hit) questions[k].t_range[1] = ends[any_.below(4)];
    }
    for (const Isa isa : test::isas_here()) {
      QuickAnswer answers[kQuickMost];
      quick_answers(isa)(questions, count, answers);
      for (int k = 0; k < count; ++k) {
        const PatchQuestion& question = questions[k];
        if (!answers[k].is_known || !question.is_any) continue;
        const bool is_hit =
            solved[k].is_hit && static_cast<float>(solved[k].t) <= question.t_range[1];
        ASSERT_EQ(answers[k].is_hit, is_hit);
        if (is_hit) {
          ASSERT_GE(answers[k].t, question.t_range[0]);
          ASSERT_LE(answers[k].t, question.t_range[1]);
        }
        ++counts.known_of_any;
      }
    }
  }

  test::Choices any_;
};

// TESSERA_LONG: fifty times as many.
int round_count() { return std::getenv("TESSERA_LONG") != nullptr ? 200000 : 4000; }

// Nets from flat to wild, which fold over themselves. A fifth of the rays are aimed at borders, a
// quarter along the surface: of others nearly all is known.
TEST(PatchFilter, AnswersOfBentPatchesAreTheCompleteSolvers) {
  struct Class {
    float bend, shear;
    double least_known;
  };
  for (const Class& of : {Class{0.01f, 0.02f, 0.7}, Class{0.2f, 0.1f, 0.65}, Class{1, 0.5f, 0.55},
                          Class{2, 2, 0.5}}) {
    SCOPED_TRACE(of.bend);
    Asker asker(91);
    Counts counts;
    for (int round = 0; round < round_count() && !testing::Test::HasFatalFailure(); ++round) {
      const float size = asker.any().power(-4, 4), shift = size * asker.any().sign() * 10;
      std::vector<CheckedPatch> patches = {bent_patch(asker.any(), of.bend, of.shear)};
      patches = test::moved(patches, size, shift);
      for (CheckedPatch& patch : patches) set_extent(patch);
      PatchSplitting splitting;
      splitting.radius = double{asker.any().power(-1, 1)};
      splitting.level_max = static_cast<int>(asker.any().below(6));
      const test::PatchScene scene(patches, splitting);
      asker.ask(scene, asker.any().power(0, 3), size, counts);
    }
    EXPECT_GT(counts.hits, counts.asked / 4);
    EXPECT_GT(counts.known(), of.least_known);
    // Of all rays but those of mixed batches, a quarter.
    EXPECT_GT(static_cast<double>(counts.known_of_any),
              0.75 * of.least_known * static_cast<double>(counts.asked));
    RecordProperty("known", std::to_string(counts.known()));
  }
}

}  // namespace
}  // namespace tessera::core
