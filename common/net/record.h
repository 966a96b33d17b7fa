// SPDX-License-Identifier: Apache-2.0
// One record of the protocol: a fixed head, a small header (protobuf, opaque here) and a raw
// payload. Byte layout and refusals: record_head.h and proto/PROTOCOL.md.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

namespace tessera::net {

// Bytes kept alive by whoever holds them; copied by nobody.
struct SharedBytes {
  std::shared_ptr<const void> owner;
  std::span<const std::byte> bytes;

  static SharedBytes of(std::vector<std::byte> data) {
    auto held = std::make_shared<const std::vector<std::byte>>(std::move(data));
    return {held, *held};
  }
};

// A record to be sent.
struct Record {
  std::uint16_t type = 0;
  std::string header;
  SharedBytes payload;
};

// A record as it was received; its payload was read straight into its own buffer.
struct ReceivedRecord {
  std::uint16_t type = 0;
  std::string header;
  std::vector<std::byte> payload;
};

// Greatest header and payload of each type; a type with header_bytes_max < 0 is unknown and
// refused.
struct RecordLimit {
  std::int64_t header_bytes_max = -1;
  std::int64_t payload_bytes_max = 0;
};
inline constexpr std::uint16_t kRecordTypesMax = 64;
using RecordLimits = std::array<RecordLimit, kRecordTypesMax>;

}  // namespace tessera::net
