// SPDX-License-Identifier: Apache-2.0
#include "common/net/record_head.h"

#include <gtest/gtest.h>

#include <random>
#include <string_view>

#include "common/net/crc32c.h"
#include "common/net/endpoint.h"
#include "tests/support/seed.h"

namespace tessera::net {
namespace {

RecordLimits limits_of_type_five() {
  RecordLimits limits{};
  limits[5] = {100, 1000};
  return limits;
}

std::optional<RecordRefusal> refusal_of(RecordHead head, std::size_t damaged_byte = 99,
                                        std::byte damage = std::byte{0}) {
  auto bytes = encode_head(head);
  if (damaged_byte < bytes.size()) bytes[damaged_byte] ^= damage;
  RecordRefusal refusal{};
  if (decode_head(bytes, limits_of_type_five(), refusal)) return std::nullopt;
  return refusal;
}

TEST(RecordHead, RoundTrip) {
  const RecordHead head{5, 100, 1000, 0xdeadbeef};
  RecordRefusal refusal{};
  const auto back = decode_head(encode_head(head), limits_of_type_five(), refusal);
  ASSERT_TRUE(back.has_value());
  EXPECT_EQ(back->type, 5);
  EXPECT_EQ(back->header_bytes, 100u);
  EXPECT_EQ(back->payload_bytes, 1000u);
  EXPECT_EQ(back->checksum, 0xdeadbeef);
}

TEST(RecordHead, EachRefusalHasItsReason) {
  EXPECT_EQ(refusal_of({5, 1, 1, 0}, 0, std::byte{1}), RecordRefusal::kMagic);
  EXPECT_EQ(refusal_of({5, 1, 1, 0}, 4, std::byte{2}), RecordRefusal::kFormatVersion);
  EXPECT_EQ(refusal_of({6, 1, 1, 0}), RecordRefusal::kUnknownType);
  EXPECT_EQ(refusal_of({65535, 1, 1, 0}), RecordRefusal::kUnknownType);
  EXPECT_EQ(refusal_of({5, 101, 1, 0}), RecordRefusal::kHeaderTooLong);
  EXPECT_EQ(refusal_of({5, 1, 1001, 0}), RecordRefusal::kPayloadTooLong);
  EXPECT_EQ(refusal_of({5, 1, 0xffffffff, 0}), RecordRefusal::kPayloadTooLong);
  EXPECT_EQ(refusal_of({5, 100, 1000, 0}), std::nullopt);
}

TEST(Crc32c, AgreesWithTheVectorsOfRfc3720) {
  const auto crc_of = [](std::string_view text) {
    return crc32c(0, std::as_bytes(std::span(text)));
  };
  EXPECT_EQ(crc_of(std::string(32, '\0')), 0x8a9136aau);
  EXPECT_EQ(crc_of(std::string(32, '\xff')), 0x62a8ab43u);
  EXPECT_EQ(crc_of("123456789"), 0xe3069283u);
}

// CRC-32C bit by bit, as its polynomial says.
std::uint32_t slow_crc32c(std::span<const std::byte> bytes) {
  std::uint32_t c = ~0u;
  for (const std::byte b : bytes) {
    c ^= static_cast<std::uint32_t>(b);
    for (int bit = 0; bit < 8; ++bit) c = (c & 1u) != 0 ? c >> 1 ^ 0x82f63b78u : c >> 1;
  }
  return ~c;
}

TEST(Crc32c, EveryLengthAgreesWithTheSlowOne) {
  std::mt19937 random(test::seed(2));
  std::vector<std::byte> bytes(5000);
  for (std::byte& b : bytes) b = static_cast<std::byte>(random());
  const std::span all(bytes);
  for (std::size_t length = 0; length <= bytes.size(); length += length < 40 ? 1 : 97)
    EXPECT_EQ(crc32c(0, all.first(length)), slow_crc32c(all.first(length))) << length;
}

TEST(Crc32c, PiecesGiveTheSameAsTheWhole) {
  std::mt19937 random(test::seed(1));
  std::vector<std::byte> bytes(4000);
  for (std::byte& b : bytes) b = static_cast<std::byte>(random());
  const std::span all(bytes);
  for (std::size_t cut = 0; cut <= bytes.size(); cut += 37) {
    EXPECT_EQ(crc32c(crc32c(0, all.first(cut)), all.subspan(cut)), crc32c(0, all));
  }
}

TEST(Endpoint, NamesAddressesAndPorts) {
  EXPECT_EQ(parse_endpoint("10.0.0.5:7400")->text(), "10.0.0.5:7400");
  EXPECT_EQ(parse_endpoint("[::1]:7400")->host, "::1");
  EXPECT_EQ(parse_endpoint("[::1]:7400")->text(), "[::1]:7400");
  EXPECT_EQ(parse_endpoint(":7400")->host, "0.0.0.0");
  for (const char* wrong :
       {"", "host", "host:", "host:x", "host:70000", "host:-1", "::1:7400", "a:1:2"}) {
    EXPECT_FALSE(parse_endpoint(wrong).is_ok()) << wrong;
  }
  const auto several = parse_endpoints("10.0.0.5:7400,[::1]:0,:1");
  ASSERT_TRUE(several.is_ok());
  EXPECT_EQ(several->size(), 3u);
  EXPECT_EQ((*several)[1].host, "::1");
  for (const char* wrong : {"", "a:1,", ",a:1", "a:1,,b:2", "a:1,b"})
    EXPECT_FALSE(parse_endpoints(wrong).is_ok()) << wrong;
  EXPECT_TRUE(is_loopback({"127.0.0.1", 1}));
  EXPECT_TRUE(is_loopback({"127.9.9.9", 1}));
  EXPECT_TRUE(is_loopback({"::1", 1}));
  EXPECT_FALSE(is_loopback({"0.0.0.0", 1}));
  EXPECT_FALSE(is_loopback({"10.0.0.1", 1}));
  EXPECT_FALSE(is_loopback({"no-such-host.invalid", 1}));
}

TEST(RecordHead, ARefusalNamesTypeAndSizes) {
  RecordHead head;
  head.type = 5;
  head.payload_bytes = 0xffffffffu;
  const auto bytes = encode_head(head);
  EXPECT_EQ(
      refusal_of(bytes, RecordRefusal::kPayloadTooLong),
      "record payload above its limit: type 5, header of 0 bytes, payload of 4294967295 bytes");
  EXPECT_EQ(refusal_of(bytes, RecordRefusal::kMagic), "not a Tessera record");
}

}  // namespace
}  // namespace tessera::net
