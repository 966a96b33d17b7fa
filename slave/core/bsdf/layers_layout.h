// SPDX-License-Identifier: Apache-2.0
// Constants of the layers of glossy surfaces, as the kernels see them.
// Fixed-size types only and no functions.
#pragma once

namespace tessera::core {

inline constexpr float kCoatF0 = 0.04f;  // varnish of ior 1.5 at normal incidence
// Fibres that lie closer together are taken for these (slave/core/simd/power.h: exponents of at most 204).
inline constexpr float kSheenRoughnessMin = 0.07f;

}  // namespace tessera::core
