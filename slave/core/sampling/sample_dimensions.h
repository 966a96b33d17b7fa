// Dimensions of the sample sequence of one pixel, see pixel_key(). Those of a path's depths are
// mixed from the light's (path_tracer.cpp).
// Threads. Constants.
#pragma once

#include <cstdint>

namespace tessera::core {

inline constexpr std::uint32_t kDimensionLens = 0, kDimensionLight = 1;

}  // namespace tessera::core
