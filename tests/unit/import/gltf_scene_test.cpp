// SPDX-License-Identifier: Apache-2.0
// Parts of a glTF file become the right parts of a scene, where no test of a picture shows it or
// rounding would hide it.
#include <cmath>

#include "tests/unit/import/gltf_text.h"

namespace tessera::import {
namespace {

constexpr const char* kMaterial =
    R"({"name":"Leaf","pbrMetallicRoughness":{"roughnessFactor":0.5}})";
constexpr const char* kPicture =
    R"("images":[{"uri":"data:,x"}],"textures":[{"source":0,"sampler":0}],
"samplers":[{"wrapS":33071,"wrapT":33648,"magFilter":9728}],"cameras":)";

class GltfScenes : public GltfFiles {
 protected:
  // First material of the scene of a file with the material `json` and a picture.
  Material material(const std::string& json) {
    scene_ = scene(with(with(kGltfText, kMaterial, json), "\"cameras\":", kPicture));
    return scene_.materials.empty() ? Material() : scene_.materials[0];
  }
  Scene scene(const std::string& text) {
    auto result = read(text);
    EXPECT_TRUE(result.is_ok()) << result.status().message();
    if (!result.is_ok()) return {};
    for (const std::string& line : result->warnings) ADD_FAILURE() << line;
    return std::move(result->scene);
  }
  Scene scene_;
};

TEST_F(GltfScenes, LampsAreInWatts) {
  const Scene lit = scene(kGltfText);
  ASSERT_EQ(lit.lights.size(), 1u);
  EXPECT_EQ(lit.lights[0].kind, LightKind::kSpot);
  EXPECT_EQ(lit.lights[0].intensity, (Vec3f{1, 1, 1})) << "683 cd are 1 W/sr";
  EXPECT_FLOAT_EQ(lit.lights[0].cos_inner, 1);
  EXPECT_FLOAT_EQ(lit.lights[0].cos_outer, std::cos(3.14159265f / 4));
}

TEST_F(GltfScenes, CamerasHaveTheNamesOfTheirNodes) {
  const Scene seen = scene(kGltfText);
  ASSERT_EQ(seen.cameras.size(), 1u);
  EXPECT_EQ(seen.cameras[0].name, "Eye");
  EXPECT_EQ(seen.cameras[0].camera.eye, (Vec3f{0, 0, 5}));
  EXPECT_EQ(seen.camera, seen.cameras[0].camera);
}

TEST_F(GltfScenes, SamplersSayHowPicturesGoOn) {
  const Material m = material(R"({"normalTexture":{"index":0,"scale":2},
"emissiveFactor":[1,1,1],"emissiveTexture":{"index":0,"texCoord":1}})");
  ASSERT_EQ(scene_.textures.size(), 2u) << "one for colours and one for numbers";
  EXPECT_EQ(m.normal_scale, 2);
  EXPECT_EQ(m.emission_texture.uv_set, 1u);
  const Texture& plain = *scene_.textures[m.normal_texture.index];
  EXPECT_FALSE(plain.is_srgb);
  EXPECT_TRUE(scene_.textures[m.emission_texture.index]->is_srgb);
  EXPECT_EQ(plain.wrap_u, TextureWrap::kClamp);
  EXPECT_EQ(plain.wrap_v, TextureWrap::kMirror);
  EXPECT_TRUE(plain.is_nearest);
}

// The example of the extension's text: the lower left quarter of the picture, turned clockwise.
TEST_F(GltfScenes, TextureTransformIsTheExtensionsWithRisingV) {
  const Material m = material(R"({"pbrMetallicRoughness":{"baseColorTexture":{"index":0,
"extensions":{"KHR_texture_transform":{"offset":[0,1],"rotation":1.57079632679,"scale":[0.5,0.5]}}}}})");
  const auto& map = m.albedo_texture.uv_map;
  const auto at = [&](float u, float v) {
    return Vec2f{map[0] * u + map[1] * v + map[2], map[3] * u + map[4] * v + map[5]};
  };
  // Corners of the file's coordinates, (u, v falling) -> (v / 2, 1 - u / 2), with v turned round.
  EXPECT_NEAR(at(0, 1).x, 0, 1e-6f);
  EXPECT_NEAR(at(0, 1).y, 0, 1e-6f);
  EXPECT_NEAR(at(1, 1).x, 0, 1e-6f);
  EXPECT_NEAR(at(1, 1).y, 0.5f, 1e-6f);
  EXPECT_NEAR(at(0, 0).x, 0.5f, 1e-6f);
  EXPECT_NEAR(at(0, 0).y, 0, 1e-6f);
}

TEST_F(GltfScenes, LobesAreFilled) {
  const Material m = material(R"({"alphaMode":"MASK","alphaCutoff":0.25,"doubleSided":true,
"pbrMetallicRoughness":{"baseColorFactor":[1,1,1,0.5],"baseColorTexture":{"index":0}},"extensions":{
"KHR_materials_clearcoat":{"clearcoatFactor":0.5,"clearcoatRoughnessFactor":0.25},
"KHR_materials_sheen":{"sheenColorFactor":[0.5,0.25,0],"sheenRoughnessFactor":0.75},
"KHR_materials_transmission":{"transmissionFactor":0.5},
"KHR_materials_volume":{"thicknessFactor":1,"attenuationDistance":2,"attenuationColor":[1,0.5,0.25]},
"KHR_materials_anisotropy":{"anisotropyStrength":0.5,"anisotropyRotation":1},
"KHR_materials_specular":{"specularFactor":0.5,"specularColorFactor":[2,1,1]},
"KHR_materials_ior":{"ior":2}}})");
  EXPECT_EQ(m.bsdf, BsdfKind::kGlossy);
  EXPECT_EQ(m.alpha.mode, AlphaMode::kMask);
  EXPECT_EQ(m.alpha.cutoff, 0.25f);
  EXPECT_EQ(m.alpha.value, 0.5f);
  EXPECT_EQ(m.alpha.texture, m.albedo_texture);
  EXPECT_TRUE(m.is_double_sided);
  EXPECT_EQ(m.clearcoat.weight, 0.5f);
  EXPECT_EQ(m.clearcoat.roughness, 0.25f);
  EXPECT_EQ(m.sheen.color, (Vec3f{0.5f, 0.25f, 0}));
  EXPECT_EQ(m.sheen.roughness, 0.75f);
  EXPECT_EQ(m.transmission.weight, 0.5f);
  EXPECT_FALSE(m.transmission.is_thin);
  EXPECT_EQ(m.transmission.attenuation_distance, 2);
  EXPECT_EQ(m.transmission.attenuation_color, (Vec3f{1, 0.5f, 0.25f}));
  EXPECT_EQ(m.anisotropy.strength, 0.5f);
  EXPECT_EQ(m.anisotropy.rotation, 1);
  EXPECT_EQ(m.ior, 2);
  // An index of 2 reflects 1/9, of which the colour doubles red and the factor halves all.
  EXPECT_NEAR(m.specular.x, 1.0 / 9, 1e-6);
  EXPECT_NEAR(m.specular.y, 0.5 / 9, 1e-6);
  EXPECT_EQ(m.specular_f90, 0.5f);
}

TEST_F(GltfScenes, TransmissionIsThinUnlessThereIsAVolume) {
  const Material sheet =
      material(R"({"extensions":{"KHR_materials_transmission":{"transmissionFactor":1}}})");
  EXPECT_EQ(sheet.bsdf, BsdfKind::kGlossy);
  EXPECT_EQ(sheet.transmission.weight, 1);
  EXPECT_TRUE(sheet.transmission.is_thin);
  const Material flat = material(R"({"extensions":{"KHR_materials_volume":{"thicknessFactor":0},
"KHR_materials_transmission":{"transmissionFactor":1}}})");
  EXPECT_TRUE(flat.transmission.is_thin);
}

TEST_F(GltfScenes, SmoothSolidsAreGlassWhereThatDrawsTheSame) {
  const std::string solid =
      R"("KHR_materials_transmission":{"transmissionFactor":1},"KHR_materials_volume":{"thicknessFactor":1})";
  const auto pbr = [](const std::string& more) {
    return R"({"pbrMetallicRoughness":{"metallicFactor":0,"roughnessFactor":0)" + more + "},";
  };
  EXPECT_EQ(material(pbr("") + "\"extensions\":{" + solid + "}}").bsdf, BsdfKind::kGlass);
  EXPECT_EQ(
      material(pbr(",\"baseColorTexture\":{\"index\":0}") + "\"extensions\":{" + solid + "}}").bsdf,
      BsdfKind::kGlossy);
  EXPECT_EQ(
      material(pbr("") + "\"extensions\":{\"KHR_materials_clearcoat\":{\"clearcoatFactor\":1}," +
               solid + "}}")
          .bsdf,
      BsdfKind::kGlossy);
}

TEST_F(GltfScenes, GlossinessOfAPictureIsRoughnessOfAnother) {
  const Material m = material(R"({"extensions":{"KHR_materials_pbrSpecularGlossiness":{
"specularFactor":[0.5,0.5,0.5],"glossinessFactor":0.5,"specularGlossinessTexture":{"index":0}}}})");
  EXPECT_EQ(m.specular, (Vec3f{0.5f, 0.5f, 0.5f}));
  EXPECT_EQ(m.metalness, 0);
  ASSERT_TRUE(m.roughness_metalness_texture.is_set());
  const Texture& roughness = *scene_.textures[m.roughness_metalness_texture.index];
  EXPECT_FALSE(roughness.is_srgb);
  // The picture's alpha is 51 of 255: a glossiness of 0.2 * 0.5.
  EXPECT_EQ(roughness.rgba, (std::vector<std::uint8_t>{255, 230, 255, 255}));
  EXPECT_EQ(m.roughness, 1);
}

}  // namespace
}  // namespace tessera::import
