// SPDX-License-Identifier: Apache-2.0
#include "tests/bench/contender.h"

std::unique_ptr<tessera::bench::Entrants> tessera::bench::make_embree(const core::TriangleStore&,
                                                                      Isa, const EmbreeMode&) {
  return nullptr;
}
std::unique_ptr<tessera::bench::Entrants> tessera::bench::make_embree_instanced(const Scene&, Isa) {
  return nullptr;
}
tessera::bench::Build tessera::bench::build_embree(const core::TriangleStore&, Isa,
                                                   const EmbreeMode&, int) {
  return {};
}
bool tessera::bench::has_embree() { return false; }
