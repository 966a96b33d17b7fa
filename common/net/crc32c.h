// SPDX-License-Identifier: Apache-2.0
// CRC-32C (Castagnoli), the checksum of records on TCP links without TLS. RFC 3720, appendix B.4.
// TLS has its own, stronger integrity; a checksum beside it would only cost time.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

namespace tessera::net {

// Continues `crc` (0 to begin) over `bytes`. Any thread.
std::uint32_t crc32c(std::uint32_t crc, std::span<const std::byte> bytes);

}  // namespace tessera::net
