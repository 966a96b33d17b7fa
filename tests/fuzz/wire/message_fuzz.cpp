// SPDX-License-Identifier: Apache-2.0
// Any record, as the network would hand it over: a byte of type, two of header length, header,
// payload. What decodes must encode to a record that decodes again.
#include <cstdint>
#include <cstdlib>
#include <string>
#include <vector>

#include "common/wire/codec.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace tessera;
  if (size < 3) return 0;
  net::ReceivedRecord record;
  record.type = data[0];
  const std::size_t header_bytes = data[1] | std::size_t{data[2]} << 8;
  const std::size_t rest = size - 3;
  const std::size_t header_end = header_bytes < rest ? header_bytes : rest;
  record.header.assign(reinterpret_cast<const char*>(data) + 3, header_end);
  const auto* bytes = reinterpret_cast<const std::byte*>(data) + 3;
  record.payload.assign(bytes + header_end, bytes + rest);
  Result<wire::Message> message = wire::decode(std::move(record));
  if (!message.is_ok()) return 0;
  net::Record again = wire::encode(std::move(*message));
  const std::vector<std::byte> payload(again.payload.bytes.begin(), again.payload.bytes.end());
  if (!wire::decode({again.type, again.header, payload}).is_ok()) std::abort();
  return 0;
}
