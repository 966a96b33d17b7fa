// Surface detail: what hits have beyond the plain geometry of their triangles, as the kernels see it.
// Fixed-size types only and no functions.
#pragma once

#include <stdint.h>

#include "slave/core/surface/texture_layout.h"

namespace tessera::core {

inline constexpr int kDetailPoints = 64;  // of a packet

// What points have in common: they are of one instance and one material.
struct DetailGroup {
  bool has_normals;        // of vertices
  bool is_moved;           // by normal_map; otherwise they are in world space already
  float normal_map[3][3];  // by rows
  bool is_diffuse;         // no direction to the viewer is asked for
  bool has_program;        // a place and a footprint are
  bool has_texture;        // there are texture coordinates to look at some with
  // Null: none.
  const TextureView* albedo_texture;
  const TextureView* emission_texture;
  const TextureView* roughness_metalness_texture;
  const TextureView* normal_texture;
  float normal_scale;
};

// Shape of all: [kDetailPoints]. Corners are A, B, C of triangles.
struct alignas(64) DetailPoints {
  // Told; the arrays that the group has no use for are not looked at.
  float u[kDetailPoints], v[kDetailPoints];
  float direction[3][kDetailPoints];  // of the ray
  float normal[3][kDetailPoints];     // geometric, unit, turned to the viewer
  float cone_width[kDetailPoints];    // of the ray's cone, here
  float corner[3][3][kDetailPoints];  // [corner][axis], world units: has a texture or a program
  float corner_normal[3][3][kDetailPoints];  // as the mesh has them
  float corner_uv[3][2][kDetailPoints];
  float corner_of_mesh[3][3][kDetailPoints];  // before the transform: has_program

  // Made.
  float shading_normal[3][kDetailPoints];
  float to_viewer[3][kDetailPoints];
  // What textures give; set where the group has them.
  float albedo[3][kDetailPoints], emission[3][kDetailPoints];
  float roughness[kDetailPoints], metalness[kDetailPoints];
  // For programs: see SurfacePlaces in slave/core/surface/programs.h.
  float place[3][kDetailPoints], place_normal[3][kDetailPoints], footprint[kDetailPoints];

  int32_t count;
  uint64_t front;  // bits: see PacketPoints
};

}  // namespace tessera::core
