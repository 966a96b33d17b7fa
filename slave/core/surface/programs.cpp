// SPDX-License-Identifier: Apache-2.0
#include "slave/core/surface/programs.h"

namespace tessera::core {

void apply_surface_program(const SurfaceProgram& program, const Noise& noise,
                           const SurfacePlaces& places) {
  switch (program.kind) {
    case SurfaceKind::kConstant:
      return;
    case SurfaceKind::kMarble:
      return apply_marble(program.parameters, noise, places);
    case SurfaceKind::kWood:
      return apply_wood(program.parameters, noise, places);
    case SurfaceKind::kBrick:
      return apply_brick(program.parameters, places);
  }
}

}  // namespace tessera::core
