// SPDX-License-Identifier: Apache-2.0
// What a camera's choice asks of freeform surfaces: points between which a surface lies, and meshes
// that stand for it where a rough idea will do.
//
// Units. Lengths in the surface's own space. Threads. Pure functions.
#pragma once

#include <cstdint>
#include <vector>

#include "common/scene/scene.h"

namespace tessera {

// Control points of the parts into which each patch is cut by halving it in both directions, by
// de Casteljau's rule (G. Farin, Curves and Surfaces for CAGD, 5th ed., 2002, section 4.2). The
// surface lies in their convex hull, up to a rounding to float, since weights are above 0. With
// each halving the hull comes nearer to it by a factor of 4. Of a patch that keeps what its loops
// enclose only the part within the box of the loops' points is taken. Widths of loops are not
// looked at.
//
// Patches are halved four times, or less often where more than kNetPointsMax points would come of
// it.
// Requires: a valid surface.
inline constexpr std::uint64_t kNetPointsMax = std::uint64_t{1} << 20;
std::vector<Vec3f> fine_net(const PatchSurface& surface);

// The scene with a mesh in place of each surface: a patch, or what fine_net() takes of it, becomes
// 8 by 8 cells of two triangles with corners on the surface, fewer in scenes of more than 2^14
// patches. Cells whose middle is trimmed away are left out. Meshes are shared with `scene`.
// Requires: a valid scene.
Scene with_meshes_for_surfaces(const Scene& scene);

}  // namespace tessera
