// SPDX-License-Identifier: Apache-2.0
// The freely programmable part of a material: which procedure makes its albedo vary, and with what
// numbers. Names, ranges and defaults stand here once, for readers, validation and the core; what a
// procedure computes is one file of slave/core/surface.
//
// A new program is a SurfaceKind at the end, its row in surface_program.cpp, its file and its line
// in slave/core/surface/programs.cpp.
//
// Threads. Plain values; the table is constant.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string_view>

namespace tessera {

enum class SurfaceKind : std::uint8_t { kConstant = 0, kMarble = 1, kWood = 2, kBrick = 3 };

inline constexpr std::size_t kSurfaceParametersMax = 8;
// Numbers of a program. A colour takes three of them; those that a program does not have are 0.
using SurfaceParameters = std::array<float, kSurfaceParametersMax>;

struct SurfaceProgram {
  SurfaceKind kind = SurfaceKind::kConstant;
  SurfaceParameters parameters{};
  bool operator==(const SurfaceProgram&) const = default;
};

struct SurfaceParameter {
  std::string_view name;
  std::size_t first, count;  // in SurfaceParameters; 3 for a colour
  float low, high;           // range of each number
};

struct SurfaceProgramShape {
  SurfaceKind kind;
  const char* name;
  std::span<const SurfaceParameter> parameters;
  SurfaceParameters defaults;
};

// Lengths are object units: the pattern stays with the mesh, whatever its instance does.
std::span<const SurfaceProgramShape> surface_programs();
// Returns: null for a program that does not exist.
const SurfaceProgramShape* find_surface_program(SurfaceKind kind);
const SurfaceProgramShape* find_surface_program(std::string_view name);
// Returns: the name of the first parameter that is out of its range or NaN, else null.
const char* first_bad_parameter(const SurfaceProgramShape& shape, const SurfaceProgram& program);

}  // namespace tessera
