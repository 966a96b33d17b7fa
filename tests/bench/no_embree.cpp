#include "tests/bench/contender.h"

namespace tessera::bench {
std::unique_ptr<Entrants> make_embree(const core::TriangleStore&, Isa) { return nullptr; }
}  // namespace tessera::bench
