// SPDX-License-Identifier: Apache-2.0
// Freeform surfaces for tests: a small trimmed one, a scene with it, and random ones.
// Threads. Pure functions.
#pragma once

#include <cmath>
#include <memory>
#include <random>

#include "tests/support/small_scene.h"

namespace tessera::test {

// A bicubic patch; and a rational one of degrees 2 and 1 with two loops: a triangle of lines, and
// two segments, a parabola and a cubic, that close each other. Widths of all five segments.
inline PatchSurface make_trimmed_surface() {
  PatchSurface surface;
  surface.patches = {{3, 3, 0, 0}, {2, 1, 1, 1}};
  for (int i = 0; i < 4; ++i) {
    for (int j = 0; j < 4; ++j) {
      const auto x = static_cast<float>(i), y = static_cast<float>(j);
      surface.numbers.insert(surface.numbers.end(), {x, y, 0.25f * (x - y)});
    }
  }
  surface.numbers.insert(surface.numbers.end(), {1, 0, 4, 1,    1, 0, 5, 1,    1, 1, 4, 0.75f,  //
                                                 1, 1, 5, 0.5f, 0, 1, 4, 1.5f, 0, 1, 5, 2});
  surface.materials = {0, 2};
  surface.loop_counts = {0, 2};
  surface.segment_counts = {3, 2};
  surface.degrees = {1, 1, 1, 2, 3};
  surface.trim_points = {{0, 0, 1},        {1, 0, 1},           {0.5f, 1, 1},
                         {0.25f, 0.5f, 1}, {0.5f, 0.75f, 0.5f}, {0.75f, 0.5f, 1},
                         {0.5f, 0.25f, 2}, {0.375f, 0.25f, 1}};
  surface.trim_widths = {0, 0.001f, 0, 0.5f, 0};
  return surface;
}

// The small scene with two surfaces, of which the trimmed one stands twice.
inline Scene make_surface_scene() {
  Scene scene = make_small_scene();
  PatchSurface plain;
  plain.patches = {{1, 1, 0, 0}};
  plain.numbers = {0, 0, 0, 0, 1, 0, 1, 0, 0, 1, 1, 1};
  plain.materials = {1};
  scene.surfaces = {std::make_shared<const PatchSurface>(make_trimmed_surface()),
                    std::make_shared<const PatchSurface>(std::move(plain))};
  const Transform turned = scene.instances[1].object_to_world;
  scene.instances.push_back({1, {}, ObjectKind::kPatchSurface});
  scene.instances.push_back({0, turned, ObjectKind::kPatchSurface});
  scene.instances.push_back({0, {}, ObjectKind::kPatchSurface});
  return scene;
}

// Any valid surface of up to `patch_count` patches and one material: degrees of all sizes, rational
// or not, trimmed or not.
inline PatchSurface make_random_surface(std::mt19937& random, int patch_count) {
  std::uniform_int_distribution<int> degree(1, kPatchDegreesMax), coin(0, 1);
  std::uniform_real_distribution<float> unit(0, 1), place(-100, 100), exponent(-6, 6);
  const auto small = [&](int last) { return std::uniform_int_distribution<int>(0, last)(random); };
  const auto byte = [](int value) { return static_cast<std::uint8_t>(value); };
  PatchSurface surface;
  surface.materials = {0};
  const bool is_trimmed = coin(random) == 1, has_widths = coin(random) == 1;
  for (int n = 1 + small(patch_count - 1); n > 0; --n) {
    const PatchForm form{byte(degree(random)), byte(degree(random)), byte(coin(random)),
                         byte(coin(random))};
    surface.patches.push_back(form);
    for (std::size_t i = 0; i < form.point_count(); ++i) {
      for (int axis = 0; axis < 3; ++axis) surface.numbers.push_back(place(random));
      if (form.is_rational != 0) surface.numbers.push_back(std::exp2(exponent(random)));
    }
    if (!is_trimmed) continue;
    const int loop_count = small(3);
    surface.loop_counts.push_back(static_cast<std::uint32_t>(loop_count));
    for (int loop = 0; loop < loop_count; ++loop) {
      const int segment_count = 2 + small(4);
      surface.segment_counts.push_back(static_cast<std::uint32_t>(segment_count));
      for (int segment = 0; segment < segment_count; ++segment) {
        surface.degrees.push_back(byte(degree(random)));
        for (int i = 0; i < surface.degrees.back(); ++i)
          surface.trim_points.push_back({unit(random), unit(random), std::exp2(exponent(random))});
        if (has_widths) surface.trim_widths.push_back(unit(random));
      }
    }
  }
  return surface;
}

}  // namespace tessera::test
