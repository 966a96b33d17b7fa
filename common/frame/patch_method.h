// SPDX-License-Identifier: Apache-2.0
// How rays meet patches: the usual way, which is proved and has no error beyond roundings, or one
// of the four methods of C. Benthin, "Realtime Ray Tracing on Current CPU Architectures", PhD
// thesis, Saarland University, 2006, sections 6.3 to 6.6, each with an error of its own. Triangles
// are met the same way with all of them. Threads. Pure functions.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "common/base/status.h"

namespace tessera {

// Values travel on the wire.
enum class PatchMethod : std::uint8_t {
  kAuto = 0,      // decisions that are proved, and a complete solver for the rest
  kRefine = 1,    // uniform refinement to bilinear facets (6.3)
  kNewton = 2,    // Newton from the middle of a part, without proof (6.4)
  kKrawczyk = 3,  // boxes by Krawczyk's operator, then Newton (6.5)
  kClip = 4,      // Bezier clipping (6.6)
};
inline constexpr std::array kPatchMethods{PatchMethod::kAuto, PatchMethod::kRefine,
                                          PatchMethod::kNewton, PatchMethod::kKrawczyk,
                                          PatchMethod::kClip};

std::string_view patch_method_name(PatchMethod method);  // "auto", "refine", ...
std::vector<std::string> patch_method_names();
// Returns: kInvalidArgument naming the values that exist.
Result<PatchMethod> parse_patch_method(std::string_view text);
// What its answers are off by, and what it loses, in one line; "none" for the usual way. A patch's
// size is the longest side of the box of its control points. tests/bench has the figures.
std::string_view patch_method_error(PatchMethod method);

// Text of --patch-method for --help.
std::string patch_method_help();
// The line that says that a method was asked for and changes nothing.
std::string no_patches_line(PatchMethod method);

}  // namespace tessera
