// SPDX-License-Identifier: Apache-2.0
#include "common/net/record_head.h"

#include <cstring>

namespace tessera::net {
namespace {

constexpr std::array<char, 4> kMagic = {'T', 'S', 'S', 'R'};

template <typename T>
void put(std::byte* at, T value) {
  for (std::size_t i = 0; i < sizeof(T); ++i)
    at[i] = static_cast<std::byte>(value >> (8 * i) & 0xffu);
}

template <typename T>
T get(const std::byte* at) {
  T value = 0;
  for (std::size_t i = 0; i < sizeof(T); ++i)
    value = static_cast<T>(value | static_cast<T>(at[i]) << (8 * i));
  return value;
}

}  // namespace

const char* refusal_text(RecordRefusal refusal) {
  switch (refusal) {
    case RecordRefusal::kMagic:
      return "not a Tessera record";
    case RecordRefusal::kFormatVersion:
      return "unknown record format version";
    case RecordRefusal::kUnknownType:
      return "a record type that is not allowed here";
    case RecordRefusal::kHeaderTooLong:
      return "record header above its limit";
    case RecordRefusal::kPayloadTooLong:
      return "record payload above its limit";
    case RecordRefusal::kChecksum:
      return "record checksum differs";
  }
  return "unknown";
}

std::string refusal_of(std::span<const std::byte, kRecordHeadBytes> head, RecordRefusal refusal) {
  const std::string text = refusal_text(refusal);
  if (refusal == RecordRefusal::kMagic || refusal == RecordRefusal::kFormatVersion) return text;
  return text + ": type " + std::to_string(get<std::uint16_t>(head.data() + 6)) + ", header of " +
         std::to_string(get<std::uint32_t>(head.data() + 8)) + " bytes, payload of " +
         std::to_string(get<std::uint32_t>(head.data() + 12)) + " bytes";
}

std::array<std::byte, kRecordHeadBytes> encode_head(const RecordHead& head) {
  std::array<std::byte, kRecordHeadBytes> bytes{};
  std::memcpy(bytes.data(), kMagic.data(), kMagic.size());
  put<std::uint16_t>(bytes.data() + 4, kRecordFormatVersion);
  put<std::uint16_t>(bytes.data() + 6, head.type);
  put<std::uint32_t>(bytes.data() + 8, head.header_bytes);
  put<std::uint32_t>(bytes.data() + 12, head.payload_bytes);
  put<std::uint32_t>(bytes.data() + 16, head.checksum);
  return bytes;
}

std::optional<RecordHead> decode_head(std::span<const std::byte, kRecordHeadBytes> bytes,
                                      const RecordLimits& limits, RecordRefusal& refusal) {
  const auto refuse = [&](RecordRefusal reason) {
    refusal = reason;
    return std::nullopt;
  };
  if (std::memcmp(bytes.data(), kMagic.data(), kMagic.size()) != 0)
    return refuse(RecordRefusal::kMagic);
  if (get<std::uint16_t>(bytes.data() + 4) != kRecordFormatVersion)
    return refuse(RecordRefusal::kFormatVersion);
  RecordHead head;
  head.type = get<std::uint16_t>(bytes.data() + 6);
  head.header_bytes = get<std::uint32_t>(bytes.data() + 8);
  head.payload_bytes = get<std::uint32_t>(bytes.data() + 12);
  head.checksum = get<std::uint32_t>(bytes.data() + 16);
  if (head.type >= limits.size() || limits[head.type].header_bytes_max < 0)
    return refuse(RecordRefusal::kUnknownType);
  if (head.header_bytes > limits[head.type].header_bytes_max)
    return refuse(RecordRefusal::kHeaderTooLong);
  if (head.payload_bytes > limits[head.type].payload_bytes_max)
    return refuse(RecordRefusal::kPayloadTooLong);
  return head;
}

}  // namespace tessera::net
