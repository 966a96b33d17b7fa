// SPDX-License-Identifier: Apache-2.0
#include "tests/support/patch_shapes.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <functional>
#include <iostream>

#include "common/math/vec3d.h"
#include "master/loader/builtin_teapot_data.h"

namespace tessera::test {
namespace {

using core::CheckedPatch;

// Shape: numbers as PatchInput has them.
CheckedPatch made(int degree_u, int degree_v, bool is_rational, const std::vector<float>& numbers) {
  return core::checked_patch({degree_u, degree_v, is_rational, numbers}).value();
}

// A quarter of a circle has the weights 1, c, 1 with c the cosine of 45 degrees. Weights of float32
// are the exact problem, so these shapes are round to some 2^-25 only.
struct ArcPoint {
  float x, y, w;
};
ArcPoint arc_point(int quarter, int i) {
  constexpr float kX[4] = {1, 0, -1, 0}, kY[4] = {0, 1, 0, -1};
  const int a = quarter & 3, b = (quarter + 1) & 3;
  if (i == 0) return {kX[a], kY[a], 1};
  if (i == 2) return {kX[b], kY[b], 1};
  return {kX[a] + kX[b], kY[a] + kY[b], std::sqrt(0.5f)};
}

// Quarters first to last - 1 of a circle of the radius around (ring, 0), turned about the z axis.
std::vector<CheckedPatch> revolved(float ring, float radius, int first, int last) {
  std::vector<CheckedPatch> patches;
  for (int q = 0; q < 4; ++q)
    for (int p = first; p < last; ++p) {
      std::vector<float> numbers;
      for (int i = 0; i <= 2; ++i)
        for (int j = 0; j <= 2; ++j) {
          const ArcPoint turn = arc_point(q, i), arc = arc_point(p, j);
          const float r = ring + radius * arc.x;
          numbers.insert(numbers.end(), {r * turn.x, r * turn.y, radius * arc.y, turn.w * arc.w});
        }
      patches.push_back(made(2, 2, true, numbers));
    }
  return patches;
}

// Mantle and discs, whose middles are collapsed borders.
std::vector<CheckedPatch> turned(float top_radius) {
  std::vector<CheckedPatch> patches;
  const auto ring = [&](int q, float r0, float z0, float r1, float z1) {
    std::vector<float> numbers;
    for (int i = 0; i <= 2; ++i) {
      const ArcPoint turn = arc_point(q, i);
      numbers.insert(numbers.end(), {r0 * turn.x, r0 * turn.y, z0, turn.w});
      numbers.insert(numbers.end(), {r1 * turn.x, r1 * turn.y, z1, turn.w});
    }
    patches.push_back(made(2, 1, true, numbers));
  };
  for (int q = 0; q < 4; ++q) {
    ring(q, 1, -1, top_radius, 1);
    ring(q, 0, -1, 1, -1);
    if (top_radius > 0) ring(q, top_radius, 1, 0, 1);
  }
  return patches;
}

std::vector<CheckedPatch> teapot() {
  std::vector<CheckedPatch> patches;
  for (const auto& indices : master::kTeapotPatches) {
    std::vector<float> numbers;
    for (const std::uint16_t index : indices)
      numbers.insert(numbers.end(), std::begin(master::kTeapotPoints[index]),
                     std::end(master::kTeapotPoints[index]));
    patches.push_back(made(3, 3, false, numbers));
  }
  return patches;
}

std::vector<CheckedPatch> one(int m, int n, const std::function<Vec3f(float, float)>& point) {
  std::vector<float> numbers;
  for (int i = 0; i <= m; ++i)
    for (int j = 0; j <= n; ++j) {
      const Vec3f p = point(static_cast<float>(i), static_cast<float>(j));
      numbers.insert(numbers.end(), {p.x, p.y, p.z});
    }
  return {made(m, n, false, numbers)};
}

// A hilly sheet whose weights are powers of two from 2^-most to 2^most.
std::vector<CheckedPatch> weighted(int m, int n, int most) {
  std::vector<float> numbers;
  for (int i = 0; i <= m; ++i)
    for (int j = 0; j <= n; ++j) {
      const float x = static_cast<float>(i) / static_cast<float>(m);
      const float y = static_cast<float>(j) / static_cast<float>(n);
      const int exponent = (5 * i + 7 * j + 3 * i * j) % (2 * most + 1) - most;
      numbers.insert(numbers.end(),
                     {x, y, 0.4f * std::sin(9 * x + 5 * y), std::ldexp(1.0f, exponent)});
    }
  return {made(m, n, true, numbers)};
}

float picked(std::initializer_list<float> values, float i) {
  return values.begin()[static_cast<std::size_t>(i)];
}

}  // namespace

std::vector<CheckedPatch> patch_shape(const std::string& name) {
  if (name == "sphere") return revolved(0, 1, -1, 1);
  if (name == "torus") return revolved(1, kTubeRadius, 0, 4);
  if (name == "cylinder") return turned(1);
  if (name == "cone") return turned(0);
  if (name == "teapot") return teapot();
  if (name == "plane") return one(1, 1, [](float i, float j) { return Vec3f{i, j, 0.25f}; });
  if (name == "plane33")
    return one(3, 3, [](float i, float j) { return Vec3f{i / 3, j / 3, 0.25f}; });
  if (name == "cusp")
    return one(3, 3, [](float i, float j) {
      return Vec3f{picked({0, 1, 0, 1}, i), j / 3, picked({0, 1, 1, 0}, i)};
    });
  if (name == "fold")
    return one(3, 3, [](float i, float j) {
      return Vec3f{i / 3, j / 3, picked({0, 3, -3, 0}, i)};
    });
  if (name == "sheets")
    return one(3, 2, [](float i, float j) {
      return Vec3f{picked({0, 2, -1, 1}, i), j / 2, i / 3};
    });
  if (name == "degree15x9")
    return one(15, 9, [](float i, float j) {
      return Vec3f{i / 15, j / 9, 0.3f * std::sin(1.7f * i) * std::cos(1.1f * j)};
    });
  if (name == "weights") return weighted(3, 3, 6);
  if (name == "weights4x5") return weighted(4, 5, 1);
  std::cerr << "no shape " << name << "\n";
  std::abort();
}

std::vector<CheckedPatch> moved(const std::vector<CheckedPatch>& patches, float scale,
                                float shift) {
  std::vector<CheckedPatch> result;
  for (const CheckedPatch& patch : patches) {
    std::vector<float> numbers = patch.numbers;
    for (std::size_t k = 0; k < numbers.size(); ++k) {
      if (!patch.is_rational || k % 4 != 3) numbers[k] = scale * numbers[k] + shift;
    }
    result.push_back(made(patch.degree_u, patch.degree_v, patch.is_rational, numbers));
  }
  return result;
}

PatchScene::PatchScene(std::vector<CheckedPatch> patches, const core::PatchSplitting& splitting)
    : patches_(std::move(patches)) {
  for (std::size_t p = 0; p < patches_.size(); ++p) {
    PatchParts of{{}, parts_.parts.size(), 0};
    core::split_patch(patch(p), static_cast<std::uint32_t>(p), splitting, parts_);
    of.end = parts_.parts.size();
    for (std::size_t k = of.first; k < of.end; ++k) of.box.grow(parts_.boxes[k]);
    of_patches_.push_back(of);
    bounds_.grow(of.box);
  }
}

PatchScene::Hit PatchScene::trace(const core::PatchRay& ray, core::CompleteSolver& solver) {
  Hit best;
  double t_max = double{ray.t_max};
  bool is_open = false;
  for (std::size_t p = 0; p < patches_.size(); ++p) {
    const PatchParts& of = of_patches_[p];
    if (!passes(ray, of.box, 0, t_max)) continue;
    for (std::size_t k = of.first; k < of.end; ++k) {
      if (!passes(ray, parts_.boxes[k], 0, t_max)) continue;
      core::PatchWay way{};
      const core::PatchHit hit = core::patch_hit(patch(p), parts_.parts[k], ray, solver, &way);
      is_open = is_open || way == core::PatchWay::kCompleteSolver;
      if (!hit.is_hit || (best.is_hit && !(hit.t < best.t))) continue;
      static_cast<core::PatchHit&>(best) = hit;
      best.patch = static_cast<std::uint32_t>(p);
      best.part = static_cast<std::uint32_t>(k);
      t_max = hit.t;
    }
  }
  ++ray_count_;
  open_ray_count_ += is_open;
  return best;
}

// In double, with a factor for its roundings: t is off by 2^-50 of itself.
bool passes(const core::PatchRay& ray, const Bounds3f& box, double slack, double t_max) {
  double near = double{ray.t_min}, far = t_max;
  for (int a = 0; a < 3; ++a) {
    const double o = double{ray.origin[a]}, d = double{ray.direction[a]};
    const double low = double{box.lower[a]} - slack - o, high = double{box.upper[a]} + slack - o;
    if (d == 0) {
      if (low > 0 || high < 0) return false;
      continue;
    }
    const double x = low / d, y = high / d;
    const double first = std::min(x, y), last = std::max(x, y);
    near = std::max(near, first - 0x1p-40 * std::fabs(first));
    far = std::min(far, last + 0x1p-40 * std::fabs(last));
  }
  return near <= far * (1 + 0x1p-40);
}

}  // namespace tessera::test
