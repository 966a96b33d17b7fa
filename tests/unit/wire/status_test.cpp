// SPDX-License-Identifier: Apache-2.0
// StatusReply between versions: short entries for clients that know no details, and details of a
// later version, which are longer.
#include <gtest/gtest.h>

#include "common/wire/codec.h"
#include "proto/stats.pb.h"
#include "tests/unit/wire/wire_samples.h"

namespace tessera::wire {
namespace {

constexpr std::size_t kDetailBytes = 80, kFirstDetailBytes = 79;  // as PROTOCOL.md says

net::ReceivedRecord carry(net::Record record) {
  return {record.type, std::move(record.header),
          std::vector<std::byte>(record.payload.bytes.begin(), record.payload.bytes.end())};
}

TEST(StatusReply, ShortEntriesHoldWhatOlderClientsKnow) {
  SlaveStatus slave = Samples(1).slave_status();
  StatusReply sent;
  sent.status.slaves = {slave};
  const std::size_t long_bytes = encode(sent).payload.bytes.size();
  sent.has_details = false;
  net::Record record = encode(sent);
  EXPECT_EQ(record.payload.bytes.size() + kDetailBytes, long_bytes);
  const Result<Message> received = decode(carry(std::move(record)));
  ASSERT_TRUE(received.is_ok()) << received.status().message();
  const auto& reply = std::get<StatusReply>(*received);
  EXPECT_FALSE(reply.has_details);
  EXPECT_EQ(reply.status.slaves[0].name, slave.name);
  EXPECT_EQ(reply.status.slaves[0].scene_port, slave.scene_port);
  EXPECT_EQ(reply.status.slaves[0].tiles, TileAccounts());
}

TEST(StatusReply, DetailsOfTheFirstVersionSayNothingOfStalls) {
  StatusReply sent;
  sent.status.slaves = {Samples(3).slave_status()};
  sent.status.slaves[0].state = SlaveState::kStalled;
  net::ReceivedRecord record = carry(encode(sent));
  const Result<Message> whole = decode(net::ReceivedRecord(record));
  ASSERT_TRUE(whole.is_ok());
  EXPECT_EQ(std::get<StatusReply>(*whole).status.slaves[0].state, SlaveState::kStalled);
  proto::StatusReply header;
  ASSERT_TRUE(header.ParseFromString(record.header));
  header.set_detail_bytes(kFirstDetailBytes);
  header.SerializeToString(&record.header);
  record.payload.pop_back();
  const Result<Message> received = decode(std::move(record));
  ASSERT_TRUE(received.is_ok()) << received.status().message();
  EXPECT_EQ(std::get<StatusReply>(*received).status.slaves[0].state, SlaveState::kReady);
}

TEST(StatusReply, DetailsOfALaterVersionAreSkipped) {
  StatusReply sent;
  Samples samples(2);
  sent.status.slaves = {samples.slave_status(), samples.slave_status()};
  net::ReceivedRecord record = carry(encode(sent));
  proto::StatusReply header;
  ASSERT_TRUE(header.ParseFromString(record.header));
  ASSERT_EQ(header.detail_bytes(), kDetailBytes);
  header.set_detail_bytes(kDetailBytes + 3);
  header.SerializeToString(&record.header);
  const std::size_t first = 1 + sent.status.slaves[0].name.size() + 45 + kDetailBytes;
  const std::vector<std::byte> later(3, std::byte{0xab});
  record.payload.insert(record.payload.end(), later.begin(), later.end());
  record.payload.insert(record.payload.begin() + static_cast<std::ptrdiff_t>(first), later.begin(),
                        later.end());
  const Result<Message> received = decode(record);
  ASSERT_TRUE(received.is_ok()) << received.status().message();
  EXPECT_TRUE(same(std::get<StatusReply>(*received), sent));
}

TEST(StatusReply, DetailsTooShortToBeOursAreRefused) {
  StatusReply sent;
  sent.status.slaves = {Samples(3).slave_status()};
  net::ReceivedRecord record = carry(encode(sent));
  proto::StatusReply header;
  ASSERT_TRUE(header.ParseFromString(record.header));
  for (const std::size_t bytes : {std::size_t{1}, kFirstDetailBytes - 1, std::size_t{0xffffffff}}) {
    header.set_detail_bytes(static_cast<std::uint32_t>(bytes));
    header.SerializeToString(&record.header);
    const Result<Message> received = decode(record);
    ASSERT_FALSE(received.is_ok()) << bytes;
    EXPECT_NE(received.status().message().find("StatusReply.detail_bytes"), std::string::npos);
  }
}

}  // namespace
}  // namespace tessera::wire
