// SPDX-License-Identifier: Apache-2.0
// Names, colours and places of assemblies within assemblies, and what is sewn, in files that the
// test writes.
#include <gtest/gtest.h>
#include <BRepBuilderAPI_MakeFace.hxx>
#include <gp_Pln.hxx>

#include <algorithm>
#include <cmath>

#include "common/scene/validate.h"
#include "master/import/cad/reader.h"
#include "tests/support/temp_folder.h"
#include "tests/support/written_cad.h"

namespace tessera::import::cad {
namespace {

Result<ReadScene> read_text(const std::string& name, const std::string& text,
                            std::vector<PartReport>* reports = nullptr) {
  const test::TempFolder folder;
  return read_cad(folder.write(name, text), reports);
}

TEST(CadAssembly, NestedAssembliesAreInstancesWithNamesAndColours) {
  const std::string text = test::step_text(test::tray());
  ASSERT_FALSE(text.empty());
  const auto read = read_text("tray.step", text);
  ASSERT_TRUE(read.is_ok()) << read.status().message();
  const Scene& scene = read->scene;
  ASSERT_TRUE(validate_scene(scene).is_ok());
  ASSERT_EQ(scene.surfaces.size(), 2u);   // board and peg, each once
  ASSERT_EQ(scene.instances.size(), 5u);  // board and four pegs
  const auto material = [&](const char* name, float red, float blue) {
    return std::ranges::count_if(scene.materials, [&](const Material& m) {
      return m.name == name && m.albedo.x == red && m.albedo.z == blue;
    });
  };
  EXPECT_EQ(scene.materials.size(), 3u);
  EXPECT_EQ(material("peg", 1, 0), 1);
  EXPECT_EQ(material("peg", 0, 1), 1);  // one face has a colour of its own
  EXPECT_EQ(material("board", Material().albedo.x, Material().albedo.z), 1);

  const auto peg = std::ranges::find_if(
      scene.surfaces, [](const auto& s) { return s->materials.size() == s->patches.size(); });
  ASSERT_NE(peg, scene.surfaces.end());
  EXPECT_EQ(std::ranges::count((*peg)->materials, (*peg)->materials[2]), 1);
  // The file's +z is up: +y. Its x and y are x and -z.
  const auto number = static_cast<std::uint32_t>(peg - scene.surfaces.begin());
  std::vector<Vec3f> corners;
  for (const Instance& instance : scene.instances)
    if (instance.mesh == number) corners.push_back(instance.object_to_world.point({1, 2, 3}));
  const Vec3f expected[] = {{6, 4, -2}, {6, 4, -12}, {48, 4, -1}, {38, 4, -1}};
  ASSERT_EQ(corners.size(), 4u);
  for (const Vec3f& e : expected) {
    EXPECT_EQ(std::ranges::count_if(corners, [&](Vec3f c) { return length(c - e) < 1e-5f; }), 1)
        << e.x << " " << e.y << " " << e.z;
  }
}

// Two unit squares, `gap` apart.
std::string two_squares(double gap, double resolution) {
  const gp_Pln plane;
  return test::iges_text({BRepBuilderAPI_MakeFace(plane, 0, 1, 0, 1).Shape(),
                          BRepBuilderAPI_MakeFace(plane, 1 + gap, 2, 0, 1).Shape()},
                         resolution);
}

TEST(CadAssembly, LooseFacesAreSewnWithinTheStatedBound) {
  struct Case {
    double gap, resolution;
    std::size_t shared;
  };
  // The diagonal is 2.24: sewn within 2.2e-5 always, within 2.2e-4 where the file says as much.
  for (const Case& c : {Case{1.5e-5, 1e-7, 1}, Case{1.5e-4, 1e-7, 0}, Case{1.5e-4, 1e-3, 1},
                        Case{5e-4, 1e-3, 0}, Case{5e-4, 10, 0}}) {
    const std::string text = two_squares(c.gap, c.resolution);
    ASSERT_FALSE(text.empty());
    std::vector<PartReport> reports;
    const auto read = read_text("squares.igs", text, &reports);
    ASSERT_TRUE(read.is_ok()) << read.status().message();
    std::size_t shared = 0;
    double gap = 0;
    for (const PartReport& report : reports)
      shared += report.shared_edges, gap = std::max(gap, report.gap_max);
    EXPECT_EQ(shared, c.shared) << c.gap << " " << c.resolution;
    if (c.shared > 0) {
      EXPECT_NEAR(gap, c.gap, 0.01 * c.gap);
    }
    const bool is_said = std::ranges::any_of(read->warnings, [](const std::string& line) {
      return line.find("2 loose faces were sewn at 1 edge") != line.npos;
    });
    EXPECT_EQ(is_said, c.shared > 0) << read->warnings.back();
  }
}

}  // namespace
}  // namespace tessera::import::cad
