// SPDX-License-Identifier: Apache-2.0
// Any 20 bytes as the head of a record, before and after the handshake, are refused, or are within
// the limits of their type and the same bytes when encoded again.
#include <cstdint>
#include <cstdlib>
#include <cstring>

#include "common/net/record_head.h"
#include "common/wire/codec.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace tessera;
  std::array<std::byte, net::kRecordHeadBytes> bytes{};
  if (size < bytes.size()) return 0;
  std::memcpy(bytes.data(), data, bytes.size());
  for (const net::RecordLimits* limits : {&wire::pre_auth_limits(), &wire::session_limits()}) {
    net::RecordRefusal refusal{};
    const auto head = net::decode_head(bytes, *limits, refusal);
    if (!head) {
      if (std::strlen(net::refusal_text(refusal)) == 0) std::abort();
      continue;
    }
    const net::RecordLimit& limit = limits->at(head->type);
    if (head->header_bytes > limit.header_bytes_max ||
        head->payload_bytes > limit.payload_bytes_max)
      std::abort();
    if (net::encode_head(*head) != bytes) std::abort();
  }
  return 0;
}
