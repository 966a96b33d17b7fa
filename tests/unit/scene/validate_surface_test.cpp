// SPDX-License-Identifier: Apache-2.0
// Each rule for freeform surfaces, by the line that says so.
#include <gtest/gtest.h>

#include <functional>
#include <limits>

#include "common/base/limits.h"
#include "common/scene/validate.h"
#include "common/scene/validate_surface.h"
#include "tests/support/surface_scene.h"

namespace tessera {
namespace {

constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
constexpr float kInf = std::numeric_limits<float>::infinity();

// Returns: what is said of the scene whose trimmed surface is changed.
std::string said_of(const std::function<void(PatchSurface&)>& change) {
  Scene scene = test::make_surface_scene();
  auto surface = std::make_shared<PatchSurface>(*scene.surfaces[0]);
  change(*surface);
  scene.surfaces[0] = surface;
  return validate_scene(scene).message();
}

std::string said_of_scene(const std::function<void(Scene&)>& change) {
  Scene scene = test::make_surface_scene();
  change(scene);
  return validate_scene(scene).message();
}

TEST(ValidateSurface, TheSceneOfSurfacesIsValid) {
  const Status status = validate_scene(test::make_surface_scene());
  EXPECT_TRUE(status.is_ok()) << status.message();
  EXPECT_EQ(said_of([](PatchSurface& s) { s.materials = {1}; }), "");
  EXPECT_EQ(said_of([](PatchSurface& s) { s.trim_widths.clear(); }), "");
  EXPECT_EQ(said_of([](PatchSurface& s) { s = {{}, {}, {0}, {}, {}, {}, {}, {}}; }), "");
}

TEST(ValidateSurface, FormsAndPointsAreChecked) {
  using S = PatchSurface;
  EXPECT_EQ(said_of([](S& s) { s.patches[1].degree_u = 0; }),
            "surface 0, patch 1: degrees must lie in 1 to 15");
  EXPECT_EQ(said_of([](S& s) { s.patches[0].degree_v = 16; }),
            "surface 0, patch 0: degrees must lie in 1 to 15");
  EXPECT_EQ(said_of([](S& s) { s.patches[0].is_rational = 2; }),
            "surface 0, patch 0: its flags must be 0 or 1");
  EXPECT_EQ(said_of([](S& s) { s.patches[0].keeps_outside = 255; }),
            "surface 0, patch 0: its flags must be 0 or 1");
  EXPECT_EQ(said_of([](S& s) { s.numbers.pop_back(); }),
            "surface 0: has 71 numbers of points, but its patches take 72");
  EXPECT_EQ(said_of([](S& s) { s.numbers.push_back(0); }),
            "surface 0: has 73 numbers of points, but its patches take 72");
  EXPECT_EQ(said_of([](S& s) { s.numbers[3 * 5 + 2] = kNan; }),
            "surface 0, patch 0, point 5 is not finite");
  EXPECT_EQ(said_of([](S& s) { s.numbers[48 + 4 * 2] = -kInf; }),
            "surface 0, patch 1, point 2 is not finite");
  for (const float weight : {0.0f, -1.0f, kNan, kInf}) {
    EXPECT_EQ(said_of([=](S& s) { s.numbers[48 + 4 * 3 + 3] = weight; }),
              "surface 0, patch 1, point 3: the weight must be finite and > 0");
  }
  const auto collapse = [](S& s) {
    for (std::size_t i = 0; i < 6; ++i) {
      for (std::size_t axis = 0; axis < 3; ++axis) s.numbers[48 + 4 * i + axis] = 2;
    }
  };
  EXPECT_EQ(said_of(collapse), "surface 0, patch 1: all its points are in one place");
  EXPECT_EQ(said_of([](S& s) {
              s.materials = {0, 1, 2};
            }),
            "surface 0: needs one material, or one for each patch");
  EXPECT_EQ(said_of([](S& s) { s.materials = {}; }),
            "surface 0: needs one material, or one for each patch");
  EXPECT_EQ(said_of([](S& s) { s.materials[1] = 3; }), "surface 0: material 3 of 3");
}

// Of degree 15, so that few bytes stand for many points.
TEST(ValidateSurface, SurfacesHaveNoMorePointsOfTrimsThanPiecesCanName) {
  const auto with_segments = [](std::size_t count) {
    return said_of([count](PatchSurface& s) {
      s.loop_counts = {1, 0};
      s.segment_counts = {static_cast<std::uint32_t>(count)};
      s.degrees.assign(count, 15);
    });
  };
  const std::size_t most = (kTrimPointsMax - 1) / 15;
  EXPECT_EQ(with_segments(most), "surface 0: the points of its loops do not fit the degrees");
  EXPECT_EQ(with_segments(most + 1),
            "surface 0: more than 2^27 - 16 points and loops of its trims");
}

TEST(ValidateSurface, LoopsAreChecked) {
  using S = PatchSurface;
  EXPECT_EQ(said_of([](S& s) { s.loop_counts = {2}; }),
            "surface 0: needs a count of loops for each patch, or none");
  EXPECT_EQ(said_of([](S& s) { s.loop_counts[0] = 1; }),
            "surface 0: its loops are not as many as its patches count");
  EXPECT_EQ(said_of([](S& s) {
              s.loop_counts = {0xffffffffu, 3};
            }),
            "surface 0: its loops are not as many as its patches count")
      << "2 modulo 2^32";
  EXPECT_EQ(said_of([](S& s) { s.segment_counts[0] = 4; }),
            "surface 0: its segments are not as many as its loops count");
  EXPECT_EQ(said_of([](S& s) {
              s.segment_counts = {5, 0};
            }),
            "surface 0, patch 1, loop 1: has no segment");
  EXPECT_EQ(said_of([](S& s) { s.degrees[3] = 3; }),
            "surface 0: the points of its loops do not fit the degrees");
  EXPECT_EQ(said_of([](S& s) { s.trim_points.pop_back(); }),
            "surface 0: the points of its loops do not fit the degrees");
  const auto degree_0 = [](S& s) {
    s.degrees[3] = 0;
    s.trim_points.erase(s.trim_points.begin() + 3, s.trim_points.begin() + 5);
  };
  EXPECT_EQ(said_of(degree_0),
            "surface 0, patch 1, loop 1, segment 0: its degree must lie in 1 to 15");
  const auto degree_16 = [](S& s) {
    s.degrees[4] = 16;
    s.trim_points.resize(5 + 16, {0.5f, 0.5f, 1});
  };
  EXPECT_EQ(said_of(degree_16),
            "surface 0, patch 1, loop 1, segment 1: its degree must lie in 1 to 15");
  for (const float u : {-0.001f, 1.001f, kNan, kInf}) {
    EXPECT_EQ(said_of([=](S& s) { s.trim_points[4].u = u; }),
              "surface 0, patch 1, loop 1, point 1 lies outside [0, 1]^2");
    EXPECT_EQ(said_of([=](S& s) { s.trim_points[7].v = u; }),
              "surface 0, patch 1, loop 1, point 4 lies outside [0, 1]^2");
  }
  for (const float weight : {0.0f, -1.0f, kNan, kInf}) {
    EXPECT_EQ(said_of([=](S& s) { s.trim_points[2].weight = weight; }),
              "surface 0, patch 1, loop 0, point 2: the weight must be finite and > 0");
  }
  const auto one_place = [](S& s) {
    for (std::size_t i = 0; i < 3; ++i) s.trim_points[i] = {0.5f, 0.5f, 1};
  };
  EXPECT_EQ(said_of(one_place), "surface 0, patch 1, loop 0: all its points are in one place");
  EXPECT_EQ(said_of([](S& s) { s.trim_widths.pop_back(); }),
            "surface 0: needs a width for each segment, or none");
  for (const float width : {-0.5f, kNan, kInf}) {
    EXPECT_EQ(said_of([=](S& s) { s.trim_widths[3] = width; }),
              "surface 0, patch 1, loop 1, segment 0: its width must be finite and >= 0");
  }
}

TEST(ValidateSurface, LoopsWithoutTheirCountsAreRefused) {
  const auto said = said_of([](PatchSurface& s) { s.loop_counts.clear(); });
  EXPECT_EQ(said, "surface 0: its loops are not as many as its patches count");
}

TEST(ValidateSurface, InstancesNameWhatThereIsOfTheirKind) {
  EXPECT_EQ(said_of_scene([](Scene& s) { s.instances[3].mesh = 2; }), "instance 3: surface 2 of 2");
  EXPECT_EQ(said_of_scene([](Scene& s) { s.instances[0].mesh = 2; }), "instance 0: mesh 2 of 2");
  EXPECT_EQ(said_of_scene([](Scene& s) { s.instances[4].object_to_world.m[1][2] = kNan; }),
            "instance 4: matrix is not finite");
  EXPECT_EQ(said_of_scene([](Scene& s) { s.instances[4].kind = static_cast<ObjectKind>(2); }),
            "instance 4: is of no kind that there is");
  EXPECT_EQ(said_of_scene([](Scene& s) { s.surfaces[1] = nullptr; }), "surface 1 is missing");
  EXPECT_EQ(said_of_scene([](Scene& s) { s.surfaces.resize(kSceneBlocksMax, s.surfaces[1]); }),
            "more than 65536 meshes, surfaces and textures");
}

TEST(ValidateSurface, SumsOverInstancesAreBounded) {
  const auto with_patches = [](std::size_t patches, std::size_t instances) {
    return said_of_scene([=](Scene& s) {
      auto plane = std::make_shared<PatchSurface>(*s.surfaces[1]);
      const std::vector<float> numbers = plane->numbers;
      for (std::size_t i = 1; i < patches; ++i) {
        plane->patches.push_back(plane->patches[0]);
        plane->numbers.insert(plane->numbers.end(), numbers.begin(), numbers.end());
      }
      s.surfaces = {plane};
      s.instances.assign(instances, {0, {}, ObjectKind::kPatchSurface});
    });
  };
  EXPECT_EQ(with_patches(1 << 10, 1 << 14), "");
  EXPECT_EQ(with_patches(1 << 10, (1 << 14) + 1), "more than 2^24 patches");
  const auto with_segments = [](std::uint32_t segments, std::size_t instances) {
    return said_of_scene([=](Scene& s) {
      auto plane = std::make_shared<PatchSurface>(*s.surfaces[1]);
      plane->loop_counts = {1};
      plane->segment_counts = {segments};
      plane->degrees.assign(segments, 1);
      plane->trim_points.assign(segments, {0.5f, 0.5f, 1});
      plane->trim_points[0] = {0, 0, 1};
      s.surfaces = {plane};
      s.instances.assign(instances, {0, {}, ObjectKind::kPatchSurface});
    });
  };
  EXPECT_EQ(with_segments(1 << 16, 1 << 10), "");
  EXPECT_EQ(with_segments(1 << 16, (1 << 10) + 1), "more than 2^26 segments of loops");
}

TEST(ValidateSurface, BoundsHoldTheControlPointsOfEveryInstance) {
  Scene scene = test::make_surface_scene();
  scene.instances = {{0, {}, ObjectKind::kPatchSurface}};
  EXPECT_EQ(scene_bounds(scene).lower, (Vec3f{0, 0, -0.75f}));
  EXPECT_EQ(scene_bounds(scene).upper, (Vec3f{3, 3, 5}));
  scene.instances[0].object_to_world.m[0][3] = 10;
  EXPECT_EQ(scene_bounds(scene).upper, (Vec3f{13, 3, 5}));
  scene.instances[0].object_to_world.m[0][3] = 3e38f;
  scene.instances.push_back({0, {}, ObjectKind::kPatchSurface});
  scene.instances[1].object_to_world.m[0][3] = -3e38f;
  EXPECT_EQ(validate_scene(scene).message(), "the scene is too large: its box overflows");
}

}  // namespace
}  // namespace tessera
