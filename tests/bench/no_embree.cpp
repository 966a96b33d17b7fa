// SPDX-License-Identifier: Apache-2.0
#include "tests/bench/contender.h"

std::unique_ptr<tessera::bench::Entrants> tessera::bench::make_embree(const core::TriangleStore&,
                                                                      Isa, const EmbreeMode&) {
  return nullptr;
}
std::unique_ptr<tessera::bench::Entrants> tessera::bench::make_embree_instanced(const Scene&, Isa) {
  return nullptr;
}
std::unique_ptr<tessera::bench::Entrants> tessera::bench::make_embree_subdivided(
    const SplinePatches&, int, Isa) {
  return nullptr;
}
tessera::bench::Build tessera::bench::build_embree(const core::TriangleStore&, Isa,
                                                   const EmbreeMode&, int) {
  return {};
}
tessera::bench::Build tessera::bench::build_embree_low(const core::TriangleStore&, Isa) {
  return {};
}
tessera::bench::Build tessera::bench::refit_embree(const core::TriangleStore&,
                                                   const core::TriangleStore&, Isa) {
  return {};
}
bool tessera::bench::has_embree() { return false; }
