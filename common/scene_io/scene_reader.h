// SPDX-License-Identifier: Apache-2.0
// What every scene reader returns and asks for.
//
// Readers keep the order of the file: triangle i of the flattened scene is the i-th of the file,
// polygons cut into corners - 2 triangles (polygon.h). Degenerate triangles keep their number and
// are counted in one warning. A non-finite coordinate or an index out of range refuses the file,
// naming element and line.
#pragma once

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "common/base/status.h"
#include "common/scene/scene.h"

namespace tessera {

struct ReadScene {
  Scene scene;
  std::vector<std::string> warnings;  // one line each
};

// Loads the picture that a scene file names by `name` (as written in the file). Returns: a refusal
// becomes a warning.
using TextureLoader =
    std::function<Result<std::shared_ptr<const Texture>>(const std::string& name)>;

// Wavefront OBJ with MTL (mtl_reader.h). The MTL file must lie below the OBJ file's folder.
Result<ReadScene> read_obj(const std::string& path, const TextureLoader& load_texture);

// PLY, ascii and binary in both byte orders, with normals, texture coordinates and colours of
// vertices, texture coordinates of corners, and the picture that a comment "TextureFile" names.
Result<ReadScene> read_ply(const std::string& path, const TextureLoader& load_texture = {});

// STL, binary and text; flat, in the colour of the default material.
Result<ReadScene> read_stl(const std::string& path);

// BPT: Bezier patches with weights and trimming loops, the format that bpt_reader.cpp describes.
// Patch i of the scene is the i-th of the file; loops lie in [0, 1]^2.
Result<ReadScene> read_bpt(const std::string& path);

// How many triangles of the mesh have no area, by equal corners or a zero cross product.
std::uint64_t count_degenerate(const Mesh& mesh);
void warn_degenerate(std::uint64_t count, std::vector<std::string>& warnings);

}  // namespace tessera
