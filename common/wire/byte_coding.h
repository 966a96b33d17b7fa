// SPDX-License-Identifier: Apache-2.0
// Lossless coding of bulk bytes (pixels, pieces of scenes): LZ4, Zstandard at its first level, or
// none. CodecChooser decides which one pays on a link.
//
// Formats: LZ4 block format (Collet, lz4_Block_format.md), Zstandard frames (RFC 8878).
//
// Threads. Any; each has its own scratch. Invariant: a decoder writes into memory that the caller
// has sized from what was announced or leased, never from what the coded bytes claim: a bomb fills
// the space it was given and is refused.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "common/base/status.h"

namespace tessera::wire {

// The numbers travel on the wire.
enum class ByteCoding : std::uint8_t { kNone = 0, kLz4 = 1, kZstd = 2 };
inline constexpr int kByteCodingCount = 3;

// A set of codings: what a receiver can decode. Bit 0 (kNone) goes without saying.
using ByteCodingMask = std::uint32_t;
constexpr ByteCodingMask coding_bit(ByteCoding coding) {
  return ByteCodingMask{1} << static_cast<unsigned>(coding);
}
inline constexpr ByteCodingMask kByteCodingsNone = 0;
inline constexpr ByteCodingMask kByteCodingsAll =
    coding_bit(ByteCoding::kLz4) | coding_bit(ByteCoding::kZstd);

const char* coding_name(ByteCoding coding);

// Returns: false when the result would not be smaller; `coded` is then without meaning.
// Requires: coding is not kNone, `plain` at most 1 GiB.
[[nodiscard]] bool code_bytes(ByteCoding coding, std::span<const std::byte> plain,
                              std::vector<std::byte>& coded);

// Fills `plain` exactly. Returns: kDataLoss when the coded bytes are malformed, or hold more or
// fewer bytes than `plain` has room for.
Status decode_bytes(ByteCoding coding, std::span<const std::byte> coded,
                    std::span<std::byte> plain);

}  // namespace tessera::wire
