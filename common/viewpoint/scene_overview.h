// SPDX-License-Identifier: Apache-2.0
// The camera of a scene that brings none, and the one that shows all of a scene again. An object is
// shown whole from outside, an interior from within.
//
// A view from outside (framing.h) is from the front (interior.h; mostly +z), 29 degrees to the
// right and 20 above, so that three sides of a box are seen; vfov 45 degrees. An interior that is
// open in front, as a Cornell box is, is looked into straight from there; any other is shown from
// within (inside_camera.h), vfov 60 degrees. +y is up.
//
// Everything is computed here from the scene's values, in doubles, in a few passes over its
// triangles and patches: the answer depends on no cluster, no instruction set and no slave that may
// not be there yet. Refused: small pictures of distances from the slaves, which do not tell a
// room's wall from the inside of a bunny (fronts and backs look the same) and need a built scene
// first; the ray core in the master, which would build a tree of every scene for some thousand
// rays.
//
// Threads. Immutable after construction; shares the scene's meshes.
#pragma once

#include <vector>

#include "common/base/api.h"
#include "common/viewpoint/framing.h"
#include "common/viewpoint/inside_camera.h"
#include "common/viewpoint/interior.h"

namespace tessera {

class TESSERA_API SceneOverview {
 public:
  // Requires: a valid scene.
  explicit SceneOverview(const Scene& scene);

  // Whether default_camera() stands inside.
  bool is_inside() const { return !places_.empty() && !evidence_.is_open(evidence_.view()); }

  // `aspect` is width / height of the picture. Returns: Camera{} for a scene of nothing.
  Camera default_camera(double aspect) const;

  // The camera that shows all of the scene to a person who looks at it with `seen`; it keeps the
  // direction, up and opening angle of `seen`. An interior is shown from within, unless the eye
  // stands outside before an open side. Requires: `seen` is valid.
  Camera camera_of_all(const Camera& seen, double aspect) const;

 private:
  bool stands_before_open_side(Vec3f eye) const;

  SupportMap map_;
  Bounds3f bounds_;
  InteriorEvidence evidence_;
  std::vector<EyePlace> places_;  // of an interior, else empty
};

// The camera for a picture of a scene that has none. Requires: a valid scene, sizes > 0.
TESSERA_API Camera default_camera(const Scene& scene, int width_px, int height_px);

}  // namespace tessera
