// SPDX-License-Identifier: Apache-2.0
// Property: points and derivatives of patches of all degrees are de Casteljau's in extended
// precision, to the roundings that are counted; parts of nets are parts of the surface; spheres,
// cylinders, cones and tori are where their equations say; what is no patch is refused.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "slave/core/primitive/patch/patch_evaluation.h"
#include "slave/core/primitive/patch/patch_net.h"
#include "tests/support/choices.h"
#include "tests/support/patch_reference.h"
#include "tests/support/patch_shapes.h"

namespace tessera {
namespace {

using core::CheckedPatch;

// Coordinates up to 1 by size, weights of 1/2 to 2.
CheckedPatch random_patch(test::Choices& any, int m, int n) {
  const bool is_rational = any.one_in(2);
  std::vector<float> numbers;
  for (int k = 0; k < (m + 1) * (n + 1); ++k) {
    for (int a = 0; a < 3; ++a) numbers.push_back(any.sign());
    if (is_rational) numbers.push_back(std::exp2(any.sign()));
  }
  return core::checked_patch({m, n, is_rational, numbers}).value();
}

// With weights of 1/2 to 2 and points up to 1, a derivative is made of terms up to 2 d 2 / (1/2) 2,
// each good to an evaluation's error; a second one of terms up to 2^2 times as much d.
double slope_error(int degree) { return 16.0 * degree * core::plain::kEvaluationError; }

TEST(PatchSurface, IsDeCasteljausToTheRoundingsCounted) {
  test::Choices any(20082);
  for (int m = 1; m <= core::kPatchDegreeMax; ++m)
    for (int n = 1; n <= core::kPatchDegreeMax; ++n) {
      const CheckedPatch owner = random_patch(any, m, n);
      for (int k = 0; k < 20; ++k) {
        const double u = any.one_in(8) ? any.below(2) : double{any.share()};
        const double v = any.one_in(8) ? any.below(2) : double{any.share()};
        const core::PatchJet jet = core::evaluate(owner.patch(), u, v);
        const test::LongJet exact = test::long_jet(owner.patch(), u, v);
        for (int a = 0; a < 3; ++a) {
          ASSERT_NEAR(jet.point[a], static_cast<double>(exact.point[a]),
                      core::plain::kEvaluationError)
              << m << " x " << n;
          ASSERT_NEAR(jet.du[a], static_cast<double>(exact.du[a]), slope_error(m));
          ASSERT_NEAR(jet.dv[a], static_cast<double>(exact.dv[a]), slope_error(n));
        }
      }
    }
}

// By central differences over 2 h of derivatives in extended precision: off by h^2 / 6 of a fourth
// derivative, which is below (16 d)^4 here, and by 2^-60 16 d / h.
TEST(PatchSurface, HasTheSecondDerivativesOfItsFirst) {
  test::Choices any(20083);
  constexpr long double kStep = 0x1p-24L;
  for (int k = 0; k < 2000; ++k) {
    const int m = 1 + static_cast<int>(any.below(core::kPatchDegreeMax));
    const int n = 1 + static_cast<int>(any.below(core::kPatchDegreeMax));
    const CheckedPatch owner = random_patch(any, m, n);
    const double u = double{any.share()}, v = double{any.share()};
    const core::PatchCurvature bend = core::second_derivatives(owner.patch(), u, v);
    const auto beside = [&](long double du, long double dv) {
      return test::long_jet(owner.patch(), u + du * kStep, v + dv * kStep);
    };
    const test::LongJet low_u = beside(-1, 0), high_u = beside(1, 0), low_v = beside(0, -1),
                        high_v = beside(0, 1);
    const double d = std::max(m, n);
    const double allowed =
        0x1p-50 * std::pow(16 * d, 4) + 0x1p-32 * d + 64 * d * d * core::plain::kEvaluationError;
    for (int a = 0; a < 3; ++a) {
      const auto slope = [](long double x, long double y) {
        return static_cast<double>((y - x) / (2 * kStep));
      };
      ASSERT_NEAR(bend.duu[a], slope(low_u.du[a], high_u.du[a]), allowed) << m << " x " << n;
      ASSERT_NEAR(bend.duv[a], slope(low_v.du[a], high_v.du[a]), allowed) << m << " x " << n;
      ASSERT_NEAR(bend.dvv[a], slope(low_v.dv[a], high_v.dv[a]), allowed) << m << " x " << n;
    }
  }
}

TEST(PatchSurface, PartsOfNetsArePartsOfIt) {
  test::Choices any(20084);
  for (int k = 0; k < 2000; ++k) {
    const int m = 1 + static_cast<int>(any.below(core::kPatchDegreeMax));
    const int n = 1 + static_cast<int>(any.below(core::kPatchDegreeMax));
    const CheckedPatch owner = random_patch(any, m, n);
    core::PatchNet net = core::net_of(m, n);
    const auto fill = [&](std::size_t component) {
      for (int i = 0; i <= m; ++i)
        for (int j = 0; j <= n; ++j)
          net.c[i][j] = core::plain::point_of(owner.patch(), (n + 1) * i + j).x[component];
    };
    const bool is_high_u = any.one_in(2), is_high_v = any.one_in(2);
    double corner[4] = {};
    for (std::size_t c = 0; c < 4; ++c) {
      fill(c);
      core::cut_u(net, 0.5, is_high_u);
      core::cut_v(net, 0.5, is_high_v);
      corner[c] = is_high_u ? (is_high_v ? net.c[0][0] : net.c[0][n])
                            : (is_high_v ? net.c[m][0] : net.c[m][n]);
    }
    const test::LongJet middle = test::long_jet(owner.patch(), 0.5L, 0.5L);
    // 30 averages of numbers up to 2, over a weight of at least 1/2.
    for (int a = 0; a < 3; ++a)
      ASSERT_NEAR(corner[a] / corner[3], static_cast<double>(middle.point[a]), 30 * 8 * 0x1p-53);
  }
}

// Weights of float32 are off by 2^-25, so radii are off by less than 2^-23.
TEST(PatchSurface, IsWhereEquationsSay) {
  constexpr double kRound = 0x1p-23;
  test::Choices any(20085);
  for (const std::string name : {"sphere", "torus", "cylinder", "cone"})
    for (const CheckedPatch& owner : test::patch_shape(name))
      for (int k = 0; k < 200; ++k) {
        const core::PatchJet jet =
            core::evaluate(owner.patch(), double{any.share()}, double{any.share()});
        const double x = jet.point[0], y = jet.point[1], z = jet.point[2], r = std::hypot(x, y);
        const bool is_disc = std::fabs(std::fabs(z) - 1) <= core::plain::kEvaluationError;
        double off = std::max(r - 1, 0.0);  // of a disc
        if (name == "sphere") off = std::hypot(r, z) - 1;
        if (name == "torus") off = std::hypot(r - 1, z) - double{test::kTubeRadius};
        if (name == "cylinder" && !is_disc) off = r - 1;
        if (name == "cone" && !is_disc) off = r - (1 - z) / 2;
        ASSERT_LE(std::fabs(off), kRound) << name;
      }
}

TEST(PatchSurface, WhatIsNoneIsRefused) {
  const std::vector<float> square = {0, 0, 0, 0, 1, 0, 1, 0, 0, 1, 1, 0};
  ASSERT_TRUE(core::checked_patch({1, 1, false, square}).is_ok());
  const auto refuses = [](int m, int n, bool is_rational, const std::vector<float>& numbers) {
    const auto result = core::checked_patch({m, n, is_rational, numbers});
    return !result.is_ok() && !result.status().message().empty();
  };
  EXPECT_TRUE(refuses(0, 1, false, square));
  EXPECT_TRUE(refuses(1, -1, false, square));
  EXPECT_TRUE(refuses(16, 1, false, std::vector<float>(17 * 2 * 3, 1)));
  EXPECT_TRUE(refuses(1, 2, false, square));
  EXPECT_TRUE(refuses(1, 1, true, square));
  EXPECT_TRUE(refuses(1, 1, false, {}));
  EXPECT_TRUE(refuses(1, 1, false, std::vector<float>(12, 3)));  // one place
  for (const float bad : {NAN, INFINITY, -INFINITY})
    for (std::size_t k = 0; k < square.size(); ++k) {
      auto numbers = square;
      numbers[k] = bad;
      EXPECT_TRUE(refuses(1, 1, false, numbers));
    }
  const std::vector<float> weighted = {0, 0, 0, 1, 0, 1, 0, 1, 1, 0, 0, 1, 1, 1, 0, 1};
  ASSERT_TRUE(core::checked_patch({1, 1, true, weighted}).is_ok());
  for (const float bad : {0.0f, -0.0f, -1.0f, NAN, INFINITY})
    for (std::size_t k = 3; k < weighted.size(); k += 4) {
      auto numbers = weighted;
      numbers[k] = bad;
      EXPECT_TRUE(refuses(1, 1, true, numbers));
    }
}

}  // namespace
}  // namespace tessera
