// SPDX-License-Identifier: Apache-2.0
#include "tests/bench/patch_scene.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "slave/core/primitive/patch/patch_evaluation.h"
#include "slave/core/primitive/patch/patch_hit.h"
#include "tests/support/patch_scene_of.h"

namespace tessera::bench {
namespace {

constexpr float kApart = 7;  // of the middles of teapots

}  // namespace

Scene teapot_field(int side) {
  Scene scene = test::patch_scene_of("teapot");
  scene.instances.clear();
  for (int y = 0; y < side; ++y)
    for (int x = 0; x < side; ++x) {
      // One by itself stands where it is; others are turned by 0, 90, 180, 270 degrees.
      constexpr float kCosine[4] = {1, 0, -1, 0}, kSine[4] = {0, 1, 0, -1};
      const int turn = side == 1 ? 0 : (x + 2 * y) % 4;
      Transform to_world;
      to_world.m[0] = {kCosine[turn], -kSine[turn], 0, kApart * static_cast<float>(x)};
      to_world.m[1] = {kSine[turn], kCosine[turn], 0, kApart * static_cast<float>(y)};
      scene.instances.push_back({0, to_world, ObjectKind::kPatchSurface});
    }
  return scene;
}

Camera camera_of_field(int side) {
  if (side == 1) return {{1.5f, -9.5f, 4.6f}, {0.1f, 0, 1.4f}, {0, 0, 1}, 34};
  const float width = kApart * static_cast<float>(side);
  return {{-0.1f * width, -0.25f * width, 0.25f * width},
          {0.5f * width, 0.45f * width, 0},
          {0, 0, 1},
          40};
}

Vec3f light_of_field(int side) {
  const float width = kApart * static_cast<float>(side);
  return {-0.5f * width, -0.6f * width, 1.3f * width};
}

core::TriangleStore tessellated(const core::PatchStore& patches, int cells,
                                std::vector<Bounds3f>& boxes) {
  std::vector<float> corners;
  const auto count = static_cast<std::size_t>(cells);
  corners.reserve(patches.patches.size() * count * count * 18);
  std::vector<Vec3f> grid((count + 1) * (count + 1));
  for (const core::Patch& patch : patches.patches) {
    for (std::size_t i = 0; i <= count; ++i)
      for (std::size_t j = 0; j <= count; ++j) {
        const auto jet =
            core::evaluate(patch, static_cast<double>(i) / cells, static_cast<double>(j) / cells);
        grid[(count + 1) * i + j] = {static_cast<float>(jet.point[0]),
                                     static_cast<float>(jet.point[1]),
                                     static_cast<float>(jet.point[2])};
      }
    for (std::size_t i = 0; i < count; ++i)
      for (std::size_t j = 0; j < count; ++j) {
        const std::size_t a = (count + 1) * i + j, b = a + count + 1;
        for (const std::size_t corner : {a, b, b + 1, a, b + 1, a + 1})
          for (int k = 0; k < 3; ++k) corners.push_back(grid[corner][k]);
      }
  }
  core::TriangleStore triangles;
  triangles.instance_first = {0, corners.size() / 9};
  triangles.keep(std::move(corners));
  boxes = core::boxes_of(triangles.vertices);
  return triangles;
}

SplinePatches splines_of(const core::PatchStore& patches) {
  // What a cubic's Bezier points weigh in the points of the B-spline that it is a segment of.
  static constexpr double kWeights[4][4] = {
      {6, -7, 2, 0}, {0, 2, -1, 0}, {0, -1, 2, 0}, {0, 2, -7, 6}};
  SplinePatches splines;
  splines.points.reserve(16 * patches.patches.size());
  for (const core::Patch& patch : patches.patches) {
    for (int i = 0; i < 4; ++i)
      for (int j = 0; j < 4; ++j) {
        double point[3] = {};
        for (int k = 0; k < 16; ++k)
          for (int a = 0; a < 3; ++a)
            point[a] += kWeights[i][k / 4] * kWeights[j][k % 4] * double{patch.numbers[3 * k + a]};
        splines.points.push_back({static_cast<float>(point[0]), static_cast<float>(point[1]),
                                  static_cast<float>(point[2])});
      }
  }
  return splines;
}

double mesh_megabytes(const core::PatchStore& patches, int cells) {
  const double vertices = (cells + 1.0) * (cells + 1.0), triangles = 2.0 * cells * cells;
  return 12e-6 * (vertices + triangles) * static_cast<double>(patches.patches.size());
}

PatchTruth::PatchTruth(const core::PatchStore& patches, const std::vector<Bounds3f>& boxes)
    : patches_(patches), boxes_(boxes) {
  for (std::size_t i = 0; i + 1 < patches.first_part.size(); ++i) {
    Bounds3f all;
    for (std::uint64_t p = patches.first_part[i]; p < patches.first_part[i + 1]; ++p)
      all.grow(boxes[p]);
    of_instances_.push_back(all);
  }
  diagonal_ = double{length(of_instances_[0].upper - of_instances_[0].lower)};
}

PatchTruth::Hit PatchTruth::trace(Vec3f origin, Vec3f direction) const {
  const core::PatchRay ray{{origin.x, origin.y, origin.z}, {direction.x, direction.y, direction.z}};
  static thread_local const auto solver = std::make_unique<core::CompleteSolver>();
  const double slack = 1e-4 * diagonal_, end = std::numeric_limits<double>::infinity();
  Hit best;
  for (std::size_t i = 0; i < of_instances_.size(); ++i) {
    if (!test::passes(ray, of_instances_[i], slack, end)) continue;
    for (std::uint64_t p = patches_.first_part[i]; p < patches_.first_part[i + 1]; ++p) {
      if (!test::passes(ray, boxes_[p], slack, end)) continue;
      const core::SubPatch& part = patches_.parts[p];
      const core::PatchHit hit = patch_hit(patches_.patches[part.patch], part, ray, *solver);
      const auto t = static_cast<float>(hit.t);
      if (!hit.is_hit || (best.is_hit && !(t < best.t))) continue;
      best = {true, t, static_cast<std::uint32_t>(p)};
    }
  }
  return best;
}

double PatchTruth::distance(std::uint32_t patch, double u, double v,
                            const double (&point)[3]) const {
  double least = std::numeric_limits<double>::infinity();
  for (int step = 0; step < 12; ++step) {
    const core::PatchJet jet = core::evaluate(patches_.patches[patch], u, v);
    double a = 0, b = 0, c = 0, f = 0, g = 0, square = 0;
    for (int k = 0; k < 3; ++k) {
      const double off = point[k] - jet.point[k];
      square += off * off;
      a += jet.du[k] * jet.du[k];
      b += jet.du[k] * jet.dv[k];
      c += jet.dv[k] * jet.dv[k];
      f += jet.du[k] * off;
      g += jet.dv[k] * off;
    }
    least = std::min(least, std::sqrt(square));
    const double determinant = a * c - b * b;
    if (!(determinant > 0)) break;
    u = std::clamp(u + (f * c - g * b) / determinant, 0.0, 1.0);
    v = std::clamp(v + (g * a - f * b) / determinant, 0.0, 1.0);
  }
  return least;
}

}  // namespace tessera::bench
