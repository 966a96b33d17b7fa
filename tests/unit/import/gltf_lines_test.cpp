// SPDX-License-Identifier: Apache-2.0
// A fault of a glTF file is one line that names file, object and key. Geometry that cannot be
// trusted refuses the file; looks are repaired.
#include <gmock/gmock.h>

#include "tests/unit/import/gltf_text.h"

namespace tessera::import {
namespace {

using ::testing::HasSubstr;

struct Change {
  const char *from, *to, *line;
};

TEST_F(GltfFiles, AGoodFileIsSilent) { EXPECT_EQ(lines(kGltfText), ""); }

TEST_F(GltfFiles, WhatGeometryHangsOnRefusesTheFileByOneLine) {
  const Change changes[] = {
      {"\"version\":\"2.0\"", "\"version\":\"1.0\"", "x.gltf: asset.version is '1.0'; only glTF 2"},
      {"{\"asset\"", "[\"asset\"", "x.gltf: is no glTF file"},
      {"\"scene\":0,", "\"scene\":0,,", "x.gltf: is no JSON: parse error at line 1, column"},
      {"\"yfov\":0.5", "\"yfov\":1e999", "x.gltf: is no JSON: number overflow"},
      {"\"nodes\":[0,1,2]", "\"nodes\":[0,7]", "x.gltf: scene 0: nodes holds one that is 7"},
      {"{\"mesh\":0}", "{\"mesh\":4}", "x.gltf: node 0: mesh is 4; it must be from 0 to 0"},
      {"{\"mesh\":0}", "{\"mesh\":-1}", "x.gltf: node 0: mesh is -1"},
      {"{\"mesh\":0}", "{\"mesh\":0,\"children\":[0]}", "x.gltf: node 0: is its own ancestor"},
      {"{\"mesh\":0}", "{\"mesh\":0,\"children\":[1]}",
       "x.gltf: node 1 'Eye': is its own ancestor, or a child of two nodes"},
      {"\"POSITION\":0", "\"POSITION\":1",
       "x.gltf: mesh 0: primitives[0].attributes.POSITION is 1; it must be from 0 to 0"},
      {"\"type\":\"VEC3\"", "\"type\":\"VEC2\"", "attributes.POSITION is accessor 0, whose type"},
      {"\"count\":3", "\"count\":4", "x.gltf: accessor 0: count asks for 4 elements"},
      {"\"count\":3", "\"count\":0", "x.gltf: accessor 0: count is 0; it must be a whole number"},
      {"\"count\":3", "\"count\":18446744073709551615", "x.gltf: accessor 0: count is 1844674"},
      {"5126", "5124", "x.gltf: accessor 0: componentType is 5124"},
      {"\"byteLength\":36}]", "\"byteLength\":36,\"byteOffset\":4}]",
       "x.gltf: bufferView 0: byteLength ends 4 bytes behind buffer 0"},
      {"\"byteLength\":36}]", "\"byteLength\":36,\"byteStride\":8}]",
       "x.gltf: bufferView 0: byteStride is 8, but an element of accessor 0 has 12 bytes"},
      {"\"byteLength\":36,\"uri\"", "\"byteLength\":40,\"uri\"",
       "x.gltf: buffer 0: byteLength is 40, but there are 36 bytes"},
      {"base64,AAAAAAAA", "base64,AADAfwAA",
       "x.gltf: mesh 0: primitives[0].attributes.POSITION of vertex 0 is not finite"},
      {"base64,", "base64,*", "x.gltf: buffer 0: uri is a data URI that is no base64"},
      {"data:application", "../x:application", "buffer 0: uri '../x:application"},
  };
  for (const Change& change : changes) {
    const auto result = read(with(kGltfText, change.from, change.to));
    const std::string text = lines(with(kGltfText, change.from, change.to));
    EXPECT_FALSE(result.is_ok()) << change.to;
    EXPECT_THAT(text, HasSubstr(change.line));
    EXPECT_EQ(text.find('\n'), std::string::npos) << text;
  }
}

TEST_F(GltfFiles, WhatOnlyLooksHangOnIsRepairedAndSaid) {
  const Change changes[] = {
      {"\"roughnessFactor\":0.5", "\"roughnessFactor\":2",
       "x.gltf: material 0 'Leaf': pbrMetallicRoughness.roughnessFactor is 2; it must be from 0 to "
       "1; 1 is used"},
      {"\"roughnessFactor\":0.5", "\"roughnessFactor\":\"a\"",
       "roughnessFactor is 'a'; it must be from 0 to 1; 1 is used"},
      {"\"roughnessFactor\":0.5", "\"roughnessFactor\":1e300",
       "roughnessFactor is 1e+300; it must be from 0 to 1; 1 is used"},
      {"\"name\":\"Leaf\"", "\"name\":\"Leaf\",\"alphaCutoff\":-1",
       "x.gltf: material 0 'Leaf': alphaCutoff is -1; it must be 0 or more; 0 is used"},
      {"\"name\":\"Leaf\"", "\"name\":\"Leaf\",\"alphaMode\":\"CUT\"", "alphaMode is 'CUT'"},
      {"\"name\":\"Leaf\"", "\"name\":\"Leaf\",\"doubleSided\":1",
       "doubleSided is 1; it must be true"},
      {"\"name\":\"Leaf\"", "\"name\":\"Leaf\",\"emissiveFactor\":[1,2]",
       "emissiveFactor is no array of 3 numbers; its default is used"},
      {"\"name\":\"Leaf\"", "\"name\":\"Leaf\",\"emissiveFactor\":[1,2,null]",
       "emissiveFactor is 2;"},
      {"\"name\":\"Leaf\"", "\"name\":\"Leaf\",\"normalTexture\":{\"index\":3}",
       "material 0 'Leaf': normalTexture.index is 3, but there are none; the plain value is used"},
      {"\"name\":\"Leaf\"", "\"name\":\"Leaf\",\"normalTexture\":{}",
       "material 0 'Leaf': normalTexture.index is missing"},
      {"\"name\":\"Leaf\"", "\"name\":\"Leaf\",\"shiny\":1", "material 0 'Leaf': shiny is no key"},
      {"\"name\":\"Leaf\"", "\"name\":\"Leaf\",\"extensions\":{\"KHR_materials_ior\":{\"ior\":9}}",
       "KHR_materials_ior.ior is 9; it must be from 0 to 4"},
      {"\"material\":0", "\"material\":5",
       "mesh 0: primitives[0].material is 5; it must be from 0 to 0; the default material is used"},
      {"\"intensity\":683", "\"intensity\":-1",
       "light 0 'Key': intensity is -1; it must be 0 or more"},
      {"\"type\":\"spot\"", "\"type\":\"laser\"", "light 0 'Key': type is 'laser'"},
      {"\"type\":\"spot\"",
       "\"type\":\"spot\",\"spot\":{\"innerConeAngle\":1,\"outerConeAngle\":0.5}",
       "light 0 'Key': spot.innerConeAngle is more than outerConeAngle"},
      {"\"light\":0", "\"light\":1", "node 2: KHR_lights_punctual.light is 1"},
      {"\"yfov\":0.5", "\"yfov\":-1", "camera 0: perspective.yfov is -1; it must be more than 0"},
      {"\"camera\":0", "\"camera\":3", "node 1 'Eye': camera is 3"},
      {"\"scene\":0", "\"scene\":3",
       "the file: scene is 3; it must be from 0 to 0; the first scene"},
  };
  for (const Change& change : changes) {
    const std::string text = with(kGltfText, change.from, change.to);
    const auto result = read(text);
    ASSERT_TRUE(result.is_ok()) << change.to << ": " << result.status().message();
    EXPECT_THAT(lines(text), HasSubstr(change.line));
    EXPECT_EQ(result->scene.triangle_count(), 1u);
  }
}

TEST_F(GltfFiles, AFaultInManyMaterialsIsOneLineWithACount) {
  std::string primitives, materials;
  for (int i = 0; i < 5; ++i) {
    materials += std::string(i > 0 ? "," : "") + R"({"alphaCutoff":-1})";
    primitives += std::string(i > 0 ? "," : "") + R"({"attributes":{"POSITION":0},"material":)" +
                  std::to_string(i) + "}";
  }
  std::string text = with(kGltfText, R"({"attributes":{"POSITION":0},"material":0})", primitives);
  text = with(text, R"({"name":"Leaf","pbrMetallicRoughness":{"roughnessFactor":0.5}})", materials);
  EXPECT_EQ(lines(text),
            "x.gltf: material 0: alphaCutoff is -1; it must be 0 or more; 0 is used (and 4 more "
            "like it)\n");
}

TEST_F(GltfFiles, ControlCharactersOfNamesDoNotReachALine) {
  EXPECT_THAT(lines(with(with(kGltfText, "Leaf", R"(a\nb\u001b[31m)"), "\"roughnessFactor\":0.5",
                         "\"roughnessFactor\":7")),
              HasSubstr("material 0 'a?b?[31m': "));
}

TEST_F(GltfFiles, AChainOfNodesThatNobodyMadeIsRefused) {
  std::string nodes;
  for (int i = 3; i < 5000; ++i) nodes += ",{\"children\":[" + std::to_string(i + 1) + "]}";
  nodes += ",{}";
  std::string text = with(kGltfText, "{\"mesh\":0}", "{\"mesh\":0,\"children\":[3]}");
  text = with(text, "{\"light\":0}}}", "{\"light\":0}}}" + nodes);
  EXPECT_THAT(lines(text), HasSubstr(": lies deeper than 4096 nodes"));
}

TEST_F(GltfFiles, TextThatOpensAMillionArraysEndsInALine) {
  EXPECT_THAT(lines("{\"a\":" + std::string(1000000, '[')), HasSubstr("x.gltf: is no JSON"));
  EXPECT_THAT(lines("{\"a\":" + std::string(1000000, '[') + std::string(1000000, ']') + "}"),
              HasSubstr("x.gltf: asset.version"));
}

TEST_F(GltfFiles, BinaryFilesCutAnywhereEndInALine) {
  const auto word = [](std::size_t value) {
    std::string bytes;
    for (int i = 0; i < 4; ++i) bytes += static_cast<char>(value >> (8 * i) & 0xff);
    return bytes;
  };
  std::string text = kGltfText;
  text.append((4 - text.size() % 4) % 4, ' ');
  const std::string file =
      "glTF" + word(2) + word(20 + text.size()) + word(text.size()) + "JSON" + text;
  EXPECT_EQ(lines(file), "");
  for (std::size_t size = 1; size < file.size(); size += 97) {
    EXPECT_FALSE(read(file.substr(0, size)).is_ok()) << size;
    EXPECT_THAT(lines(file.substr(0, size)), HasSubstr("x.gltf: "));
  }
}

}  // namespace
}  // namespace tessera::import
