// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <cmath>

#include "common/scene/validate.h"
#include "common/scene_io/scene_reader.h"
#include "tests/support/temp_folder.h"

namespace tessera {
namespace {

const std::string kQuad = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n";

class ObjReader : public ::testing::Test {
 protected:
  Result<ReadScene> read(const std::string& text, const TextureLoader& load = {}) {
    return read_obj(folder_.write("a.obj", text), load);
  }
  ReadScene good(const std::string& text, const TextureLoader& load = {}) {
    auto scene = read(text, load);
    EXPECT_TRUE(scene.is_ok()) << scene.status().message();
    if (!scene.is_ok()) return {};
    EXPECT_TRUE(validate_scene(scene->scene).is_ok());
    return std::move(*scene);
  }
  const test::TempFolder folder_;
};

TEST_F(ObjReader, PolygonsAreFannedInTheOrderOfTheFile) {
  const ReadScene read = good(kQuad + "f 4 1 2\nf 1 2 3 4\nf -4 -3 -2\n");
  const Mesh& mesh = *read.scene.meshes.at(0);
  ASSERT_EQ(mesh.triangles.size(), 4u);
  const Vec3f corners[4][3] = {{{0, 1, 0}, {0, 0, 0}, {1, 0, 0}},
                               {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}},
                               {{0, 0, 0}, {1, 1, 0}, {0, 1, 0}},
                               {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}}};
  for (std::size_t t = 0; t < 4; ++t) {
    for (std::size_t k = 0; k < 3; ++k) {
      EXPECT_EQ(mesh.positions[mesh.triangles[t][k]], corners[t][k]) << t << "," << k;
    }
  }
}

// Twice the area of the triangles of a mesh in the plane z = 0, which must all turn the same way.
float area_of(const Mesh& mesh) {
  float sum = 0;
  for (const auto& [a, b, c] : mesh.triangles) {
    const float twice =
        cross(mesh.positions[b] - mesh.positions[a], mesh.positions[c] - mesh.positions[a]).z;
    EXPECT_GE(twice, 0);
    sum += twice;
  }
  return sum;
}

TEST_F(ObjReader, ConcavePolygonsAreCutIntoAsManyTrianglesAsTheyWouldBeFanned) {
  // An L, of area 3, whose first corner does not see all others.
  const std::string corners = "v 2 1 0\nv 1 1 0\nv 1 2 0\nv 0 2 0\nv 0 0 0\nv 2 0 0\n";
  const ReadScene read = good(corners + "f 1 2 3 4 5 6\nf 5 6 1\n");
  Mesh mesh = *read.scene.meshes.at(0);
  ASSERT_EQ(mesh.triangles.size(), 5u);
  EXPECT_EQ(mesh.positions[mesh.triangles[4][0]], (Vec3f{0, 0, 0})) << "numbers behind it stay";
  mesh.triangles.pop_back();
  EXPECT_EQ(area_of(mesh), 6);
  EXPECT_TRUE(read.warnings.empty()) << read.warnings[0];
  const ReadScene crossed = good("v 0 0 0\nv 2 2 0\nv 2 0 0\nv 0 3 0\nf 1 2 3 4\n");
  EXPECT_EQ(crossed.scene.triangle_count(), 2u);
  ASSERT_EQ(crossed.warnings.size(), 1u);
  EXPECT_NE(crossed.warnings[0].find("line 5"), std::string::npos) << crossed.warnings[0];
}

TEST_F(ObjReader, VertexColoursAreLinearised) {
  const ReadScene read =
      good("v 0 0 0\nv 1 0 0 0.5 0 1\nv 1 1 0 1 0.25 0.5 2\nv 0 1 0 nan 0 0\nf 1 2 3\nf 1 3 4\n");
  const Mesh& mesh = *read.scene.meshes.at(0);
  ASSERT_EQ(mesh.colors.size(), mesh.positions.size());
  EXPECT_EQ(mesh.colors[mesh.triangles[0][0]], (Vec4f{1, 1, 1, 1})) << "has none of its own";
  EXPECT_NEAR(mesh.colors[mesh.triangles[0][1]].x, 0.21404, 1e-4);  // sRGB of IEC 61966-2-1
  EXPECT_EQ(mesh.colors[mesh.triangles[0][1]].z, 1);
  // In x y z w r g b the weight is no colour, and components above 1 become 1.
  EXPECT_EQ(mesh.colors[mesh.triangles[0][2]].z, 1);
  EXPECT_NEAR(mesh.colors[mesh.triangles[0][2]].x, 0.05088, 1e-4);
  ASSERT_EQ(read.warnings.size(), 1u);
  EXPECT_NE(read.warnings[0].find("line 4: the colour of vertex 4"), std::string::npos)
      << read.warnings[0];
  EXPECT_TRUE(good(kQuad + "f 1 2 3\n").scene.meshes.at(0)->colors.empty());
}

TEST_F(ObjReader, SmoothingGroupsShareNormalsWithinThemselvesOnly) {
  // A roof with the ridge 1 2, whose sides are first one smoothing group, then two.
  const std::string roof = "v 0 1 0\nv 0 1 2\nv 1 0 0\nv 1 0 2\nv -1 0 0\nv -1 0 2\n";
  const Mesh round = *good(roof + "s 1\nf 1 2 4 3\nf 2 1 5 6\n").scene.meshes.at(0);
  const Vec3f ridge = round.normals.at(round.triangles[0][0]);
  EXPECT_NEAR(ridge.y, 1, 1e-6) << "the mean of both sides";
  EXPECT_EQ(round.positions.size(), 6u);
  const Mesh sharp = *good(roof + "s 1\nf 1 2 4 3\ns 2\nf 2 1 5 6\n").scene.meshes.at(0);
  EXPECT_NEAR(sharp.normals.at(sharp.triangles[0][0]).y, std::sqrt(0.5), 1e-6);
  EXPECT_TRUE(good(roof + "s off\nf 1 2 4 3\n").scene.meshes.at(0)->normals.empty());
  const Mesh given = *good(roof + "vn 0 0 1\ns 1\nf 1//1 2//1 4//1\n").scene.meshes.at(0);
  EXPECT_EQ(given.normals.at(0), (Vec3f{0, 0, 1})) << "normals of the file count";
}

TEST_F(ObjReader, SeveralMaterialFilesOnOneLine) {
  folder_.write("a.mtl", "newmtl red\nKd 1 0 0\n");
  folder_.write("b c.mtl", "newmtl blue\nKd 0 0 1\n");
  folder_.write("b.mtl", "newmtl blue\nKd 0 0 1\n");
  for (const char* line : {"mtllib a.mtl b.mtl\n", "mtllib a.mtl\nmtllib b c.mtl\n"}) {
    const ReadScene read = good(line + kQuad + "usemtl red\nf 1 2 3\nusemtl blue\nf 1 3 4\n");
    EXPECT_TRUE(read.warnings.empty()) << line << read.warnings[0];
  }
}

TEST_F(ObjReader, CornersWithTheirOwnUvsAndNormals) {
  const ReadScene read =
      good(kQuad + "vt 0 0\nvt 1 0\nvt 1 1\nvn 0 0 1\nf 1/1/1 2/2/1 3/3/1\nf 1//1 3//1 4//1\n");
  const Mesh& mesh = *read.scene.meshes.at(0);
  ASSERT_EQ(mesh.uvs.size(), mesh.positions.size());
  ASSERT_EQ(mesh.normals.size(), mesh.positions.size());
  EXPECT_EQ(mesh.uvs[mesh.triangles[0][2]], (Vec2f{1, 1}));
  EXPECT_EQ(mesh.normals[mesh.triangles[1][0]], (Vec3f{0, 0, 1}));
}

TEST_F(ObjReader, MaterialsWithColoursEmissionAndTextures) {
  folder_.write("a.mtl",
                "newmtl lamp\nKd 0.5 0.25 1\nKe 3 2 1\nnewmtl floor\nmap_Kd -s 1 1 1 maps\\a.png\n"
                "newmtl grey\nKd 0.3\nd 1\nillum 2\n");
  int loads = 0;
  const auto load = [&](const std::string& name) -> Result<std::shared_ptr<const Texture>> {
    ++loads;
    EXPECT_EQ(name, "maps/a.png");
    auto texture = std::make_shared<Texture>();
    texture->width_px = texture->height_px = 1;
    texture->rgba = {1, 2, 3, 255};
    return std::shared_ptr<const Texture>(texture);
  };
  const ReadScene read =
      good("mtllib a.mtl\n" + kQuad +
               "usemtl floor\nf 1 2 3\nusemtl lamp\nf 1 3 4\nusemtl gone\nf 2 3 4\n",
           load);
  const Scene& scene = read.scene;
  const Mesh& mesh = *scene.meshes.at(0);
  EXPECT_EQ(loads, 1);
  const Material& lamp = scene.materials.at(mesh.materials.at(1));
  EXPECT_EQ(lamp.albedo, (Vec3f{0.5f, 0.25f, 1}));
  EXPECT_EQ(lamp.emission, (Vec3f{3, 2, 1}));
  EXPECT_EQ(scene.materials.at(mesh.materials.at(0)).albedo_texture, 0u);
  ASSERT_EQ(read.warnings.size(), 1u);
  EXPECT_NE(read.warnings[0].find("gone"), std::string::npos) << read.warnings[0];
}

TEST_F(ObjReader, WhatIsMissingIsAWarning) {
  const ReadScene lost = good("mtllib gone.mtl\n" + kQuad + "f 1 2 3\n");
  ASSERT_FALSE(lost.warnings.empty());
  EXPECT_NE(lost.warnings[0].find("gone.mtl"), std::string::npos);
  const ReadScene outside = good("mtllib ../../etc/passwd\n" + kQuad + "f 1 2 3\n");
  ASSERT_FALSE(outside.warnings.empty());
  const ReadScene degenerate = good(kQuad + "f 1 1 2\nf 1 2 3\n");
  EXPECT_EQ(degenerate.scene.triangle_count(), 2u) << "degenerate triangles keep their number";
  EXPECT_EQ(degenerate.warnings.size(), 1u);
  const ReadScene strange = good(kQuad + "curv 1 2\ncurv 3 4\nf 1 2 3\n");
  EXPECT_EQ(strange.warnings.size(), 1u) << "one line for each word";
}

TEST_F(ObjReader, WhatCannotBeAMeshIsRefusedWithItsLine) {
  const struct {
    std::string text, said;
  } cases[] = {{kQuad + "f 1 2 9\n", ":5: vertex 9"},
               {kQuad + "f 1 2 -5\n", ":5: "},
               {kQuad + "f 0 1 2\n", ":5: "},
               {kQuad + "f 1 2\n", ":5: "},
               {kQuad + "f 1 2 x\n", ":5: "},
               {kQuad + "f 1/5 2 3\n", ":5: "},
               {"v 0 0\n", ":1: vertex 1"},
               {"v 0 0 nan\nf 1 1 1\n", ":1: vertex 1"},
               {"v 0 0 1e39\nf 1 1 1\n", ":1: vertex 1"},
               {kQuad, "no faces"},
               {"f 1 2 3\n", ":1: "}};
  for (const auto& c : cases) {
    auto scene = read(c.text);
    ASSERT_FALSE(scene.is_ok()) << c.text;
    EXPECT_NE(scene.status().message().find(c.said), std::string::npos)
        << scene.status().message() << " for " << c.text;
  }
}

TEST_F(ObjReader, ByteOrderMarksAndContinuedLines) {
  const ReadScene read = good("\xef\xbb\xbfv 0 0 0\r\nv 1 \\\r\n 0 0\nv 1 1 0\nf 1 2 \\\n3\n");
  EXPECT_EQ(read.scene.triangle_count(), 1u);
  auto wrong = this->read("v 0 0 \\\n0\nv x 0 0\n");
  ASSERT_FALSE(wrong.is_ok());
  EXPECT_NE(wrong.status().message().find(":3:"), std::string::npos) << wrong.status().message();
}

TEST_F(ObjReader, LinesAreUnderstoodHoweverTheyAreWritten) {
  const ReadScene read = good(
      "\r\n# comment\r\n  v\t0 0 0 \r\nv +1 0 0\nv 1e0 1. 0 1.0 0.5 0.5\no name\ng a b\ns off\n"
      "f  1   2 3 \n");
  EXPECT_EQ(read.scene.triangle_count(), 1u);
  EXPECT_TRUE(read.warnings.empty()) << read.warnings[0];
}

}  // namespace
}  // namespace tessera
