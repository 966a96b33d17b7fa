// The inside of PreparedScene, for the renderer, tests and tools that trace rays of their own.
// Threads. Immutable after construction, as prepared_scene.h says.
#pragma once

#include <memory>
#include <vector>

#include "slave/core/accel/spatial_index.h"
#include "slave/core/geometry/triangle_store.h"
#include "slave/core/light/light_set.h"
#include "slave/core/render/prepared_scene.h"
#include "slave/core/surface/texture.h"

namespace tessera::core {

// What the scene at hand uses; shading skips the rest.
struct SurfaceFeatures {
  bool has_textures = false;
  bool has_normals = false;
  bool has_programs = false;
  bool has_glossy = false;
  bool has_specular = false;  // mirror or glass

  bool is_diffuse() const { return !has_glossy && !has_specular; }
  bool needs_cones() const { return has_textures || has_programs; }
};

struct PreparedScene::Impl {
  TriangleStore triangles;
  SpatialIndex index;
  LightSet lights;
  SurfaceFeatures features;
  std::vector<std::shared_ptr<const Mesh>> meshes;
  std::vector<MipMap> textures;
  std::vector<Material> materials;
  std::vector<Instance> instances;
};

}  // namespace tessera::core
