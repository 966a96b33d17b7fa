// SPDX-License-Identifier: Apache-2.0
// The scene as plain values: what an application describes and what travels to slaves.
//
// A Scene is immutable once committed; meshes and textures are shared between versions by pointer,
// so that a version that changes one mesh copies nothing else. validate_scene() (validate.h) is the
// border; everything behind it trusts.
//
// Primitive numbering. Triangles and patches are numbered over the flattened scene: instances in
// order, within each the triangles of its mesh, or the patches of its surface, in order. Readers
// keep the order of the file.
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
#include "common/scene/bsdf_kind.h"
#include "common/scene/camera.h"
#include "common/scene/patch_surface.h"
#include "common/scene/surface_program.h"

namespace tessera {

struct SceneAnimation;  // animation.h

inline constexpr std::uint32_t kNoTexture = 0xffffffffu;

// Geometric normal of triangle (A, B, C) is along (B - A) x (C - A).
struct Mesh {
  std::vector<Vec3f> positions;  // [vertex_count]
  std::vector<Vec3f> normals;    // [vertex_count] or empty: flat shading
  std::vector<Vec2f> uvs;        // [vertex_count] or empty
  std::vector<Vec2f> uvs1;       // the second set, likewise
  std::vector<Vec4f> tangents;   // [vertex_count] or empty: x, y, z along rising u; w: +1 or -1
  std::vector<Vec4f> colors;  // [vertex_count] or empty: linear, times albedo and opacity; [0, 1]
  std::vector<std::array<std::uint32_t, 3>> triangles;  // [triangle_count], vertex indices
  std::vector<std::uint32_t> materials;  // [triangle_count], or 1 for all; never empty
  bool operator==(const Mesh&) const = default;
};

// What a texture shows beyond its edges.
enum class TextureWrap : std::uint8_t { kRepeat = 0, kMirror = 1, kClamp = 2 };

// Texels of 8 or 16 bits; colour textures are sRGB-encoded, alpha never is. Row 0 is at v = 1
// (image top). Exactly one of the two arrays is filled.
struct Texture {
  int width_px = 0;
  int height_px = 0;
  bool is_srgb = true;
  TextureWrap wrap_u = TextureWrap::kRepeat, wrap_v = TextureWrap::kRepeat;
  bool is_nearest = false;            // magnified without interpolation: texels stay squares
  std::vector<std::uint8_t> rgba;     // [4 * width_px * height_px]
  std::vector<std::uint16_t> rgba16;  // texels of 16 bits, likewise
  bool operator==(const Texture&) const = default;
};

// Which texture a surface shows, and how it lies there.
struct TextureRef {
  std::uint32_t index = kNoTexture;  // into Scene::textures
  std::uint32_t uv_set = 0;          // 0: Mesh::uvs, 1: Mesh::uvs1
  // Rows of the affine map from coordinates of the mesh to those of the picture.
  std::array<float, 6> uv_map{1, 0, 0, 0, 1, 0};

  // Refers to a texture that lies as the mesh's coordinates have it.
  TextureRef(std::uint32_t texture = kNoTexture) : index(texture) {}
  bool is_set() const { return index != kNoTexture; }
  bool operator==(const TextureRef&) const = default;
};

// Light from far away, by direction: a latitude-longitude picture. Row 0 looks up, along +y; column
// 0 and the last meet at +z behind, the middle one is -z, and columns rise towards +x. Linear;
// between texels it is bilinear.
struct EnvironmentMap {
  int width_px = 0;
  int height_px = 0;
  std::vector<float> rgb;  // [3 * width_px * height_px], radiance
  bool operator==(const EnvironmentMap&) const = default;
};

inline constexpr float kIorMin = 1, kIorMax = 4;  // glass; diamond has 2.4, germanium 4

// Whether rays pass a surface as if it were not there.
enum class AlphaMode : std::uint8_t {
  kOpaque = 0,  // rays never pass
  kMask = 1,    // where opacity is below the cutoff
  kBlend = 2    // a share of 1 - opacity of them
};

// Opacity is value times the texture's channel times the vertices' alpha.
struct Alpha {
  AlphaMode mode = AlphaMode::kOpaque;
  float value = 1;      // in [0, 1]
  float cutoff = 0.5f;  // of kMask, >= 0
  TextureRef texture;
  std::uint32_t channel = 3;  // of the texture: 0 red to 3 alpha
  bool operator==(const Alpha&) const = default;
};

// The optional lobes of a glossy surface, after the extensions of glTF 2.0 with the same names.
// With the values that stand here each is absent.

// A layer of varnish, ior 1.5, over all else (KHR_materials_clearcoat).
struct Clearcoat {
  float weight = 0;              // in [0, 1]
  float roughness = 0;           // in [0, 1]
  TextureRef weight_texture;     // red
  TextureRef roughness_texture;  // green
  TextureRef normal_texture;     // of the varnish alone; none: the geometry's normal
  float normal_scale = 1;
  bool operator==(const Clearcoat&) const = default;
};

// Fibres that stand on the surface: velvet, satin (KHR_materials_sheen).
struct Sheen {
  Vec3f color{0, 0, 0};          // in [0, 1]
  float roughness = 0;           // in [0, 1]
  TextureRef color_texture;      // sRGB
  TextureRef roughness_texture;  // alpha
  bool operator==(const Sheen&) const = default;
};

// Light that passes the surface instead of being scattered back by what lies below it
// (KHR_materials_transmission, KHR_materials_volume). Albedo tints it, roughness blurs it.
struct Transmission {
  float weight = 0;           // in [0, 1]
  TextureRef weight_texture;  // red
  bool is_thin = true;        // a sheet without inside: light goes on in its direction
  // For glass, and where is_thin is false: the share of light left after attenuation_distance
  // inside (Beer's law).
  Vec3f attenuation_color{1, 1, 1};  // in [0, 1]
  float attenuation_distance = 0;    // world units; 0: nothing is absorbed
  bool operator==(const Transmission&) const = default;
};

// The microfacet lobe is longer along one direction of the surface (KHR_materials_anisotropy).
struct Anisotropy {
  float strength = 0;  // in [0, 1]
  float rotation = 0;  // radians from the tangent towards rising v
  TextureRef texture;  // red, green: direction; blue: strength
  bool operator==(const Anisotropy&) const = default;
};

// Emission is one-sided, along the geometric normal.
struct Material {
  std::string name;
  Vec3f albedo{0.8f, 0.8f, 0.8f};  // in [0, 1]; multiplied by the texture where there is one
  Vec3f emission{0, 0, 0};         // radiance
  TextureRef albedo_texture;
  TextureRef emission_texture;  // multiplies emission
  BsdfKind bsdf = BsdfKind::kDiffuse;
  // In [0, 1]. Mirror: its reflectance. Glossy: the reflectance at normal incidence where it is no
  // metal. Glass: what passes one interface.
  Vec3f specular{0.04f, 0.04f, 0.04f};
  float roughness = 1;  // glossy, in [0, 1]: its square is the width alpha of GGX, as in glTF
  float metalness =
      0;             // glossy, in [0, 1]: metals have the albedo as specular, and no diffuse part
  float ior = 1.5f;  // glass, inside to outside, in [kIorMin, kIorMax]
  // Glossy: multiplies roughness by green and metalness by blue, as in glTF.
  TextureRef roughness_metalness_texture;
  // The shading normal in the frame of the texture coordinates, as in glTF: x along rising u, y
  // along rising v, each times normal_scale, z outward. The values are linear.
  TextureRef normal_texture;
  float normal_scale = 1;
  // Glossy, where it is no metal (KHR_materials_specular): the reflectance at grazing incidence, in
  // [0, 1]. Textures multiply both reflectances (alpha) and `specular` (RGB, sRGB).
  float specular_f90 = 1;
  TextureRef specular_texture, specular_color_texture;
  Clearcoat clearcoat;
  Sheen sheen;
  Transmission transmission;
  Anisotropy anisotropy;
  Alpha alpha;
  bool is_double_sided = false;  // emission goes to both sides
  bool is_unlit = false;     // the camera sees albedo as radiance; lights and other surfaces do not
  SurfaceProgram surface{};  // makes the albedo vary without a texture
  bool operator==(const Material&) const = default;
};

// All texture references of a material, set or not.
std::array<const TextureRef*, 14> textures_of(const Material& material);

enum class LightKind : std::uint8_t { kPoint = 0, kSpot = 1, kDirectional = 2 };

struct Light {
  LightKind kind = LightKind::kPoint;
  Vec3f position{};           // point, spot
  Vec3f direction{0, -1, 0};  // spot, directional: the way light travels; need not be normalised
  Vec3f intensity{1, 1, 1};   // point, spot: W/sr; directional: irradiance on a facing surface
  float cos_inner = 1;        // spot: full intensity inside this cone
  // Spot: no light outside this cone. In between, light is the square of a ramp in the cosine.
  float cos_outer = 0;
  bool operator==(const Light&) const = default;
};

enum class ObjectKind : std::uint32_t { kMesh = 0, kPatchSurface = 1 };

struct Instance {
  std::uint32_t mesh = 0;  // index into Scene::meshes, or into Scene::surfaces: see kind
  Transform object_to_world;
  ObjectKind kind = ObjectKind::kMesh;
  bool operator==(const Instance&) const = default;
};

// What camera rays see that miss everything: the environment, or a picture that lights nothing and
// that no surface reflects.
enum class BackgroundKind : std::uint8_t {
  kSky = 0,      // the environment
  kGradient = 1  // from `low` at 30 degrees below the horizon to `high` at 30 above it
};
struct Background {
  BackgroundKind kind = BackgroundKind::kSky;
  Vec3f low{0, 0, 0}, high{0, 0, 0};  // radiance, >= 0
  bool operator==(const Background&) const = default;
};

// A camera of the file, for a person to choose by number or name.
struct NamedCamera {
  std::string name;
  Camera camera;
  bool operator==(const NamedCamera&) const = default;
};

struct TESSERA_API Scene {
  std::vector<std::shared_ptr<const Mesh>> meshes;
  std::vector<std::shared_ptr<const PatchSurface>> surfaces;
  std::vector<std::shared_ptr<const Texture>> textures;
  std::vector<Material> materials;  // never empty in a valid scene
  std::vector<Instance> instances;
  std::vector<Light> lights;
  Vec3f environment{0, 0, 0};  // radiance from every direction in which there is nothing
  std::shared_ptr<const EnvironmentMap> environment_map;  // or null; multiplies `environment`
  Background background;
  std::optional<Camera> camera;
  std::vector<NamedCamera> cameras;  // all of the file, `camera` too
  // What of the above moves with a frame's time, or null; pose.h makes the scene of a time.
  std::shared_ptr<const SceneAnimation> animation;

  // Flattened over instances.
  std::uint64_t triangle_count() const;
  std::uint64_t patch_count() const;
};

}  // namespace tessera
