// SPDX-License-Identifier: Apache-2.0
// What a connection writes, piece by piece, is what was sent, whatever the link takes at a time.
#include "common/net/send_queue.h"
#include "tests/support/seed.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>

namespace tessera::net {
namespace {

TEST(SendQueue, WhateverTheLinkTakesAtATimeAllBytesLeaveInOrder) {
  std::mt19937 random(test::seed(1));
  std::string expected, written;
  SendQueue queue;
  std::vector<asio::const_buffer> parts;
  const auto text_of = [&](std::size_t size) {
    std::string text(size, ' ');
    for (char& c : text) c = static_cast<char>(random());
    return text;
  };
  for (int round = 0; round < 2000; ++round) {
    for (auto i = random() % 40; i > 0; --i) {
      const std::string head = text_of(kRecordHeadBytes), header = text_of(random() % 20),
                        payload = text_of(random() % 100);
      std::array<std::byte, kRecordHeadBytes> head_bytes;
      std::transform(head.begin(), head.end(), head_bytes.begin(),
                     [](char c) { return static_cast<std::byte>(c); });
      std::vector<std::byte> payload_bytes(payload.size());
      std::transform(payload.begin(), payload.end(), payload_bytes.begin(),
                     [](char c) { return static_cast<std::byte>(c); });
      queue.push(head_bytes, {1, header, SharedBytes::of(std::move(payload_bytes))});
      expected += head + header + payload;
    }
    const std::size_t gathered = queue.gather(parts);
    EXPECT_LE(parts.size(), kGatherBuffersMax);
    EXPECT_EQ(gathered == 0, queue.is_empty());
    std::string all;
    for (const auto& part : parts) {
      EXPECT_GT(part.size(), 0u);
      all.append(static_cast<const char*>(part.data()), part.size());
    }
    ASSERT_EQ(all.size(), gathered);
    const std::size_t taken = random() % (gathered + 1);
    written += all.substr(0, taken);
    queue.take(taken);
    ASSERT_EQ(queue.bytes(), expected.size() - written.size());
  }
  while (const std::size_t gathered = queue.gather(parts)) {
    for (const auto& part : parts)
      written.append(static_cast<const char*>(part.data()), part.size());
    queue.take(gathered);
  }
  EXPECT_TRUE(queue.is_empty());
  EXPECT_EQ(written, expected);
}

}  // namespace
}  // namespace tessera::net
