#include "slave/core/surface/programs.h"

namespace tessera::core {

void apply_surface_program(const SurfaceProgram& program, const SurfacePlace& place, Surface& s) {
  switch (program.kind) {
    case SurfaceKind::kConstant:
      return;
    case SurfaceKind::kMarble:
      return apply_marble(program.parameters, place, s);
    case SurfaceKind::kWood:
      return apply_wood(program.parameters, place, s);
    case SurfaceKind::kBrick:
      return apply_brick(program.parameters, place, s);
  }
}

}  // namespace tessera::core
