// SPDX-License-Identifier: Apache-2.0
// Constants of the layers of glossy surfaces, as the kernels see them.
// Fixed-size types only and no functions.
#pragma once

namespace tessera::core {

inline constexpr float kCoatF0 = 0.04f;  // varnish of ior 1.5 at normal incidence
// Least roughness of sheen; smaller ones are raised to it. It bounds the exponent 1 / roughness^2
// by 204, and with it the error of power() (slave/core/simd/power-inl.h).
inline constexpr float kSheenRoughnessMin = 0.07f;

}  // namespace tessera::core
