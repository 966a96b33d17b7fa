// SPDX-License-Identifier: Apache-2.0
// One scene version made ready for tracing: triangles, in world space or as instances of meshes,
// the spatial index, materials, textures, lights. It is immutable: any number of threads read it
// without locks, and tiles of frame n hold it alive while version n + 1 is built beside them.
#pragma once

#include <atomic>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>

#include "common/base/status.h"
#include "common/scene/scene.h"
#include "slave/core/accel/structure.h"
#include "slave/core/primitive/instancing.h"

namespace tessera::core {

class PreparedScene;

struct BuildOptions {
  int threads = 1;                                  // at least 1
  const std::atomic<bool>* is_cancelled = nullptr;  // may be null; polled
  Structure structure = Structure::kAuto;           // answers do not depend on it
  Instancing instancing = Instancing::kAuto;        // likewise; kd-trees have no instances
  // Every mesh that can be is built when the first ray reaches its box (mesh_slot.h), but for those
  // of scenes with patches, kd-trees and hierarchies of quality. Answers do not depend on it.
  bool is_on_demand = false;
  // Another version of the scene; may be null. Where it has the same meshes, by pointer, in the
  // same places, its geometry is shared and not built. Otherwise what moved or changed is built
  // beside what did not: meshes that move get a structure of their own, the others keep one. Where
  // corners moved and all triangles are the same, its structure is fitted (flat_geometry.h).
  const PreparedScene* other = nullptr;
  // Tells how many bytes can be had; null, or nothing: not known. Asked where a kd-tree is to hold
  // copies of meshes for which whoever sent the scene has reckoned one.
  std::function<std::optional<std::uint64_t>()> free_bytes = {};
};

class PreparedScene {
 public:
  // Any thread; takes seconds for large scenes. Degenerate triangles keep their number and stay out
  // of the tree. Requires: validate_scene(scene) is ok. Returns: kCancelled, or kResourceExhausted
  // when the tree would pass its limits, or memory ran out or surely would.
  static Result<std::shared_ptr<const PreparedScene>> build(const Scene& scene,
                                                            const BuildOptions& options);

  ~PreparedScene();

  std::uint64_t primitive_count() const;   // triangles and patches, flattened over instances
  std::uint64_t degenerate_count() const;  // of instances that are not flattened: by their mesh
  std::uint64_t memory_bytes() const;
  // Whether this scene shares the geometry of the other one instead of having built its own.
  bool has_geometry_of(const PreparedScene& other) const;
  // Triangles and instances that were put into structures when its geometry was built, and since
  // then, where rays have met what is built on demand.
  std::uint64_t built_primitives() const;
  // Triangles in structures of the other version, which were fitted to where they are now.
  std::uint64_t fitted_primitives() const;

  struct Impl;  // slave/core/scene/prepared_scene_impl.h
  const Impl& impl() const { return *impl_; }
  explicit PreparedScene(std::unique_ptr<Impl> impl);

 private:
  std::unique_ptr<Impl> impl_;
};

}  // namespace tessera::core
