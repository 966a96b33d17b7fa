// SPDX-License-Identifier: Apache-2.0
// The pictures that a scene file names as textures of the scene: each file is decoded once, and
// kept once for every way in which it is used (colour, plain numbers, one channel, heights).
//
// A picture that cannot be had becomes one warning, and its reference stays unset. Threads. One.
#pragma once

#include <functional>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "common/scene_io/scene_reader.h"
#include "common/scene_io/warning_group.h"

namespace tessera {

// One use of a picture by a material.
struct PictureUse {
  std::string where;         // "line 7: map_Kd", which opens messages
  std::string name;          // of the picture, as TextureLoader takes it; '/' between folders
  Vec2f scale{1, 1};         // coordinates of the picture are scale * those of the mesh
  Vec2f offset{0, 0};        // + offset
  float bump = 1;            // multiplies heights or slopes
  float base = 0, gain = 1;  // what the picture holds is base + gain * texel
  TextureWrap wrap_u = TextureWrap::kRepeat, wrap_v = TextureWrap::kRepeat;
  bool is_nearest = false;
  char channel = 0;  // of a picture of numbers: r g b m (alpha) l z (luminance); 0: by its content
  std::vector<std::string> not_drawn;  // options of the file that are left out, for a warning
};

class ScenePictures {
 public:
  // Requires: both arguments outlive this object.
  ScenePictures(Scene& scene, const TextureLoader& load) : scene_(scene), load_(load) {}

  // Sends warnings to `warnings` from now on. Requires: it outlives the calls that follow.
  void set_warnings(WarningGroup* warnings) { warnings_ = warnings; }

  TextureRef color(const PictureUse& source);   // by the picture's own encoding
  TextureRef normal(const PictureUse& source);  // a normal map
  // Heights, or a normal map in their place, which is recognised by its content; in that case
  // `scale` is the material's normal_scale.
  TextureRef bump(const PictureUse& source, float& scale);
  // Opacity from the channel that the use names; where it names none, from the picture's alpha, or
  // from its luminance where it has no alpha.
  TextureRef opacity(const PictureUse& source, std::uint32_t& channel);
  // Roughness in green and metalness in blue, from two pictures or one; null: 1 in that channel.
  TextureRef roughness_metalness(const PictureUse* roughness, const PictureUse* metalness);
  // The roughness that a material of the exponent `ns` times the picture has, in green.
  TextureRef roughness_of_exponents(const PictureUse& source, float ns);
  // Whether the picture of a colour has any alpha below 1.
  bool has_alpha(const PictureUse& source);

 private:
  using Maker = std::function<std::shared_ptr<const Texture>(const Texture& picture)>;

  // Returns: the picture with base and gain, wrapping and filter applied; null where there is none.
  std::shared_ptr<const Texture> picture(const PictureUse& source);
  std::shared_ptr<const Texture> load(const PictureUse& source);
  // The texture that `make` makes of the picture, once for each `use`.
  TextureRef use(const PictureUse& source, const std::string& use, const Maker& make);
  void warn_of_options(const PictureUse& source);

  Scene& scene_;
  const TextureLoader& load_;
  WarningGroup* warnings_ = nullptr;
  std::map<std::string, std::shared_ptr<const Texture>> files_, pictures_;
  std::map<std::string, std::uint32_t> uses_;
};

// GGX roughness of Blinn's exponent (Walter et al., "Microfacet models for refraction", 2007,
// section 5): the root of alpha = sqrt(2 / (exponent + 2)).
float roughness_of_exponent(float exponent);

}  // namespace tessera
