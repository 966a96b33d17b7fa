// SPDX-License-Identifier: Apache-2.0
// Bounds of the work of methods for patches on one ray and one sub-patch.
// Threads. Constants.
#pragma once

namespace tessera::core {

// Boxes that are looked at, as many as the complete solver may (cubic_solver_layout.h).
inline constexpr int kMethodBoxesMax = 1024;
// Of boxes that wait: a halving leaves one, and sides end at kMethodLeastWidth.
inline constexpr int kMethodStackMax = 64;
// A side of a box, of the patch's parameter: 32 halvings. A box with both sides as short is a root.
inline constexpr double kMethodLeastWidth = 0x1p-32;
inline constexpr int kMethodNewtonStepsMax = 12;
inline constexpr int kMethodRefinementMax = 12;  // halvings of each parameter

}  // namespace tessera::core
