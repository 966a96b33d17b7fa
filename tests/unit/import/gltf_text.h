// SPDX-License-Identifier: Apache-2.0
// A small glTF file as text, with one thing changed, and what the reader makes of it.
// Threads. One at a time for each folder.
#pragma once

#include <gtest/gtest.h>

#include "master/import/gltf/reader.h"
#include "tests/support/temp_folder.h"

namespace tessera::import {

// One triangle with a material, a lamp and a camera. Tests replace parts of it by with().
inline const std::string kGltfText =
    R"({"asset":{"version":"2.0"},"scene":0,"scenes":[{"nodes":[0,1,2]}],
"extensionsUsed":["KHR_lights_punctual"],
"extensions":{"KHR_lights_punctual":{"lights":[{"type":"spot","name":"Key","intensity":683}]}},
"nodes":[{"mesh":0},{"camera":0,"name":"Eye","translation":[0,0,5]},
{"extensions":{"KHR_lights_punctual":{"light":0}}}],
"cameras":[{"type":"perspective","perspective":{"yfov":0.5,"znear":0.1}}],
"materials":[{"name":"Leaf","pbrMetallicRoughness":{"roughnessFactor":0.5}}],
"meshes":[{"primitives":[{"attributes":{"POSITION":0},"material":0}]}],
"accessors":[{"bufferView":0,"componentType":5126,"count":3,"type":"VEC3"}],
"bufferViews":[{"buffer":0,"byteLength":36}],
"buffers":[{"byteLength":36,"uri":"data:application/octet-stream;base64,AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAgD8AAAAA"}]})";

inline std::string with(std::string text, const std::string& from, const std::string& to) {
  const auto at = text.find(from);
  EXPECT_NE(at, std::string::npos) << from;
  return at == std::string::npos ? text : text.replace(at, from.size(), to);
}

class GltfFiles : public ::testing::Test {
 protected:
  Result<ReadScene> read(const std::string& text) {
    return read_gltf(folder_.write("x.gltf", text),
                     [](ByteSpan) -> Result<std::shared_ptr<const Texture>> {
                       auto texture = std::make_shared<Texture>();
                       texture->width_px = texture->height_px = 1;
                       texture->rgba = {255, 128, 64, 51};
                       return std::shared_ptr<const Texture>(std::move(texture));
                     });
  }
  // Returns: all lines that the reader reports for `text`, without the path of the folder.
  std::string lines(const std::string& text) {
    const auto result = read(text);
    std::string all = result.is_ok() ? "" : result.status().message();
    if (result.is_ok()) {
      for (const std::string& line : result->warnings) all += line + "\n";
    }
    for (auto at = all.find(folder_ / ""); at != std::string::npos; at = all.find(folder_ / ""))
      all.erase(at, (folder_ / "").size());
    return all;
  }

  const test::TempFolder folder_;
};

}  // namespace tessera::import
