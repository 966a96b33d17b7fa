// SPDX-License-Identifier: Apache-2.0
#include "common/scene/flattened_counts.h"

#include "common/base/limits.h"

namespace tessera {

FlattenedCounts& FlattenedCounts::operator+=(const FlattenedCounts& other) {
  triangles += other.triangles;
  patches += other.patches;
  segments += other.segments;
  return *this;
}

FlattenedCounts& FlattenedCounts::operator-=(const FlattenedCounts& other) {
  triangles -= other.triangles;
  patches -= other.patches;
  segments -= other.segments;
  return *this;
}

FlattenedCounts flattened_counts(const Mesh& mesh) { return {mesh.triangles.size(), 0, 0}; }

FlattenedCounts flattened_counts(const PatchSurface& surface) {
  return {0, surface.patches.size(), surface.degrees.size()};
}

FlattenedCounts flattened_counts(const Scene& scene, const Instance& instance) {
  return instance.kind == ObjectKind::kMesh ? flattened_counts(*scene.meshes[instance.mesh])
                                            : flattened_counts(*scene.surfaces[instance.mesh]);
}

std::size_t block_count_max(const Scene& scene) {
  return scene.meshes.size() + scene.surfaces.size() + scene.textures.size() + 3;
}

Status validate_flattened(const FlattenedCounts& counts) {
  if (counts.patches > kPatchesMax) return Status::resource_exhausted("more than 2^24 patches");
  if (counts.segments > kTrimSegmentsMax)
    return Status::resource_exhausted("more than 2^26 segments of loops");
  if (counts.triangles + counts.patches > kTrianglesMax)
    return Status::resource_exhausted("more than 2^30 triangles and patches");
  return Status::ok();
}

}  // namespace tessera
