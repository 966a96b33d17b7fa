#include "tests/bench/contender.h"

std::unique_ptr<tessera::bench::Entrants> tessera::bench::make_embree(const core::TriangleStore&,
                                                                      Isa, const EmbreeMode&) {
  return nullptr;
}
