#include <gtest/gtest.h>

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
                "newmtl lamp\nKd 0.5 0.25 2\nKe 3 2 1\nnewmtl floor\nmap_Kd -s 1 1 1 maps\\a.png\n"
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

// The last material of an MTL file with these lines.
class MtlLines : public ObjReader {
 protected:
  ReadScene read_lines(const std::string& lines) {
    folder_.write("a.mtl", "newmtl m\n" + lines);
    return good("mtllib a.mtl\n" + kQuad + "usemtl m\nf 1 2 3\n");
  }
  Material material(const std::string& lines) {
    const ReadScene read = read_lines(lines);
    EXPECT_TRUE(read.warnings.empty()) << read.warnings[0];
    return read.scene.materials.back();
  }
};

TEST_F(MtlLines, MirrorGlassAndGlossInAnyOrderOfTheirLines) {
  EXPECT_EQ(material("Kd 0.5 0.5 0.5\nillum 2\nKs 0 0 0\nNs 10\nNi 1.5\nd 1\n").bsdf,
            BsdfKind::kDiffuse);
  const Material mirror = material("illum 3\nNs 1000\nKs 0.9 0.8 0.7\nKd 0 0 0\n");
  EXPECT_EQ(mirror.bsdf, BsdfKind::kMirror);
  EXPECT_EQ(mirror.specular, (Vec3f{0.9f, 0.8f, 0.7f}));
  const Material glass = material("Ni 1.7\nKs 0.3 0.3 0.3\nNs 200\nillum 7\n");
  EXPECT_EQ(glass.bsdf, BsdfKind::kGlass);
  EXPECT_EQ(glass.ior, 1.7f);
  EXPECT_EQ(glass.specular, (Vec3f{1, 1, 1}));
  const Material dim = material("illum 7\nTf 0.25 0.25 1\nd 0.5\nNi 1.3\n");
  EXPECT_EQ(dim.specular, (Vec3f{0.5f, 0.5f, 1}));
  EXPECT_EQ(material("d 0.5\nNi 1.3\n").bsdf, BsdfKind::kGlass);
  EXPECT_EQ(material("d 0.5\n").bsdf, BsdfKind::kDiffuse);
  const Material gloss = material("Ns 30\nillum 2\nKs 0.5 0.25 0.125\n");
  EXPECT_EQ(gloss.bsdf, BsdfKind::kGlossy);
  EXPECT_EQ(gloss.specular, (Vec3f{0.5f, 0.25f, 0.125f}));
  EXPECT_NEAR(gloss.roughness, 0.5, 1e-6);  // alpha = sqrt(2 / 32) = 1/4
  EXPECT_EQ(gloss.metalness, 0);
  EXPECT_EQ(material("Ns 30\nillum 1\nKs 0.5 0.25 0.125\n").bsdf, BsdfKind::kDiffuse);
  const Material metal = material("Pm 1\nPr 0.25\nKd 1 0.5 0\nKs 0.9 0.9 0.9\n");
  EXPECT_EQ(metal.bsdf, BsdfKind::kGlossy);
  EXPECT_EQ(metal.metalness, 1);
  EXPECT_EQ(metal.roughness, 0.25f);
  EXPECT_EQ(metal.specular, Material{}.specular);
}

TEST_F(MtlLines, SurfaceProgramsStandInComments) {
  const Material marble =
      material("# a comment\n# tessera surface marble vein 0.1 0.2 0.3 frequency 7\n");
  EXPECT_EQ(marble.surface.kind, SurfaceKind::kMarble);
  EXPECT_EQ(marble.surface.parameters, (SurfaceParameters{7, 3, 0.1f, 0.2f, 0.3f}));
  EXPECT_EQ(material("# tessera surface wood\n").surface.kind, SurfaceKind::kWood);
  EXPECT_EQ(material("# tessera surface brick width 2\n").surface.parameters[0], 2);
}

TEST_F(MtlLines, WhatIsNotUnderstoodIsOneWarningForEachName) {
  const struct {
    const char* lines;
    std::size_t warnings;
  } cases[] = {{"Strange 1\nStrange 2\nnewmtl n\nStrange 3\n", 1},
               {"# tessera surface granite\nnewmtl n\n# tessera surface granite\n", 1},
               {"# tessera surface wood knots 3 frequency 2\n", 1},
               {"# tessera surface wood frequency -2\n", 1},
               {"# tessera surface marble vein 0.1 0.2\n", 1},
               {"# tessera lights 3\n", 1},
               {"# tesserae are stones\n", 0},
               {"illum 4\nnewmtl n\nillum 4\n", 1},
               {"Ks -1 0 0\nNs nan\nd x\n", 3}};
  for (const auto& c : cases) {
    EXPECT_EQ(read_lines(c.lines).warnings.size(), c.warnings) << c.lines;
  }
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
