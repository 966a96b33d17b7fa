// SPDX-License-Identifier: Apache-2.0
// Textures of a glTF file: pictures and samplers become textures of the scene, each decoded once
// and kept once for every way in which it is used (colour or plain numbers, wrapping, filter).
//
// A picture that cannot be read becomes one warning, and its reference stays unset, so the surface
// shows the plain value. A sampler's minification filter is passed over: the samples of a pixel do
// its work.
// Threads. One.
#pragma once

#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <tuple>

#include "common/scene/scene.h"
#include "master/import/gltf/document.h"

namespace tessera::import {

// Decodes the bytes of a PNG, JPEG or WebP picture. Returns: a reason, which a message puts
// after the picture's name.
using PictureDecoder = std::function<Result<std::shared_ptr<const Texture>>(ByteSpan bytes)>;

enum class Encoding { kPlain, kColour };

class GltfTextures {
 public:
  // Requires: document and scene outlive it.
  GltfTextures(GltfDocument& document, PictureDecoder decode, Scene& scene)
      : document_(document), decode_(std::move(decode)), scene_(scene) {}

  // Reads a textureInfo (glTF 2.0, section 5.30, and KHR_texture_transform). `uv_set` of the answer
  // is the number of the file's TEXCOORD. `known`: keys of `info` besides index and texCoord.
  TextureRef read(const GltfObject& info, Encoding encoding,
                  std::initializer_list<std::string_view> known = {});

  // Roughness of a glossiness in the picture's alpha, as the green of another picture
  // (KHR_materials_pbrSpecularGlossiness): 1 - factor * alpha. Requires: source is set.
  TextureRef roughness_of_glossiness(const TextureRef& source, float factor);

 private:
  struct Sampler {
    TextureWrap wrap_u = TextureWrap::kRepeat, wrap_v = TextureWrap::kRepeat;
    bool is_nearest = false;
  };
  std::uint32_t texture(std::uint32_t index, Encoding encoding);
  std::optional<std::uint32_t> image_of(const GltfObject& texture);
  Sampler sampler(std::uint32_t index) const;
  std::shared_ptr<const Texture> image(std::uint32_t index);
  Result<std::shared_ptr<const Texture>> read_image(const GltfObject& source);
  std::uint32_t add(std::shared_ptr<const Texture> texture);

  GltfDocument& document_;
  const PictureDecoder decode_;
  Scene& scene_;
  std::map<std::uint32_t, std::shared_ptr<const Texture>> images_;  // null: unreadable
  std::map<std::tuple<std::uint32_t, Encoding, TextureWrap, TextureWrap, bool>, std::uint32_t>
      textures_;
};

}  // namespace tessera::import
