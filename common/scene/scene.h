// The scene as plain values: what an application describes and what travels to slaves.
//
// A Scene is immutable once committed; meshes and textures are shared between versions by pointer,
// so that a version that changes one mesh copies nothing else. validate_scene() (validate.h) is the
// border; everything behind it trusts.
//
// Primitive numbering. Triangles are numbered over the flattened scene: instances in order, within
// each the triangles of its mesh in order. Readers keep the order of the file.
//
// Units. Lengths in scene units; radiance, intensity and power linear RGB (Rec. 709 primaries).
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "common/base/api.h"
#include "common/math/transform.h"
#include "common/math/vec3.h"
#include "common/scene/camera.h"
#include "common/scene/surface_program.h"

namespace tessera {

inline constexpr std::uint32_t kNoTexture = 0xffffffffu;

// Geometric normal of triangle (A, B, C) is along (B - A) x (C - A).
struct Mesh {
  std::vector<Vec3f> positions;                         // [vertex_count]
  std::vector<Vec3f> normals;                           // [vertex_count] or empty: flat shading
  std::vector<Vec2f> uvs;                               // [vertex_count] or empty
  std::vector<std::array<std::uint32_t, 3>> triangles;  // [triangle_count], vertex indices
  std::vector<std::uint32_t> materials;  // [triangle_count], or 1 for all; never empty
  bool operator==(const Mesh&) const = default;
};

// 8-bit texels; colour textures are sRGB-encoded, row 0 is at v = 1 (image top), repeat wrapping.
struct Texture {
  int width_px = 0;
  int height_px = 0;
  bool is_srgb = true;
  std::vector<std::uint8_t> rgba;  // [4 * width_px * height_px]
  bool operator==(const Texture&) const = default;
};

// Light from far away, by direction: a latitude-longitude picture. Row 0 looks up, along +y; column 0
// and the last meet at +z behind, the middle one is -z, and columns rise towards +x. Linear; between
// texels it is bilinear.
struct EnvironmentMap {
  int width_px = 0;
  int height_px = 0;
  std::vector<float> rgb;  // [3 * width_px * height_px], radiance
  bool operator==(const EnvironmentMap&) const = default;
};

// How a surface scatters light: the BSDF part of a material (slave/core/bsdf).
enum class BsdfKind : std::uint8_t {
  kDiffuse = 0,  // Lambert: albedo
  kGlossy = 1,   // Lambert below a microfacet lobe: albedo, specular, roughness, metalness
  kMirror = 2,   // specular
  kGlass = 3     // smooth: ior, specular
};
inline constexpr float kIorMin = 1, kIorMax = 4;  // glass; diamond has 2.4, germanium 4

// Emission is one-sided, along the geometric normal.
struct Material {
  std::string name;
  Vec3f albedo{0.8f, 0.8f, 0.8f};  // in [0, 1]; multiplied by the texture where there is one
  Vec3f emission{0, 0, 0};         // radiance
  std::uint32_t albedo_texture = kNoTexture;    // index into Scene::textures, as all textures here
  std::uint32_t emission_texture = kNoTexture;  // multiplies emission
  BsdfKind bsdf = BsdfKind::kDiffuse;
  // In [0, 1]. Mirror: what it reflects. Glossy: what reflects at normal incidence where it is no
  // metal. Glass: what passes one interface.
  Vec3f specular{0.04f, 0.04f, 0.04f};
  float roughness = 1;  // glossy, in [0, 1]: its square is the width alpha of GGX, as in glTF
  float metalness =
      0;             // glossy, in [0, 1]: metals have the albedo as specular, and no diffuse part
  float ior = 1.5f;  // glass, inside to outside, in [kIorMin, kIorMax]
  // Glossy: multiplies roughness by green and metalness by blue, as in glTF.
  std::uint32_t roughness_metalness_texture = kNoTexture;
  // Of the shading normal in the frame of the texture coordinates, as in glTF: x along rising u, y
  // along rising v, each times normal_scale, z outward. Linear.
  std::uint32_t normal_texture = kNoTexture;
  float normal_scale = 1;
  SurfaceProgram surface{};  // makes the albedo vary without a texture
  bool operator==(const Material&) const = default;
};

enum class LightKind : std::uint8_t { kPoint = 0, kSpot = 1, kDirectional = 2 };

struct Light {
  LightKind kind = LightKind::kPoint;
  Vec3f position{};           // point, spot
  Vec3f direction{0, -1, 0};  // spot, directional: the way light travels; need not be normalised
  Vec3f intensity{1, 1, 1};   // point, spot: W/sr; directional: irradiance on a facing surface
  float cos_inner = 1;        // spot: full intensity inside this cone
  float cos_outer = 0;        // spot: none outside; smooth in between
  bool operator==(const Light&) const = default;
};

struct Instance {
  std::uint32_t mesh = 0;  // index into Scene::meshes
  Transform object_to_world;
  bool operator==(const Instance&) const = default;
};

struct TESSERA_API Scene {
  std::vector<std::shared_ptr<const Mesh>> meshes;
  std::vector<std::shared_ptr<const Texture>> textures;
  std::vector<Material> materials;  // never empty in a valid scene
  std::vector<Instance> instances;
  std::vector<Light> lights;
  Vec3f environment{0, 0, 0};  // radiance from every direction in which there is nothing;
  std::shared_ptr<const EnvironmentMap> environment_map;  // multiplied by this, where there is one
  std::optional<Camera> camera;

  std::uint64_t triangle_count() const;  // flattened over instances
};

}  // namespace tessera
