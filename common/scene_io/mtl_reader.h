// SPDX-License-Identifier: Apache-2.0
// Wavefront MTL: the materials of an OBJ file.
//
// How lines of the file become materials of the scene (Alias, "The .mtl file format", 1992, and the
// lines that later programs added: Pr, Pm, Ps, Pc, Pcr, aniso, anisor, Ke, norm):
//   Kd, Ke, map_Kd, map_Ke
//                       albedo, emission and what multiplies them
//   d, Tr, map_d        opacity; Tr is 1 - d, and d counts where both are said
//   bump, norm          heights (texels.h says how high white is) and normals; -bm scales both. A
//                       normal map given as bump is told by its content
//   illum 6, 7, or d < 1 with Ni > 1 and without illum
//                       glass of index Ni (1.5 without); Tf is what passes the body, so each of the
//                       two interfaces lets its square root through. With Pr: rough
//   illum 4, 9          glass that does not bend light: a thin sheet that lets Tf through, 1 - d of
//                       it where d says so. With map_d it is opacity that the picture means
//   illum 3, 5 with Ks  mirror that reflects Ks, where Kd is below 0.05; else glossy above Kd
//   Pr, Pm, map_Pr, map_Pm
//                       glossy as in glTF: roughness, metalness, specular 0.04
//   Ks with Ns          glossy, with Ks (times map_Ks) reflected at normal incidence; the exponent
//                       Ns (times map_Ns) of Blinn's cosine lobe is the GGX of alpha = sqrt(2 / (Ns
//                       + 2)) (Walter et al., "Microfacet models for refraction", 2007, section 5),
//                       and the roughness is the root of alpha. illum 0 and 1 say that there are no
//                       highlights
//   Ps, Pc, Pcr, aniso, anisor
//                       sheen, clearcoat and its roughness, anisotropy and its turns of a glossy
//                       surface
//   Kd xyz X Y Z        CIE XYZ (D65) instead of RGB, of each colour
//   # tessera bsdf NAME a BSDF of common/scene/bsdf_kinds.inc, whatever else the material says; Ks,
//                       Ni, Pm and Pr (or Ns) are what it may look at
//   # tessera surface NAME key value ...
//                       a surface program (common/scene/surface_program.h) of the material it
//                       stands in; a colour has three values
// Options of pictures stand in mtl_texture.h. What is not understood or not drawn gives one warning
// for each kind.
//
// Threads. One.
#pragma once

#include <map>
#include <optional>
#include <string>
#include <unordered_map>

#include "common/scene_io/mtl_material.h"
#include "common/scene_io/scene_pictures.h"
#include "common/scene_io/scene_reader.h"
#include "common/scene_io/text_scanner.h"
#include "common/scene_io/warning_group.h"

namespace tessera {

class MtlReader {
 public:
  // Requires: both arguments outlive the reader. Materials, textures and warnings are appended to
  // `result`.
  MtlReader(ReadScene& result, const TextureLoader& load_texture)
      : result_(result), pictures_(result.scene, load_texture) {}

  // Reads `text`, the contents of the file `path`, which is named in messages only.
  void read(const std::string& path, std::string_view text);
  // Returns: the index in the scene of the last material of that name.
  std::optional<std::uint32_t> find(const std::string& name) const;

 private:
  void warn(const std::string& kind, const std::string& text);
  void warn_unknown(const std::string& name);
  void begin_material(const std::string& name);
  void read_line(TextScanner& line);
  bool read_color_line(TextScanner& line, const std::string& key);
  bool read_number_line(TextScanner& line, const std::string& key);
  bool read_picture_line(TextScanner& line, const std::string& key);
  bool pass_over(TextScanner& line, const std::string& key);
  void read_color(TextScanner& line, const std::string& key, float high,
                  std::optional<Vec3f>& color);
  void read_number(TextScanner& line, const std::string& key, float low, float high,
                   std::optional<float>& number);
  void read_illum(TextScanner& line);
  void read_extension(TextScanner& line);
  void read_bsdf(TextScanner& line);
  void read_surface(TextScanner& line);
  void finish_material();
  void finish_file();

  ReadScene& result_;
  ScenePictures pictures_;
  std::unordered_map<std::string, std::uint32_t> index_;

  // State of the file in progress.
  std::optional<WarningGroup> warnings_;
  std::uint64_t line_number_ = 0;
  Material* material_ = nullptr;  // the scene's last one, or null before the first newmtl
  MtlLines lines_;
  std::map<std::string, std::uint64_t> passed_over_;  // key -> how often
};

}  // namespace tessera
