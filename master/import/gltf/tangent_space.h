// SPDX-License-Identifier: Apache-2.0
// Tangents for normal maps, as programs that bake such maps compute them (Mikkelsen, "Simulation of
// wrinkled surfaces revisited", 2008, chapter 4, known as MikkTSpace). glTF 2.0, section 3.7.2.1,
// asks for these tangents where a file has none.
//
// Corners that agree in position, normal and texture coordinates are one vertex, whatever the
// file's indices say. Around each vertex, triangles that are joined by edges and whose coordinates
// turn the same way share one tangent: the mean of theirs, each projected onto the plane of the
// normal and weighted by the angle of its corner there. Triangles without an area in the picture
// take part in a group and add nothing to it.
//
// Threads. Pure function. Memory: some 150 bytes for each triangle.
#pragma once

#include "common/scene/scene.h"

namespace tessera::import {

// Fills mesh.tangents from positions, normals and `uvs` (mesh.uvs or mesh.uvs1). A vertex that
// needs several tangents is copied: the copies stand behind the others and triangles keep their
// order. Requires: positions, normals and `uvs` are finite; normals and `uvs` are not empty.
void make_tangents(Mesh& mesh, const std::vector<Vec2f>& uvs);

}  // namespace tessera::import
