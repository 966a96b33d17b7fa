// SPDX-License-Identifier: Apache-2.0
// What renderers, readers and the border have to know of a BSDF, whichever it is.
//
// Threads. The table is constant.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string_view>

#include "common/scene/bsdf_kind_layout.h"

namespace tessera {

// Into which directions light is scattered, by which renderers decide how they look for it.
enum class Scattering : std::uint8_t {
  kEven,   // all, evenly: light samples find it; VPLs are gathered
  kLobes,  // all, some more than others: light samples and samples of the BSDF share the work (MIS)
  kDelta   // single ones, which no light sample meets: rays go on through the surface
};

struct BsdfTraits {
  const char* name = nullptr;
  Scattering scattering = Scattering::kEven;
};

// [BsdfKind]; those that do not exist have no name.
extern const std::array<BsdfTraits, kBsdfKindsMax> kBsdfTraits;

inline bool is_known(BsdfKind kind) {
  const auto number = static_cast<std::size_t>(kind);
  return number < kBsdfTraits.size() && kBsdfTraits[number].name != nullptr;
}
// Requires: is_known(kind).
inline Scattering scattering_of(BsdfKind kind) {
  return kBsdfTraits[static_cast<std::size_t>(kind)].scattering;
}
BsdfKind last_bsdf();
// Returns: null for a name that no BSDF has.
const BsdfKind* find_bsdf(std::string_view name);

}  // namespace tessera
