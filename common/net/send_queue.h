// SPDX-License-Identifier: Apache-2.0
// Records on their way out: what waits, and how far the first of them is written. For common/net
// alone. Pure: bytes go in, parts of a write come out.
//
// Threads. The connection's io thread.
#pragma once

#include <array>
#include <asio/buffer.hpp>
#include <deque>
#include <vector>

#include "common/net/record.h"
#include "common/net/record_head.h"

namespace tessera::net {

// Most parts of one write: well below IOV_MAX, and enough for 20 records.
inline constexpr std::size_t kGatherBuffersMax = 60;

class SendQueue {
 public:
  void push(const std::array<std::byte, kRecordHeadBytes>& head, Record record);
  bool is_empty() const { return records_.empty(); }
  std::uint64_t bytes() const { return bytes_; }  // not yet written

  // Gives what waits, from the first byte not yet written on, in at most kGatherBuffersMax parts,
  // which are valid until take(). Returns: the number of their bytes.
  std::size_t gather(std::vector<asio::const_buffer>& parts) const;
  // Drops `bytes` bytes, which were written. Requires: no more than gather() gave.
  void take(std::size_t bytes);

 private:
  struct Outgoing {
    std::array<std::byte, kRecordHeadBytes> head;
    Record record;
    std::size_t total_bytes() const {
      return head.size() + record.header.size() + record.payload.bytes.size();
    }
  };

  std::deque<Outgoing> records_;
  std::size_t front_written_bytes_ = 0;  // of the first record
  std::uint64_t bytes_ = 0;
};

}  // namespace tessera::net
