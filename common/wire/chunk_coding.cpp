// SPDX-License-Identifier: Apache-2.0
#include "common/wire/chunk_coding.h"

#include <utility>
#include <vector>

#include "common/base/clock.h"

namespace tessera::wire {

void code_chunk(CodecChooser& chooser, ByteCodingMask allowed, SceneChunk& chunk) {
  const ByteCoding coding = chooser.next(allowed);
  if (coding == ByteCoding::kNone) return;
  const TimePoint began = Clock::now();
  std::vector<std::byte> coded;
  const std::size_t plain_bytes = chunk.bytes.bytes.size();
  const bool is_smaller = code_bytes(coding, chunk.bytes.bytes, coded);
  chooser.measured(coding, plain_bytes, is_smaller ? coded.size() : plain_bytes,
                   seconds(Clock::now() - began));
  if (!is_smaller) return;
  chunk.coding = coding;
  chunk.bytes = net::SharedBytes::of(std::move(coded));
}

}  // namespace tessera::wire
