// SPDX-License-Identifier: Apache-2.0
// The scene of the suite "update": sheets in a square, each a mesh of its own, and what an
// application changes of it, one change after another.
//
// Threads. One at a time.
#pragma once

#include <cstdint>
#include <string_view>
#include <vector>

#include "common/base/status.h"
#include "common/frame/frame_settings.h"
#include "common/scene/scene_edits.h"

namespace tessera::bench {

enum class EditKind {
  kCamera,
  kLight,
  kMaterial,
  kOneRigid,
  kAllRigid,
  kSomeVertices,
  kAllVertices
};
inline constexpr EditKind kEditKinds[] = {
    EditKind::kCamera,   EditKind::kLight,        EditKind::kMaterial,   EditKind::kOneRigid,
    EditKind::kAllRigid, EditKind::kSomeVertices, EditKind::kAllVertices};
std::string_view edit_name(EditKind kind);

class EditedScene {
 public:
  // Of about so many triangles, in so many objects.
  EditedScene(std::uint64_t triangles, std::size_t objects);

  // Makes the next change of this kind. No two changes of one kind are alike.
  Status change(EditKind kind);
  SceneEdits& edits() { return edits_; }
  // The scene as it stands, of which nothing is shared with anything.
  Scene apart();

  const Camera& camera() const { return camera_; }
  std::uint64_t triangles() const;

 private:
  Transform place_of(std::size_t object, float height) const;
  Status move(std::size_t object);
  Status deform(std::size_t vertices);

  std::size_t side_;  // sheets along a side of the square
  int segments_;      // quads along a side of a sheet
  std::vector<ObjectName> names_;
  SceneEdits edits_;
  Camera camera_;
  int step_ = 0;
};

}  // namespace tessera::bench
