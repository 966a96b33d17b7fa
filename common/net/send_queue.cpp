// SPDX-License-Identifier: Apache-2.0
#include "common/net/send_queue.h"

#include <algorithm>
#include <utility>

namespace tessera::net {

void SendQueue::push(const std::array<std::byte, kRecordHeadBytes>& head, Record record) {
  records_.push_back({head, std::move(record)});
  bytes_ += records_.back().total_bytes();
}

std::size_t SendQueue::gather(std::vector<asio::const_buffer>& parts) const {
  parts.clear();
  std::size_t bytes = 0, skip = front_written_bytes_;
  const auto add = [&](const void* data, std::size_t size) {
    const std::size_t skipped = std::min(skip, size);
    skip -= skipped;
    if (skipped == size) return;
    parts.emplace_back(static_cast<const char*>(data) + skipped, size - skipped);
    bytes += size - skipped;
  };
  for (const Outgoing& outgoing : records_) {
    if (parts.size() + 3 > kGatherBuffersMax) break;
    add(outgoing.head.data(), outgoing.head.size());
    add(outgoing.record.header.data(), outgoing.record.header.size());
    add(outgoing.record.payload.bytes.data(), outgoing.record.payload.bytes.size());
  }
  return bytes;
}

void SendQueue::take(std::size_t bytes) {
  bytes_ -= bytes;
  front_written_bytes_ += bytes;
  while (!records_.empty() && front_written_bytes_ >= records_.front().total_bytes()) {
    front_written_bytes_ -= records_.front().total_bytes();
    records_.pop_front();
  }
}

}  // namespace tessera::net
