// SPDX-License-Identifier: Apache-2.0
// Surface detail: what hits have beyond the plain geometry of their triangles, as the kernels see
// it. Fixed-size types only and no functions.
#pragma once

#include <stdint.h>

#include "slave/core/surface/texture_layout.h"

namespace tessera::core {

inline constexpr int kDetailPoints = 64;  // of a packet

// What a texture of a material is looked up for.
enum TextureUse : int32_t {
  kAlbedoTexture,
  kEmissionTexture,
  kRoughnessMetalnessTexture,  // green and blue
  kNormalTexture,              // turns the shading normal; its texels are not kept
  kSpecularTexture,            // alpha
  kSpecularColorTexture,
  kClearcoatTexture,           // red
  kClearcoatRoughnessTexture,  // green
  kClearcoatNormalTexture,     // turns the varnish's normal; its texels are not kept
  kSheenColorTexture,
  kSheenRoughnessTexture,  // alpha
  kTransmissionTexture,    // red
  kAnisotropyTexture,      // red, green: direction; blue: strength
  kTextureUses
};
// Bits of the uses whose alpha is looked up, too.
inline constexpr uint32_t kUsesWithAlpha = 1u << kSpecularTexture | 1u << kSheenRoughnessTexture;

// How textures lie on a mesh.
struct TexturePlace {
  int32_t uv_set;   // of the mesh
  bool is_moved;    // by uv_map
  float uv_map[6];  // rows of the affine map from coordinates of the mesh to those of the picture
  uint32_t uses;    // bits of the uses whose textures lie so
};

// The textures of a material: those that lie alike are looked up together.
struct TextureTable {
  int32_t place_count;
  TexturePlace place[kTextureUses];
  const TextureView* texture[kTextureUses];  // null: none
  uint32_t uses_of_set[2];                   // bits, by set of coordinates
};

// What points have in common: they are of one instance and one material.
struct DetailGroup {
  bool has_normals;              // of vertices
  bool has_colors;               // of vertices, not looked at here
  bool is_moved;                 // by normal_map; otherwise they are in world space already
  float normal_map[3][3];        // by rows
  bool is_diffuse;               // no direction to the viewer is asked for
  bool has_program;              // a place and a footprint are asked for
  uint32_t uses;                 // bits: of textures that the mesh has coordinates for
  const TextureTable* textures;  // not looked at without uses
  float normal_scale;
  bool has_coat;            // its normal is asked for
  bool has_tangents;        // of vertices; they replace those of texture coordinates
  bool is_stretched;        // the directions of rising coordinates are asked for
  float tangent_map[3][3];  // by rows, of tangents of vertices
  float coat_normal_scale;
};

// Shape of all: [kDetailPoints]. Corners are A, B, C of triangles.
struct alignas(64) DetailPoints {
  // Input; the arrays that the group has no use for are not looked at.
  float u[kDetailPoints], v[kDetailPoints];
  float direction[3][kDetailPoints];  // of the ray
  float normal[3][kDetailPoints];     // geometric, unit, turned to the viewer
  float cone_width[kDetailPoints];    // of the ray's cone, here
  float corner[3][3][kDetailPoints];  // [corner][axis], world units: has textures or a program
  float corner_normal[3][3][kDetailPoints];   // as the mesh has them
  float corner_uv[2][3][2][kDetailPoints];    // by set
  float corner_of_mesh[3][3][kDetailPoints];  // before the transform: has_program
  float corner_tangent[3][3][kDetailPoints];  // as the mesh has them: has_tangents
  float handedness[kDetailPoints];            // likewise: +1 or -1, of the triangle

  // Output.
  float shading_normal[3][kDetailPoints];
  float to_viewer[3][kDetailPoints];
  // What textures show; set where the group has the use.
  float texel[kTextureUses][3][kDetailPoints];
  float texel_alpha[kTextureUses][kDetailPoints];  // of kUsesWithAlpha
  float coat_normal[3][kDetailPoints];             // has_coat
  // Tangents, unit, perpendicular to the shading normal; not finite where there are none. Set where
  // is_stretched.
  float along_u[3][kDetailPoints], along_v[3][kDetailPoints];
  // For programs: see SurfacePlaces in slave/core/surface/programs.h.
  float place[3][kDetailPoints], place_normal[3][kDetailPoints], footprint[kDetailPoints];

  int32_t count;
  uint64_t front;  // bits: see PacketPoints
};

}  // namespace tessera::core
