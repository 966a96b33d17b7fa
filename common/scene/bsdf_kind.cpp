// SPDX-License-Identifier: Apache-2.0
#include "common/scene/bsdf_kind.h"

#include <iterator>

namespace tessera {
namespace {

constexpr BsdfKind kKinds[] = {
#define TESSERA_BSDF(kind, name, scattering, parameters) BsdfKind::kind,
#include "common/scene/bsdf_kinds.inc"
};
static_assert(std::size(kKinds) <= kBsdfKindsMax);

}  // namespace

const std::array<BsdfTraits, kBsdfKindsMax> kBsdfTraits{{
#define TESSERA_BSDF(kind, name, scattering, parameters) {name, Scattering::scattering},
#include "common/scene/bsdf_kinds.inc"
}};

BsdfKind last_bsdf() { return *std::rbegin(kKinds); }

const BsdfKind* find_bsdf(std::string_view name) {
  for (const BsdfKind& kind : kKinds) {
    if (name == kBsdfTraits[static_cast<std::size_t>(kind)].name) return &kind;
  }
  return nullptr;
}

}  // namespace tessera
