// SPDX-License-Identifier: Apache-2.0
// The fixed head of every record, and every reason for refusing one. The functions are pure; a head
// is checked before a byte is allocated.
//
// Bytes, little-endian: "TSSR", u16 format version, u16 type, u32 header bytes, u32 payload bytes,
// u32 checksum (CRC-32C of header and payload on TCP without TLS, else 0). proto/PROTOCOL.md has
// the page.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <string>

#include "common/net/record.h"

namespace tessera::net {

inline constexpr std::size_t kRecordHeadBytes = 20;
inline constexpr std::uint16_t kRecordFormatVersion = 1;

struct RecordHead {
  std::uint16_t type = 0;
  std::uint32_t header_bytes = 0;
  std::uint32_t payload_bytes = 0;
  std::uint32_t checksum = 0;
};

enum class RecordRefusal {
  kMagic,
  kFormatVersion,
  kUnknownType,
  kHeaderTooLong,
  kPayloadTooLong,
  kChecksum
};

const char* refusal_text(RecordRefusal refusal);
// refusal_text() with the type and the lengths that the head names, where the head can be trusted
// so far.
std::string refusal_of(std::span<const std::byte, kRecordHeadBytes> head, RecordRefusal refusal);

std::array<std::byte, kRecordHeadBytes> encode_head(const RecordHead& head);

// Returns: the head, or why the connection must be closed. `refusal` is set only then.
std::optional<RecordHead> decode_head(std::span<const std::byte, kRecordHeadBytes> bytes,
                                      const RecordLimits& limits, RecordRefusal& refusal);

}  // namespace tessera::net
