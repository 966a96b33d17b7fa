// SPDX-License-Identifier: Apache-2.0
// The lines of one material of an MTL file, before they are weighed against each other, and the
// material of the scene that they amount to. mtl_reader.h says which line means what.
//
// Threads. One.
#pragma once

#include <map>
#include <optional>
#include <string>

#include "common/scene_io/mtl_texture.h"
#include "common/scene_io/scene_pictures.h"

namespace tessera {

struct MtlLines {
  std::optional<Vec3f> kd, ks, ke, tf;
  std::optional<float> ns, ni, d, tr, pr, pm, ps, pc, pcr, aniso, anisor;
  int illum = -1;
  std::optional<BsdfKind> bsdf;                // counts whatever the other lines say
  std::map<std::string, PictureUse> pictures;  // by key, in one spelling: "map_Kd", "bump"
};

// Requires: `material` has its name and its surface program. Warnings name line or material.
void apply_mtl_lines(const MtlLines& lines, ScenePictures& pictures, WarningGroup& warnings,
                     Material& material);

}  // namespace tessera
