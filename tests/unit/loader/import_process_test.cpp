// SPDX-License-Identifier: Apache-2.0
// The real tessera-import, and stand-ins that misbehave: the master gets one line in every case.
#include "master/loader/import_process.h"

#include <gtest/gtest.h>
#include <stdlib.h>

#include <cmath>
#include <filesystem>

#include "master/loader/load_scene.h"
#include "tests/support/temp_folder.h"

namespace tessera::master {
namespace {

class Import : public ::testing::Test {
 protected:
  void TearDown() override { unsetenv("TESSERA_IMPORT"); }

  // Runs a shell script in the place of tessera-import.
  Result<SceneStream> run_instead(const std::string& script, double seconds_max = 60,
                                  std::uint64_t bytes_max = 1 << 30) {
    const std::string program = folder_.write("import.sh", "#!/bin/sh\n" + script);
    std::filesystem::permissions(program, std::filesystem::perms::owner_all);
    setenv("TESSERA_IMPORT", program.c_str(), 1);
    return run_import(folder_.write("scene.obj", "x"), {seconds_max, bytes_max},
                      [](std::uint64_t) { return true; });
  }

  const test::TempFolder folder_;
};

// End of a glTF file of one triangle: its accessor 0, corners (0,0,0), (1,0,0), (0,1,0).
const std::string kTriangle =
    R"("accessors":[{"bufferView":0,"componentType":5126,"count":3,"type":"VEC3","min":[0,0,0],"max":[1,1,0]}],
"bufferViews":[{"buffer":0,"byteLength":36}],
"buffers":[{"byteLength":36,"uri":"data:application/octet-stream;base64,AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAgD8AAAAA"}]})";

TEST_F(Import, AFileBecomesAScene) {
  const std::string path =
      folder_.write("a.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nusemtl gone\nf 1 2 3\n");
  auto loaded = load_scene(path, [](const std::string&, double) { return true; });
  ASSERT_TRUE(loaded.is_ok()) << loaded.status().message();
  EXPECT_EQ(loaded->scene.triangle_count(), 1u);
  EXPECT_FALSE(loaded->warnings.empty());
}

TEST_F(Import, GltfWithNodeTransformsCameraAndMaterial) {
  // One triangle, moved by its node; positions and indices in a data URI.
  const std::string path = folder_.write(
      "a.gltf", std::string(R"({"asset":{"version":"2.0"},"scene":0,"scenes":[{"nodes":[0,1]}],
"nodes":[{"mesh":0,"translation":[10,0,0]},{"camera":0,"translation":[10,0,5]}],
"cameras":[{"type":"perspective","perspective":{"yfov":0.5,"aspectRatio":1.5,"znear":0.1}}],
"materials":[{"pbrMetallicRoughness":{"baseColorFactor":[0.5,0.25,0.125,1]}}],
"meshes":[{"primitives":[{"attributes":{"POSITION":0},"material":0}]}],
)") + kTriangle);
  auto loaded = load_scene(path, [](const std::string&, double) { return true; });
  ASSERT_TRUE(loaded.is_ok()) << loaded.status().message();
  const Scene& scene = loaded->scene;
  ASSERT_EQ(scene.triangle_count(), 1u);
  const Instance& instance = scene.instances.at(0);
  const Mesh& mesh = *scene.meshes.at(instance.mesh);
  EXPECT_EQ(instance.object_to_world.point(mesh.positions[mesh.triangles[0][1]]),
            (Vec3f{11, 0, 0}));
  EXPECT_EQ(scene.materials.at(mesh.materials.at(0)).albedo, (Vec3f{0.5f, 0.25f, 0.125f}));
  ASSERT_TRUE(scene.camera.has_value());
  EXPECT_EQ(scene.camera->eye, (Vec3f{10, 0, 5}));
  EXPECT_NEAR(scene.camera->vfov_degrees, 0.5 * 180 / 3.14159265, 1e-3);
}

TEST_F(Import, GltfMetallicRoughnessAndTransmission) {
  const std::string path = folder_.write(
      "m.gltf",
      std::string(
          R"({"asset":{"version":"2.0"},"scene":0,"scenes":[{"nodes":[0]}],"nodes":[{"mesh":0}],
"extensionsUsed":["KHR_materials_transmission","KHR_materials_ior","KHR_materials_emissive_strength"],
"materials":[{"pbrMetallicRoughness":{"baseColorFactor":[0.5,0.25,0.125,1],"metallicFactor":0.75,"roughnessFactor":0.5}},
{"pbrMetallicRoughness":{"baseColorFactor":[1,0.5,1,1],"metallicFactor":0,"roughnessFactor":0},
"extensions":{"KHR_materials_transmission":{"transmissionFactor":1},"KHR_materials_ior":{"ior":1.25},
"KHR_materials_volume":{"thicknessFactor":1}}},
{"name":"a \"]} , b","pbrMetallicRoughness":{},"emissiveFactor":[1,0.5,0.25],
"extensions":{"KHR_materials_emissive_strength":{"emissiveStrength" : 4 }}}],
"meshes":[{"primitives":[{"attributes":{"POSITION":0},"material":0},{"attributes":{"POSITION":0},"material":1},
{"attributes":{"POSITION":0},"material":2}]}],
)") + kTriangle);
  auto loaded = load_scene(path, [](const std::string&, double) { return true; });
  ASSERT_TRUE(loaded.is_ok()) << loaded.status().message();
  ASSERT_GE(loaded->scene.materials.size(), 3u);
  const Material& metal = loaded->scene.materials[0];
  EXPECT_EQ(metal.bsdf, BsdfKind::kGlossy);
  EXPECT_EQ(metal.metalness, 0.75f);
  EXPECT_EQ(metal.roughness, 0.5f);
  EXPECT_NEAR(metal.specular.x, 0.04, 1e-6);
  const Material& glass = loaded->scene.materials[1];
  EXPECT_EQ(glass.bsdf, BsdfKind::kGlass);
  EXPECT_EQ(glass.ior, 1.25f);
  EXPECT_EQ(glass.specular, (Vec3f{1, 0.5f, 1}));
  const Material& plain = loaded->scene.materials[2];
  EXPECT_EQ(plain.metalness, 1) << "the format's default";
  EXPECT_EQ(plain.roughness, 1);
  EXPECT_EQ(plain.emission, (Vec3f{4, 2, 1}));
}

// A picture of 1x1: PNG, red 255, green 128, blue 64.
constexpr char kPicture[] =
    "data:image/"
    "png;base64,iVBORw0KGgoAAAANSUhEUgAAAAEAAAABCAIAAACQd1PeAAAADElEQVR4nGP43+"
    "AAAARBAcAM0e2RAAAAAElFTkSuQmCC";

TEST_F(Import, GltfNormalMapsAndEmissiveTextures) {
  const std::string path = folder_.write(
      "n.gltf",
      std::string(
          R"({"asset":{"version":"2.0"},"scene":0,"scenes":[{"nodes":[0]}],"nodes":[{"mesh":0}],
"images":[{"uri":")") +
          kPicture + R"("}],"textures":[{"source":0}],
"materials":[{"normalTexture":{"index":0,"scale":0.5},"emissiveTexture":{"index":0},"emissiveFactor":[1,0.5,0.25]}],
"meshes":[{"primitives":[{"attributes":{"POSITION":0},"material":0}]}],
)" + kTriangle);
  auto loaded = load_scene(path, [](const std::string&, double) { return true; });
  ASSERT_TRUE(loaded.is_ok()) << loaded.status().message();
  EXPECT_TRUE(loaded->warnings.empty());
  const Material& m = loaded->scene.materials.at(0);
  EXPECT_EQ(m.normal_scale, 0.5f);
  EXPECT_EQ(m.emission, (Vec3f{1, 0.5f, 0.25f}));
  const auto& textures = loaded->scene.textures;
  ASSERT_LT(m.normal_texture.index, textures.size());
  ASSERT_LT(m.emission_texture.index, textures.size());
  EXPECT_FALSE(textures[m.normal_texture.index]->is_srgb);
  EXPECT_TRUE(textures[m.emission_texture.index]->is_srgb);
  EXPECT_EQ(textures[m.normal_texture.index]->rgba, (std::vector<std::uint8_t>{255, 128, 64, 255}));
}

// A node that mirrors turns the corners of its triangles round, so that outside stays outside.
TEST_F(Import, GltfMirroredNodesKeepTheirOutside) {
  const std::string path = folder_.write(
      "mirror.gltf",
      std::string(
          R"({"asset":{"version":"2.0"},"scene":0,"scenes":[{"nodes":[0,1]}],"nodes":[{"mesh":0},{"mesh":0,"scale":[1,1,-2]}],
"meshes":[{"primitives":[{"attributes":{"POSITION":0}}]}],
)") + kTriangle);
  auto loaded = load_scene(path, [](const std::string&, double) { return true; });
  ASSERT_TRUE(loaded.is_ok()) << loaded.status().message();
  const Scene& scene = loaded->scene;
  ASSERT_EQ(scene.instances.size(), 2u);
  for (const Instance& instance : scene.instances) {
    const Mesh& mesh = *scene.meshes[instance.mesh];
    const auto at = [&](std::size_t k) {
      return instance.object_to_world.point(mesh.positions[mesh.triangles[0][k]]);
    };
    // Without a node the triangle looks along +z; mirrored in z, along -z.
    const float expected = instance.object_to_world.m[2][2] < 0 ? -1.0f : 1.0f;
    EXPECT_EQ(cross(at(1) - at(0), at(2) - at(0)).z * expected > 0, true);
  }
}

TEST_F(Import, SkiesAreReadAndWrongOnesRefused) {
  const auto load = [](const std::string& path) {
    return load_sky(path, [](const std::string&, double) { return true; });
  };
  const std::string head = "#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 1 +X 2\n";
  // Mantissas of 8 bits over an exponent of 128 + 1: 128 of 256, twice, is 1.
  const auto sky = load(folder_.write("a.hdr", head + "\x80\x40\x20\x81\xc0\xc0\xc0\x88"));
  ASSERT_TRUE(sky.is_ok()) << sky.status().message();
  EXPECT_EQ((*sky)->width_px, 2);
  EXPECT_EQ((*sky)->height_px, 1);
  EXPECT_NEAR((*sky)->rgb[0], 1, 0.01f);
  EXPECT_NEAR((*sky)->rgb[2], 0.25, 0.01f);
  EXPECT_NEAR((*sky)->rgb[3], 192, 1);
  EXPECT_EQ(load("a.png").status().code(), StatusCode::kInvalidArgument);
  EXPECT_EQ(load("missing.hdr").status().code(), StatusCode::kNotFound);
  for (const auto& [name, text] :
       {std::pair<const char*, std::string>{"cut.hdr", head + "\x80"},
        {"text.hdr", "no picture"},
        {"text.exr", "no picture"},
        {"wide.hdr", "#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 1 +X 99999\n"}}) {
    const auto refused = load(folder_.write(name, text));
    ASSERT_FALSE(refused.is_ok()) << name;
    EXPECT_NE(refused.status().message().find(name), std::string::npos)
        << refused.status().message();
  }
}

TEST_F(Import, GltfLightsStandAndShineAsTheirNodesSay) {
  const std::string path = folder_.write(
      "l.gltf", std::string(R"({"asset":{"version":"2.0"},"scene":0,"scenes":[{"nodes":[0,1,2,3]}],
"extensionsUsed":["KHR_lights_punctual"],
"extensions":{"KHR_lights_punctual":{"lights":[{"type":"point","intensity":3,"color":[1,0.5,0.25]},
{"type":"spot","spot":{"innerConeAngle":0.2,"outerConeAngle":0.5}},{"type":"directional","intensity":2}]}},
"nodes":[{"mesh":0},{"translation":[1,2,3],"extensions":{"KHR_lights_punctual":{"light":0}}},
{"translation":[0,5,0],"rotation":[-0.70710678,0,0,0.70710678],"extensions":{"KHR_lights_punctual":{"light":1}}},
{"extensions":{"KHR_lights_punctual":{"light":2}}}],
"meshes":[{"primitives":[{"attributes":{"POSITION":0}}]}],
)") + kTriangle);
  auto loaded = load_scene(path, [](const std::string&, double) { return true; });
  ASSERT_TRUE(loaded.is_ok()) << loaded.status().message();
  const std::vector<Light>& lights = loaded->scene.lights;
  ASSERT_EQ(lights.size(), 3u);
  EXPECT_EQ(lights[0].kind, LightKind::kPoint);
  EXPECT_EQ(lights[0].position, (Vec3f{1, 2, 3}));
  EXPECT_NEAR(lights[0].intensity.x, 3 / 683.0, 1e-8) << "candela";
  EXPECT_NEAR(lights[0].intensity.z, 0.75 / 683, 1e-8);
  EXPECT_EQ(lights[1].kind, LightKind::kSpot);
  EXPECT_EQ(lights[1].position, (Vec3f{0, 5, 0}));
  EXPECT_NEAR(lights[1].direction.y, -1, 1e-6) << "its node turns -z down";
  EXPECT_NEAR(lights[1].cos_inner, std::cos(0.2), 1e-6);
  EXPECT_NEAR(lights[1].cos_outer, std::cos(0.5), 1e-6);
  EXPECT_EQ(lights[2].kind, LightKind::kDirectional);
  EXPECT_EQ(lights[2].direction, (Vec3f{0, 0, -1}));
  EXPECT_NEAR(lights[2].intensity.x, 2 / 683.0, 1e-8) << "lux";
}

TEST_F(Import, ItsRefusalIsHandedOn) {
  auto stream = run_instead("echo 'tessera-import: scene.obj:3: bad' >&2; echo more >&2; exit 1");
  ASSERT_FALSE(stream.is_ok());
  EXPECT_EQ(stream.status().message(), "scene.obj:3: bad");
}

// libpng, for one, prints such a line for a damaged picture.
TEST_F(Import, WhatLibrariesPrintBeforeItIsNotTheReason) {
  const auto result =
      run_instead("echo 'libpng error: x' >&2; echo 'tessera-import: a.gltf: no' >&2; exit 1");
  EXPECT_EQ(result.status().message(), "a.gltf: no");
}

TEST_F(Import, ItsDeathIsALineAboutTheFile) {
  for (const char* signal : {"SEGV", "ABRT", "KILL", "XCPU"}) {
    auto stream = run_instead(std::string("kill -") + signal + " $$");
    ASSERT_FALSE(stream.is_ok()) << signal;
    EXPECT_NE(stream.status().message().find("scene.obj"), std::string::npos);
  }
}

TEST_F(Import, ItIsStoppedWhenItHangs) {
  auto stream = run_instead("exec sleep 100", 0.3);
  ASSERT_FALSE(stream.is_ok());
  EXPECT_EQ(stream.status().code(), StatusCode::kResourceExhausted);
  EXPECT_NE(stream.status().message().find("--import-seconds"), std::string::npos);
}

TEST_F(Import, ItIsToldItsSecondsAndHasNoEnvironment) {
  EXPECT_EQ(run_instead("echo tessera-import: $1 >&2; exit 1", 41.5).status().message(),
            "--cpu-seconds=42");
  setenv("TESSERA_SECRET", "seen", 1);
  EXPECT_EQ(run_instead("echo tessera-import: [$TESSERA_SECRET] >&2; exit 1").status().message(),
            "[]");
  unsetenv("TESSERA_SECRET");
}

TEST_F(Import, ItIsStoppedOnRequest) {
  const std::string program = folder_.write("import.sh", "#!/bin/sh\nexec sleep 100");
  std::filesystem::permissions(program, std::filesystem::perms::owner_all);
  setenv("TESSERA_IMPORT", program.c_str(), 1);
  int calls = 0;
  auto stream =
      run_import(folder_.write("scene.obj", "x"), {}, [&](std::uint64_t) { return ++calls < 3; });
  ASSERT_FALSE(stream.is_ok());
  EXPECT_EQ(stream.status().code(), StatusCode::kCancelled);
}

TEST_F(Import, SuffixesMayBeWrittenLarge) {
  const std::string path = folder_.write("A.OBJ", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
  EXPECT_TRUE(load_scene(path, [](const std::string&, double) { return true; }).is_ok());
}

TEST_F(Import, GltfReadsNothingOutsideItsFolder) {
  std::filesystem::create_directories(folder_ / "scene");
  folder_.write("outside.bin", std::string(36, '\0'));
  const auto gltf = [&](const std::string& uri) {
    const std::string path = folder_.write(
        "scene/b.gltf",
        R"({"asset":{"version":"2.0"},"scene":0,"scenes":[{"nodes":[0]}],"nodes":[{"mesh":0}],
"meshes":[{"primitives":[{"attributes":{"POSITION":0}}]}],
"accessors":[{"bufferView":0,"componentType":5126,"count":3,"type":"VEC3","min":[0,0,0],"max":[1,1,0]}],
"bufferViews":[{"buffer":0,"byteLength":36}],"buffers":[{"byteLength":36,"uri":")" +
            uri + "\"}]}");
    return load_scene(path, [](const std::string&, double) { return true; });
  };
  EXPECT_FALSE(gltf("../outside.bin").is_ok());
  EXPECT_FALSE(gltf(folder_ / "outside.bin").is_ok());
  folder_.write("scene/inside.bin", std::string(36, '\0'));
  auto inside = gltf("inside.bin");
  EXPECT_TRUE(inside.is_ok()) << inside.status().message();
}

TEST_F(Import, ItIsStoppedWhenItTalksWithoutEnd) {
  auto stream = run_instead("exec cat /dev/zero", 60, 1 << 20);
  ASSERT_FALSE(stream.is_ok());
  EXPECT_EQ(stream.status().code(), StatusCode::kResourceExhausted);
}

TEST_F(Import, GarbageFromItIsRefused) {
  EXPECT_FALSE(run_instead("head -c 100000 /dev/urandom").is_ok());
  EXPECT_FALSE(run_instead("exit 0").is_ok());
}

TEST_F(Import, AProgramThatIsNotThereIsNamed) {
  setenv("TESSERA_IMPORT", "/no/such/tessera-import", 1);
  auto stream = run_import(folder_.write("scene.obj", "x"), {}, [](std::uint64_t) { return true; });
  ASSERT_FALSE(stream.is_ok());
  EXPECT_NE(stream.status().message().find("/no/such/tessera-import"), std::string::npos);
}

}  // namespace
}  // namespace tessera::master
