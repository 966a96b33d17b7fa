// SPDX-License-Identifier: Apache-2.0
// Instruction sets a session can be bound to. Names are those of --isa. Which of them this CPU has
// is answered by slave/core/simd.
#pragma once

#include <cstdint>
#include <string_view>

#include "common/base/api.h"
#include "common/base/status.h"

namespace tessera {

// Ordered from narrow to wide; values travel on the wire.
enum class Isa : std::uint8_t { kScalar = 0, kSse4 = 1, kAvx2 = 2, kAvx512 = 3 };

// Bit i stands for Isa i.
using IsaMask = std::uint32_t;
inline constexpr IsaMask isa_bit(Isa isa) { return IsaMask{1} << static_cast<int>(isa); }
inline constexpr IsaMask kIsaMaskAll = 15;

TESSERA_API std::string_view isa_name(Isa isa);  // "scalar", "sse4", "avx2", "avx512"
// Returns: kInvalidArgument naming the values that exist. "auto" is the caller's to handle.
TESSERA_API Result<Isa> parse_isa(std::string_view text);
// Requires: mask has a bit of kIsaMaskAll.
TESSERA_API Isa widest_isa(IsaMask mask);

}  // namespace tessera
