// SPDX-License-Identifier: Apache-2.0
// Decides where a camera stands inside a room, and which way it looks, from how far one sees from
// some places.
//
// The rule. The eye is at half the height from floor to ceiling, or half the room's lesser width
// where that is less (a hall is seen from below its middle): the floor and the ceiling then take
// up equal parts of a level picture, and nothing depends on the file's unit of length. Of all
// places and directions that one is taken from which the picture shows most of the room: the area
// of the floor plan that lies within the picture's width, at eye height and at half of it (above
// and below the backs of chairs), times the room's height there (the nave rather than the aisle).
// The area grows with the square of the free sight, so that the camera stands at one end and looks
// along the longest. A sight that leaves the scene shows nothing. Places nearer to a wall than a
// quarter of the eye's height do not count as long as there are others (half the clearance of the
// freest place is enough).
//
// The target is half as far away as the nearest wall, floor or ceiling, so that turning about it is
// looking around and never leaves the room.
//
// Threads. Pure functions.
#pragma once

#include <array>
#include <span>
#include <vector>

#include "common/scene/camera.h"
#include "common/viewpoint/axis_rays.h"

namespace tessera {

inline constexpr int kSights = 64;  // level directions, by equal angles
inline constexpr double kInsideVfovDegrees = 60;

// Level direction i: 0 is -z, and rising i turn towards +x.
Vec3d sight_direction(int i);

// How far one sees from a point in level directions, world units; infinite where nothing is met.
struct Sights {
  Vec3d from;
  std::array<double, kSights> distance{};
};

struct EyePlace {
  Sights eye, below;                          // at eye height and at half of it
  double above_floor = 0, below_ceiling = 0;  // of the eye
};

// Returns: places at eye height in rooms, all over the scene, kEyePlacesMax at most; empty where
// there are no rooms. Their sights are not yet known.
inline constexpr std::size_t kEyePlacesMax = 192;
std::vector<EyePlace> eye_places(const AxisRays& rays);

// Fills the sights: what each direction meets first, from one pass over all triangles, without
// freeform surfaces (those that
// cut the level plane of an eye do so in a line, which covers a range of directions).
void measure_sights(const Scene& scene, std::vector<EyePlace>& places);

// Applies the rule above. Requires: places with sights, not empty. The vertical opening angle and
// width / height are the picture's.
Camera inside_camera(std::span<const EyePlace> places, double vfov_degrees, double aspect);

}  // namespace tessera
