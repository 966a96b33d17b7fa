// SPDX-License-Identifier: Apache-2.0
// In a file of its own, so that a test's own definition is linked in its place.
#include "common/frame/picture_plane.h"

namespace tessera {

std::span<const PlaneRow> more_plane_rows() { return {}; }

}  // namespace tessera
