// SPDX-License-Identifier: Apache-2.0
// What renderers, readers and the border have to know of any BSDF.
//
// Threads. The table is constant.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string_view>

#include "common/scene/bsdf_kind_layout.h"

namespace tessera {

// Directions into which light is scattered; renderers choose by them how they sample light.
enum class Scattering : std::uint8_t {
  kEven,   // all, evenly: by light samples; VPLs are gathered
  kLobes,  // all, some more than others: by light samples and samples of the BSDF (MIS)
  kDelta   // single ones, which no light sample meets: rays go on through the surface
};

struct BsdfTraits {
  const char* name = nullptr;
  Scattering scattering = Scattering::kEven;
};

// [BsdfKind]; kinds that do not exist have no name.
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
