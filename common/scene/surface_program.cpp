// SPDX-License-Identifier: Apache-2.0
#include "common/scene/surface_program.h"

namespace tessera {
namespace {

// Frequencies per object unit: patterns of 10^5 periods a unit are finer than any picture.
constexpr float kFrequencyMax = 1e5f;

constexpr SurfaceParameter kMarble[] = {
    {"frequency", 0, 1, 0, kFrequencyMax}, {"turbulence", 1, 1, 0, 16}, {"vein", 2, 3, 0, 1}};
constexpr SurfaceParameter kWood[] = {{"frequency", 0, 1, 0, kFrequencyMax},
                                      {"wobble", 1, 1, 0, 16},
                                      {"grain", 2, 1, 0, 1},
                                      {"dark", 3, 3, 0, 1}};
constexpr SurfaceParameter kBrick[] = {{"width", 0, 1, 1e-5f, 1e5f},
                                       {"height", 1, 1, 1e-5f, 1e5f},
                                       {"joint", 2, 1, 0, 1e5f},
                                       {"variation", 3, 1, 0, 1},
                                       {"mortar", 4, 3, 0, 1}};

constexpr SurfaceProgramShape kPrograms[] = {
    {SurfaceKind::kConstant, "constant", {}, {}},
    {SurfaceKind::kMarble, "marble", kMarble, {2, 3, 0.25f, 0.22f, 0.2f}},
    {SurfaceKind::kWood, "wood", kWood, {8, 0.5f, 0.3f, 0.3f, 0.15f, 0.07f}},
    {SurfaceKind::kBrick, "brick", kBrick, {0.25f, 0.08f, 0.01f, 0.3f, 0.6f, 0.58f, 0.55f}}};

}  // namespace

std::span<const SurfaceProgramShape> surface_programs() { return kPrograms; }

const SurfaceProgramShape* find_surface_program(SurfaceKind kind) {
  for (const SurfaceProgramShape& shape : kPrograms) {
    if (shape.kind == kind) return &shape;
  }
  return nullptr;
}

const SurfaceProgramShape* find_surface_program(std::string_view name) {
  for (const SurfaceProgramShape& shape : kPrograms) {
    if (shape.name == name) return &shape;
  }
  return nullptr;
}

const char* first_bad_parameter(const SurfaceProgramShape& shape, const SurfaceProgram& program) {
  for (const SurfaceParameter& parameter : shape.parameters) {
    for (std::size_t i = 0; i < parameter.count; ++i) {
      const float x = program.parameters[parameter.first + i];
      if (!(x >= parameter.low && x <= parameter.high)) return parameter.name.data();
    }
  }
  return nullptr;
}

}  // namespace tessera
