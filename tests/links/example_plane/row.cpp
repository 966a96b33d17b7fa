// SPDX-License-Identifier: Apache-2.0
// A plane that only this test has: how much a surface faces the camera. Linked in place of
// common/frame/more_planes.cpp.
#include "common/frame/picture_plane.h"

namespace tessera {
namespace {

constexpr PlaneRow kRows[] = {{"facing", {"facing"}}};

}  // namespace

std::span<const PlaneRow> more_plane_rows() { return kRows; }

}  // namespace tessera
