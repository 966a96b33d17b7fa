// Wavefront MTL: the materials of an OBJ file.
//
// What of a material becomes what of a scene (Alias, "The .mtl file format", 1992, and the lines
// Pr, Pm that later programs added):
//   Kd, Ke, map_Kd      albedo, emission, albedo texture
//   illum 3, 5 with Ks  mirror that reflects Ks, whatever Kd says
//   illum 7, or d < 1 with Ni
//                       glass of index Ni (1.5 without); Tf is what passes the body, so each of the
//                       two interfaces lets its square root through
//   Pr, Pm              glossy as in glTF: roughness, metalness, specular 0.04
//   Ks with Ns          glossy, with Ks reflected at normal incidence; the exponent Ns of Blinn's
//                       cosine lobe is the GGX of alpha = sqrt(2 / (Ns + 2)) (Walter et al.,
//                       "Microfacet models for refraction", 2007, section 5), and the roughness is
//                       the root of alpha. illum 0 and 1 say that there are no highlights
//   # tessera surface NAME key value ...
//                       a surface program (common/scene/surface_program.h) of the material it
//                       stands in; a colour has three values
// What is not understood: one warning for each name.
//
// Threads. One.
#pragma once

#include <map>
#include <optional>
#include <set>
#include <string>
#include <unordered_map>

#include "common/scene_io/scene_reader.h"
#include "common/scene_io/text_scanner.h"

namespace tessera {

class MtlReader {
 public:
  // Requires: both outlive it. Materials, textures and warnings are appended to `result`.
  MtlReader(ReadScene& result, const TextureLoader& load_texture)
      : result_(result), load_texture_(load_texture) {}

  // `text` of the file `path`, which stands in messages only.
  void read(const std::string& path, std::string_view text);
  // Returns: its index in the scene, of the last one of that name.
  std::optional<std::uint32_t> find(const std::string& name) const;

 private:
  // What a material's lines say before they are weighed against each other.
  struct Lines {
    std::optional<Vec3f> ks, tf;
    std::optional<float> ns, ni, d, pr, pm;
    int illum = -1;
  };

  void warn(const std::string& text);
  void warn_unknown(const std::string& name);
  void begin_material(const std::string& name);
  void read_line(TextScanner& line);
  bool read_light(TextScanner& line, const std::string& key);
  bool read_scattering(TextScanner& line, const std::string& key);
  void read_colour(TextScanner& line, const std::string& key, float high, Vec3f& colour);
  void read_number(TextScanner& line, const std::string& key, float low, float high,
                   std::optional<float>& number);
  void read_surface(TextScanner& line);
  void set_texture(std::string name);
  void finish_material();

  ReadScene& result_;
  const TextureLoader& load_texture_;
  std::unordered_map<std::string, std::uint32_t> index_;
  std::map<std::string, std::uint32_t> texture_index_;
  std::set<std::string> unknown_;

  // Of the file in progress.
  std::string path_;
  std::uint64_t line_number_ = 0;
  Material* material_ = nullptr;  // the last of the scene's, or null before the first newmtl
  Lines lines_;
};

}  // namespace tessera
