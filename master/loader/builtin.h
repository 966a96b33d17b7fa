// SPDX-License-Identifier: Apache-2.0
// The built-in scenes, one function each; small code, no files.
// Threads. Pure functions. A built-in scene has the same bits on every call: whoever names it means
// the same picture.
#pragma once

#include "master/loader/load_scene.h"

namespace tessera::master {

LoadedScene make_cornell();
LoadedScene make_paint();  // a teapot of patches in car paint, glass beside it, under a sky
LoadedScene make_room();
// The room, its lamp almost out, and a lantern that moves: only the light differs between times.
LoadedScene make_evening();
LoadedScene make_teapot();       // 32 bicubic patches
LoadedScene make_teapot_mesh();  // the same as 50,176 triangles
LoadedScene make_waves();
LoadedScene make_cones();          // 144 waving cones of 4 bicubic patches each
LoadedScene make_cones_mesh();     // the same as triangles
LoadedScene make_teapots();        // a cube of 32,768 teapots, each an instance of 32 patches
LoadedScene make_teapots_apart();  // the same as one surface of 1,048,576 patches
LoadedScene make_teapots_mesh();   // the same as instances of 4,096 triangles

// A quad in a horizontal plane that shines downwards.
class MeshMaker;
void add_ceiling_light(MeshMaker& maker, Vec3f centre, float half_x, float half_z,
                       std::uint32_t material);
std::shared_ptr<const PatchSurface> teapot_surface();
// Shape: cells of each patch in each direction, two triangles each.
std::shared_ptr<const Mesh> teapot_mesh(std::uint32_t cells);
Material matte(const char* name, Vec3f albedo);
Material glowing(const char* name, Vec3f emission);

}  // namespace tessera::master
