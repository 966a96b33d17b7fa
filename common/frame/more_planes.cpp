// SPDX-License-Identifier: Apache-2.0
// This definition has a file of its own, so that a test can link another one in its place.
#include "common/frame/picture_plane.h"

namespace tessera {

std::span<const PlaneRow> more_plane_rows() { return {}; }

}  // namespace tessera
