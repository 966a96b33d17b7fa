// SPDX-License-Identifier: Apache-2.0
// The materials that lines of an MTL file give, and the lines that warnings name.
#include <gtest/gtest.h>

#include <numbers>

#include "common/scene/validate.h"
#include "common/scene_io/scene_reader.h"
#include "common/scene_io/texels.h"
#include "tests/support/temp_folder.h"

namespace tessera {
namespace {

// A picture of one row, of 8-bit RGBA texels.
std::shared_ptr<Texture> row(std::vector<std::uint8_t> rgba) {
  auto texture = std::make_shared<Texture>();
  texture->width_px = static_cast<int>(rgba.size() / 4);
  texture->height_px = 1;
  texture->rgba = std::move(rgba);
  return texture;
}

class MtlLines : public ::testing::Test {
 protected:
  ReadScene read_lines(const std::string& lines) {
    folder_.write("a.mtl", "newmtl m\n" + lines);
    auto scene = read_obj(
        folder_.write("a.obj", "mtllib a.mtl\nv 0 0 0\nv 1 0 0\nv 1 1 0\nusemtl m\nf 1 2 3\n"),
        [this](const std::string& name) -> Result<std::shared_ptr<const Texture>> {
          ++loads_;
          const auto known = pictures_.find(name);
          if (known == pictures_.end()) return Status::not_found("no such file");
          return known->second;
        });
    EXPECT_TRUE(scene.is_ok()) << scene.status().message();
    if (!scene.is_ok()) return {};
    EXPECT_TRUE(validate_scene(scene->scene).is_ok()) << lines;
    return std::move(*scene);
  }
  // Last material of an MTL file with these lines, which must give no warning.
  Material material(const std::string& lines) {
    read_ = read_lines(lines);
    EXPECT_TRUE(read_.warnings.empty()) << read_.warnings[0];
    return read_.scene.materials.back();
  }
  const Texture& texture(const TextureRef& ref) { return *read_.scene.textures.at(ref.index); }

  const test::TempFolder folder_;
  ReadScene read_;
  std::map<std::string, std::shared_ptr<const Texture>> pictures_;
  int loads_ = 0;
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

TEST_F(MtlLines, NamedBsdfsAreTakenWhateverElseTheLinesSay) {
  const Material glass = material("Kd 1 0 0\nKs .9 .8 .7\nNi 1.3\n# tessera bsdf glass\n");
  EXPECT_EQ(glass.bsdf, BsdfKind::kGlass);
  EXPECT_EQ(glass.specular, (Vec3f{0.9f, 0.8f, 0.7f}));
  EXPECT_EQ(glass.ior, 1.3f);
  EXPECT_EQ(material("illum 6\nd .5\n# tessera bsdf diffuse\n").alpha.value, 0.5f);
  EXPECT_EQ(material("# tessera bsdf mirror\n").specular, (Vec3f{1, 1, 1}));
  const Material glossy = material("# tessera bsdf glossy\nPr .25\nPm 1\nPc 1\n");
  EXPECT_EQ(glossy.bsdf, BsdfKind::kGlossy);
  EXPECT_EQ(glossy.roughness, 0.25f);
  EXPECT_EQ(glossy.metalness, 1);
  EXPECT_EQ(glossy.clearcoat.weight, 1);
  EXPECT_EQ(material("Ks 1 1 1\nNs 100\n# tessera bsdf diffuse\n").bsdf, BsdfKind::kDiffuse);
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
               {"# tessera bsdf velvet\n", 1},
               {"# tesserae are stones\n", 0},
               {"illum 10\nnewmtl n\nillum 10\n", 1},
               {"Ka .1 .1 .1\nmap_Ka a.png\nnewmtl n\nKa .1 .1 .1\n", 1},
               {"Ka 0 0 0\n", 0},
               {"Ks -1 0 0\nNs nan\nd x\n", 3},
               {"Kd nan 0 0\nKe 0 inf 0\nTf 0 0 -1\n", 3},
               {"Kd 2 0 0\nPr 1.5\nPm 2\nPs 3\nPc 4\nPcr 5\naniso 6\nanisor 7\n", 8},
               {"Ni 0.5\nNi 5\nd 2\nTr 2\n", 4},
               {"Kd spectral a.rfl 1\nTf spectral b.rfl\n", 1},
               {"d -halo 0.5\n", 1},
               {"d 1\nTr 1\n", 1},
               {"Tr 1\n", 1},
               {"map_Kd\n", 1},
               {"map_Kd a.png\n", 1},
               {"refl -type sphere a.png\ndisp b.png\ndecal c.png\nmap_aat on\n", 1},
               {"Ps 0.5\nillum 7\n", 1}};
  for (const auto& c : cases) {
    EXPECT_EQ(read_lines(c.lines).warnings.size(), c.warnings) << c.lines;
  }
}

TEST_F(MtlLines, IllumSaysWhatGlassAndMirrorsAre) {
  for (const char* illum : {"illum 6\n", "illum 7\n"}) {
    EXPECT_EQ(material(std::string(illum) + "Ni 1.7\nd 0.2\n").bsdf, BsdfKind::kGlass) << illum;
    const Material rough = material(std::string(illum) + "Ni 1.7\nPr 0.5\nTf 1 0.5 0\n");
    EXPECT_EQ(rough.bsdf, BsdfKind::kGlossy);
    EXPECT_EQ(rough.roughness, 0.5f);
    EXPECT_EQ(rough.transmission.weight, 1);
    EXPECT_FALSE(rough.transmission.is_thin);
    EXPECT_EQ(rough.albedo, (Vec3f{1, 0.5f, 0}));
  }
  for (const char* illum : {"illum 4\n", "illum 9\n"}) {
    const Material sheet = material(std::string(illum) + "Kd 0 0 0\nTf 0.5 1 1\n");
    EXPECT_EQ(sheet.transmission.weight, 1) << illum;
    EXPECT_TRUE(sheet.transmission.is_thin);
    EXPECT_EQ(sheet.albedo, (Vec3f{0.5f, 1, 1}));
    EXPECT_EQ(material(std::string(illum) + "d 0.25\n").transmission.weight, 0.75f);
  }
  for (const char* illum : {"illum 3\n", "illum 5\n"}) {
    EXPECT_EQ(material(std::string(illum) + "Kd .01 .01 .01\nKs 1 1 1\nNs 9\n").bsdf,
              BsdfKind::kMirror);
    const Material coated = material(std::string(illum) + "Kd 1 0 0\nKs .5 .5 .5\n");
    EXPECT_EQ(coated.bsdf, BsdfKind::kGlossy) << "a mirror over a diffuse body";
    EXPECT_EQ(coated.roughness, 0);
  }
  EXPECT_EQ(material("illum 8\nKs .5 .5 .5\nNs 30\nKd 0 0 0\n").bsdf, BsdfKind::kGlossy);
}

TEST_F(MtlLines, OpacityByDTrAndPictures) {
  EXPECT_EQ(material("illum 2\nKd 1 1 1\n").alpha, Alpha{});
  const Material veil = material("illum 2\nd 0.25\nNi 1.5\n");
  EXPECT_EQ(veil.alpha.mode, AlphaMode::kBlend);
  EXPECT_EQ(veil.alpha.value, 0.25f);
  EXPECT_EQ(material("Tr 0.75\n").alpha.value, 0.25f);
  pictures_["grey.png"] = row({10, 10, 10, 255, 200, 200, 200, 255});
  pictures_["leaf.png"] = row({0, 255, 0, 255, 0, 255, 0, 0});
  pictures_["red.png"] = row({255, 0, 0, 255});
  const Material grey = material("illum 4\nmap_d grey.png\n");
  EXPECT_EQ(grey.alpha.mode, AlphaMode::kBlend) << "a picture of opacity is no glass";
  EXPECT_EQ(grey.alpha.channel, 0u);
  EXPECT_FALSE(texture(grey.alpha.texture).is_srgb);
  loads_ = 0;
  const Material leaf = material("map_Kd leaf.png\nmap_d leaf.png\n");
  EXPECT_EQ(loads_, 1) << "decoded once";
  EXPECT_EQ(leaf.alpha.channel, 3u);
  EXPECT_EQ(leaf.alpha.texture.index, leaf.albedo_texture.index) << "and kept once";
  EXPECT_EQ(leaf.albedo, (Vec3f{1, 1, 1}));
  EXPECT_EQ(material("map_d -imfchan g leaf.png\n").alpha.channel, 1u);
  const Material red = material("map_d red.png\n");
  EXPECT_NEAR(texel_at(texture(red.alpha.texture), 0, 0, static_cast<int>(red.alpha.channel)),
              0.2126, 1 / 255.0)
      << "luminance";
  EXPECT_EQ(read_lines("map_Kd leaf.png\n").warnings.size(), 1u) << "alpha that nothing uses";
}

TEST_F(MtlLines, OptionsPlaceAndChangePictures) {
  pictures_["a b.png"] = row({100, 100, 100, 255});
  const Material placed = material("map_Kd -s 2 3 1 -o 0.25 -clamp on a b.png\n");
  EXPECT_EQ(placed.albedo_texture.uv_map, (std::array<float, 6>{2, 0, 0.25f, 0, 3, 0}));
  EXPECT_EQ(texture(placed.albedo_texture).wrap_u, TextureWrap::kClamp);
  const Material sharp = material("map_Kd -blendu off -blendv off a b.png\n");
  EXPECT_TRUE(texture(sharp.albedo_texture).is_nearest);
  EXPECT_EQ(texture(sharp.albedo_texture).wrap_u, TextureWrap::kRepeat);
  const Material changed = material("map_Kd a b.png -mm 0.1 0.5\n");
  EXPECT_EQ(texture(changed.albedo_texture).rgba[0], 76) << "0.1 * 255 + 0.5 * 100, rounded";
  for (const char* option : {"-t 1 1 1", "-texres 64", "-boost 2", "-cc on", "-blendu off",
                             "-strange", "-imfchan x", "-clamp perhaps"}) {
    const ReadScene read = read_lines(std::string("map_Kd ") + option + " a b.png\n");
    EXPECT_GE(read.warnings.size(), 1u) << option;
  }
}

TEST_F(MtlLines, HeightsBecomeNormalsAndNormalsAreKept) {
  // Heights rise by 51 of 255 a texel towards +u, and fall back at the edge.
  std::vector<std::uint8_t> heights;
  for (const std::uint8_t h : std::initializer_list<std::uint8_t>{0, 51, 102, 153, 204})
    heights.insert(heights.end(), {h, h, h, 255});
  pictures_["h.png"] = row(heights);
  pictures_["n.png"] = row({128, 128, 255, 255, 218, 128, 218, 255});
  const Material bumpy = material("map_Bump -bm 20 h.png\n");
  const Texture& normals = texture(bumpy.normal_texture);
  EXPECT_FALSE(normals.is_srgb);
  // The slope is 0.2 a texel, of a height of 20 * 1 % of the 5 texels.
  const float slope = 0.2f * 20 * kBumpHeight * 5;
  const Vec3f expected = normalize(Vec3f{-slope, 0, 1});
  EXPECT_NEAR(2 * texel_at(normals, 2, 0, 0) - 1, expected.x, 2.0 / 255);
  EXPECT_NEAR(2 * texel_at(normals, 2, 0, 1) - 1, 0, 2.0 / 255);
  EXPECT_NEAR(2 * texel_at(normals, 2, 0, 2) - 1, expected.z, 2.0 / 255);
  EXPECT_GT(texel_at(normals, 0, 0, 0), 0.5) << "round the edge it falls";
  EXPECT_LT(texel_at(texture(material("bump -clamp on -bm 20 h.png\n").normal_texture), 0, 0, 0),
            0.5);
  const Material given = material("norm -bm 0.5 n.png\n");
  EXPECT_EQ(given.normal_scale, 0.5f);
  EXPECT_EQ(texture(given.normal_texture).rgba[4], 218);
  EXPECT_EQ(texture(material("bump n.png\n").normal_texture).rgba[4], 218) << "told by content";
}

TEST_F(MtlLines, PhysicalLinesAndTheirPictures) {
  pictures_["r.png"] = row({51, 51, 51, 255});
  pictures_["m.png"] = row({255, 255, 255, 255, 0, 0, 0, 255});
  const Material both = material("map_Pr r.png\nmap_Pm m.png\n");
  const Texture& combined = texture(both.roughness_metalness_texture);
  EXPECT_EQ(combined.width_px, 2) << "the finer of both";
  EXPECT_EQ(combined.rgba[1], 51);
  EXPECT_EQ(combined.rgba[2], 255);
  EXPECT_EQ(combined.rgba[6], 0);
  EXPECT_EQ(both.metalness, 1) << "where only a picture says so";
  const Material lobes = material("Pr 0.5\nPs 0.25\nPc 0.75\nPcr 0.125\naniso 0.5\nanisor 0.25\n");
  EXPECT_EQ(lobes.sheen.color, (Vec3f{0.25f, 0.25f, 0.25f}));
  EXPECT_EQ(lobes.clearcoat.weight, 0.75f);
  EXPECT_EQ(lobes.clearcoat.roughness, 0.125f);
  EXPECT_EQ(lobes.anisotropy.strength, 0.5f);
  EXPECT_NEAR(lobes.anisotropy.rotation, std::numbers::pi / 2, 1e-6);
  const Material shiny = material("Ks 1 1 1\nNs 30\nmap_Ks r.png\nmap_Ns m.png\n");
  EXPECT_TRUE(shiny.specular_color_texture.is_set());
  EXPECT_NEAR(texel_at(texture(shiny.roughness_metalness_texture), 0, 0, 1), 0.5, 1 / 255.0);
  EXPECT_EQ(texel_at(texture(shiny.roughness_metalness_texture), 1, 0, 1), 1);
  const Material lamp = material("map_Ke r.png\n");
  EXPECT_EQ(lamp.emission, (Vec3f{1, 1, 1}));
  EXPECT_TRUE(lamp.emission_texture.is_set());
}

TEST_F(MtlLines, ColoursInXyzBecomeRec709) {
  const Material grey = material("Kd xyz 0.47525 0.5 0.5445\n");  // D65
  EXPECT_NEAR(grey.albedo.x, 0.5, 1e-3);
  EXPECT_NEAR(grey.albedo.y, 0.5, 1e-3);
  EXPECT_NEAR(grey.albedo.z, 0.5, 1e-3);
}

}  // namespace
}  // namespace tessera
