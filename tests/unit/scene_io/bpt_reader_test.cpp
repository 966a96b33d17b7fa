// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <functional>

#include "common/scene/validate.h"
#include "common/scene_io/scene_reader.h"
#include "tests/support/seed.h"
#include "tests/support/surface_scene.h"
#include "tests/support/temp_folder.h"

namespace tessera {
namespace {

// A bilinear patch with weights and two loops, and a plain one of degrees 2 and 1.
const std::string kTwoPatches =
    "# two patches\n"
    "2   # so many\n"
    "1 1\n"
    "0 0 0 1\n"
    "0 1 0 0.5\n"
    "\n"
    "1 0 0 2\n"
    "1 1 0.25 1e0\n"
    "trim 2 out\n"
    "loop 4 1\n"
    "0.25 0.25\n"
    "0.75 0.25 # no weight\n"
    "0.75 0.75 1\n"
    "0.25 0.75\n"
    "loop 2\n"
    "0 0\n"
    "0 0.125\n"
    "0.125 0.125 0.5\n"
    "0.125 0\n"
    "1 0\n"
    "0 1\n"
    "2 1\n"
    "0 0 1\n"
    "0 1 1\n"
    "1 0 2\n"
    "1 1 2\r\n"
    "2 0 -1\n"
    "2 1 +1";

class BptReader : public ::testing::Test {
 protected:
  Result<ReadScene> read(const std::string& text) { return read_bpt(folder_.write("x.bpt", text)); }
  // Returns: what is said of the file, without the folder.
  std::string said(const std::string& text) {
    const auto read_file = read(text);
    if (read_file.is_ok()) return "";
    const std::string line = read_file.status().message();
    EXPECT_TRUE(line.starts_with(folder_.path() + "/")) << line;
    return line.substr(folder_.path().size() + 1);
  }
  // Like said(), of the two patches with line `number` replaced; "" leaves it out.
  std::string said_with(int number, const std::string& line) {
    std::string text;
    int at = 0;
    for (std::size_t begin = 0; begin < kTwoPatches.size();) {
      const std::size_t end = std::min(kTwoPatches.find('\n', begin), kTwoPatches.size() - 1) + 1;
      if (++at != number) text += kTwoPatches.substr(begin, end - begin);
      if (at == number && !line.empty()) text += line + "\n";
      begin = end;
    }
    return said(text);
  }

  const test::TempFolder folder_;
};

TEST_F(BptReader, PatchesWeightsAndLoopsAreRead) {
  const auto result = read(kTwoPatches);
  ASSERT_TRUE(result.is_ok()) << result.status().message();
  EXPECT_TRUE(validate_scene(result->scene).is_ok());
  EXPECT_TRUE(result->warnings.empty());
  PatchSurface expected;
  expected.patches = {{1, 1, 1, 1}, {2, 1, 0, 0}};
  expected.numbers = {0, 0, 0, 1, 0, 1, 0, 0.5f, 1, 0, 0, 2, 1, 1,  0.25f, 1, 0,
                      0, 1, 0, 1, 1, 1, 0, 2,    1, 1, 2, 2, 0, -1, 2,     1, 1};
  expected.materials = {0};
  expected.loop_counts = {2, 0};
  expected.segment_counts = {4, 2};
  expected.degrees = {1, 1, 1, 1, 3, 3};
  expected.trim_points = {
      {0.25f, 0.25f, 1}, {0.75f, 0.25f, 1},      {0.75f, 0.75f, 1}, {0.25f, 0.75f, 1}, {0, 0, 1},
      {0, 0.125f, 1},    {0.125f, 0.125f, 0.5f}, {0.125f, 0, 1},    {1, 0, 1},         {0, 1, 1}};
  ASSERT_EQ(result->scene.surfaces.size(), 1u);
  EXPECT_EQ(*result->scene.surfaces[0], expected);
  ASSERT_EQ(result->scene.instances.size(), 1u);
  EXPECT_EQ(result->scene.instances[0].kind, ObjectKind::kPatchSurface);
  EXPECT_EQ(result->scene.patch_count(), 2u);
  EXPECT_EQ(result->scene.materials.at(0).name, "default");
}

TEST_F(BptReader, FilesWithoutTrimsHaveNoLoops) {
  const auto result = read("1\n1 1\n0 0 0\n0 1 0\n1 0 0\n1 1 0\n");
  ASSERT_TRUE(result.is_ok()) << result.status().message();
  const PatchSurface& surface = *result->scene.surfaces[0];
  EXPECT_EQ(surface.patches, (std::vector<PatchForm>{{1, 1, 0, 0}}));
  EXPECT_TRUE(surface.loop_counts.empty());
  EXPECT_EQ(said("\xef\xbb\xbf"
                 "1\r\n1 1\r\n0 0 0\r\n0 1 0\r\n1 0 0\r\n1 1 0"),
            "");
}

TEST_F(BptReader, HeadsAreChecked) {
  EXPECT_EQ(said(""), "x.bpt: no patches");
  EXPECT_EQ(said("# nothing\n\n"), "x.bpt: no patches");
  EXPECT_EQ(said("0\n"), "x.bpt: no patches");
  for (const char* head : {"-1", "1.5", "many", "1 1", "99999999999999999999"}) {
    EXPECT_EQ(said("\n" + std::string(head) + "\n1 1\n"),
              "x.bpt:2: needs the number of patches, and no more");
  }
  EXPECT_EQ(said("16777217\n"), "x.bpt: more than 2^24 patches");
  EXPECT_EQ(said_with(2, "3"), "x.bpt: announces 3 patches, but only 2 follow");
  EXPECT_EQ(said_with(2, "1"), "x.bpt:22: something follows the last of 1 patches");
  EXPECT_EQ(said(kTwoPatches + "\n  end"), "x.bpt:29: something follows the last of 2 patches");
  for (const char* degrees : {"0 1", "1 0", "16 1", "1 16", "-1 3"})
    EXPECT_EQ(said_with(3, degrees), "x.bpt:3: patch 0: degrees must lie in 1 to 15");
  for (const char* degrees : {"1", "1 1 1", "1.5 1", "loop 2 1", "99999999999 1"})
    EXPECT_EQ(said_with(22, degrees), "x.bpt:22: patch 1 needs a line of two degrees");
}

TEST_F(BptReader, PointsAreChecked) {
  for (const char* point : {"0 1 0 0", "0 1 0 -2", "0 1 0 nan", "0 1 0 inf", "0 1 0 1e39"}) {
    EXPECT_EQ(said_with(5, point),
              "x.bpt:5: point 1 of patch 0: the weight must be finite and > 0");
  }
  for (const char* point : {"nan 1 0 1", "0 -inf 0 1", "0 1 1e39 1"})
    EXPECT_EQ(said_with(5, point), "x.bpt:5: point 1 of patch 0 is not finite");
  EXPECT_EQ(said_with(24, "0 x1 1"), "x.bpt:24: point 1 of patch 1: 'x1' is no number");
  EXPECT_EQ(said_with(5, "0 1 0"),
            "x.bpt:5: point 1 of patch 0: all points of a patch need weights, or none");
  EXPECT_EQ(said_with(24, "0 1 1 1"),
            "x.bpt:24: point 1 of patch 1: all points of a patch need weights, or none");
  for (const char* point : {"0 1", "0 1 0 1 0"}) {
    EXPECT_EQ(said_with(24, point),
              "x.bpt:24: point 1 of patch 1 needs three numbers, or four with a weight");
  }
  EXPECT_EQ(said_with(8, ""),
            "x.bpt:8: point 3 of patch 0 needs three numbers, or four with a weight")
      << "the trim follows a point too early";
  EXPECT_EQ(said_with(28, ""), "x.bpt:27: the file ends before point 5 of patch 1, which has 6");
  EXPECT_EQ(said("1\n1 1\n1 2 3\n1 2 3\n1 2 3\n1 2 3\n"),
            "x.bpt:6: patch 0: all its points are in one place");
}

TEST_F(BptReader, LoopsAreChecked) {
  for (const char* trim :
       {"trim", "trim 0 in", "trim -1 in", "trim 2", "trim 2 on", "trim 2 in x"}) {
    EXPECT_EQ(said_with(9, trim),
              "x.bpt:9: patch 0: trim needs a number of loops above 0, and 'in' or 'out'");
  }
  EXPECT_EQ(said_with(9, "trim 3 in"), "x.bpt:22: patch 0 announces 3 loops, but only 2 follow");
  EXPECT_EQ(said_with(9, "trim 1 in"), "x.bpt:15: patch 1 needs a line of two degrees");
  EXPECT_EQ(said_with(10, "loop 0 1"), "x.bpt:10: loop 0 of patch 0 has no segment");
  for (const char* loop : {"loop", "loop -1", "loop 4 1 1", "loop four"})
    EXPECT_EQ(said_with(10, loop), "x.bpt:10: loop 0 of patch 0 needs a number of segments");
  for (const char* loop : {"loop 4 0", "loop 4 16", "loop 4 x"})
    EXPECT_EQ(said_with(10, loop), "x.bpt:10: loop 0 of patch 0: the degree must lie in 1 to 15");
  EXPECT_EQ(said_with(10, "loop 67108865"), "x.bpt: more than 2^26 segments of loops");
  EXPECT_EQ(said_with(10, "loop 5 1"), "x.bpt:15: loop 0 of patch 0 is open: it has 4 of 5 points");
  EXPECT_EQ(said_with(14, ""), "x.bpt:14: loop 0 of patch 0 is open: it has 3 of 4 points");
  for (const char* point : {"1.0001 0", "-0.0001 0", "0 nan", "0 2", "inf 0"})
    EXPECT_EQ(said_with(12, point), "x.bpt:12: point 1 of loop 0 of patch 0 lies outside [0, 1]^2");
  for (const char* point : {"0 0 0", "0 0 -1", "0 0 nan", "0 0 inf"}) {
    EXPECT_EQ(said_with(12, point),
              "x.bpt:12: point 1 of loop 0 of patch 0: the weight must be finite and > 0");
  }
  for (const char* point : {"0", "0 x", "0 0 1 1"}) {
    EXPECT_EQ(said_with(12, point),
              "x.bpt:12: point 1 of loop 0 of patch 0 needs two numbers, or "
              "three with a weight");
  }
  EXPECT_EQ(said("1\n1 1\n0 0 0\n0 1 0\n1 0 0\n1 1 0\ntrim 1 in\nloop 2 1\n0.5 0.5\n0.5 0.5 2\n"),
            "x.bpt:10: loop 0 of patch 0: all its points are in one place");
  EXPECT_EQ(said("1\n1 1\n0 0 0\n0 1 0\n1 0 0\n1 1 0\ntrim 1 in\nloop 2 1\n0.5 0.5\n"),
            "x.bpt:9: loop 0 of patch 0 is open: it has 1 of 2 points");
}

TEST_F(BptReader, CutFilesAreRefusedInOneLine) {
  for (std::size_t bytes = 0; bytes + 1 < kTwoPatches.size(); ++bytes) {
    const std::string line = said(kTwoPatches.substr(0, bytes));
    // What ends within or behind the last number is whole.
    if (bytes + 2 < kTwoPatches.size()) {
      EXPECT_FALSE(line.empty()) << bytes;
    }
    EXPECT_EQ(line.find('\n'), std::string::npos);
  }
}

// Writes a surface as such a file; the segments of a loop have one degree.
std::string text_of(const PatchSurface& surface) {
  const auto number = [](float x) {
    char text[40];
    std::snprintf(text, sizeof(text), " %.9g", static_cast<double>(x));
    return std::string(text);
  };
  std::string text = std::to_string(surface.patches.size()) + "\n";
  for (PatchCursor at(surface); at.is_any(); at.advance()) {
    const PatchForm& form = at.form();
    text += std::to_string(form.degree_u) + " " + std::to_string(form.degree_v) + "\n";
    for (std::size_t i = 0; i < form.point_count(); ++i) {
      const Vec3f p = at.point(i);
      text += number(p.x) + number(p.y) + number(p.z);
      text += (form.is_rational != 0 ? number(at.weight(i)) : "") + "\n";
    }
    if (at.loop_count() == 0) continue;
    text += "trim " + std::to_string(at.loop_count()) + (form.keeps_outside != 0 ? " out" : " in");
    std::size_t segment = at.first_segment(), point = at.first_trim_point();
    for (std::size_t loop = 0; loop < at.loop_count(); ++loop) {
      const std::uint32_t count = surface.segment_counts[at.first_loop() + loop];
      const std::uint8_t degree = surface.degrees[segment];
      text += "\nloop " + std::to_string(count) + " " + std::to_string(degree);
      for (std::uint32_t i = 0; i < count * degree; ++i, ++point) {
        const TrimPoint& p = surface.trim_points[point];
        text += "\n" + number(p.u) + number(p.v) + number(p.weight);
      }
      segment += count;
    }
    text += "\n";
  }
  return text;
}

// A random surface as a file can have it: widths are none of its, nor loops that are not there.
PatchSurface as_a_file_has_it(PatchSurface surface) {
  PatchSurface made = surface;
  made.trim_widths.clear();
  made.degrees.clear();
  made.trim_points.clear();
  std::size_t segment = 0, point = 0;
  for (const std::uint32_t count : surface.segment_counts) {
    const std::uint8_t degree = surface.degrees[segment];
    for (std::uint32_t i = 0; i < count; ++i, point += surface.degrees[segment++]) {
      made.degrees.push_back(degree);
      for (int k = 0; k < degree; ++k) made.trim_points.push_back(surface.trim_points[point]);
    }
  }
  for (std::size_t i = 0; i < made.patches.size(); ++i) {
    if (made.loop_counts.empty() || made.loop_counts[i] == 0) made.patches[i].keeps_outside = 0;
  }
  if (made.segment_counts.empty()) made.loop_counts.clear();
  return made;
}

TEST_F(BptReader, RandomSurfacesComeBackBitByBit) {
  std::mt19937 random(test::seed(20261126));
  for (int n = 0; n < 200; ++n) {
    SCOPED_TRACE("surface " + std::to_string(n));
    const PatchSurface surface = as_a_file_has_it(test::make_random_surface(random, 5));
    const auto result = read(text_of(surface));
    ASSERT_TRUE(result.is_ok()) << result.status().message();
    EXPECT_EQ(*result->scene.surfaces[0], surface);
  }
}

TEST_F(BptReader, TheTeapotAsItIsHandedOn) {
  const char* const folder = std::getenv("TESSERA_SHARED_SCENES");
  const std::string path = std::string(folder == nullptr ? "" : folder) + "/bezier/teapot.bpt";
  if (!std::filesystem::exists(path)) GTEST_SKIP() << "shared/scenes is not beside the checkout";
  const auto result = read_bpt(path);
  ASSERT_TRUE(result.is_ok()) << result.status().message();
  EXPECT_EQ(result->scene.patch_count(), 32u);
  EXPECT_TRUE(validate_scene(result->scene).is_ok());
}

}  // namespace
}  // namespace tessera
