// SPDX-License-Identifier: Apache-2.0
// Shared by the files of the codec: the checks of a decoded header, little-endian numbers in
// payloads, and the list of per-message functions. Not for other folders.
//
// Threads. Plain functions and values.
#pragma once

#include <cmath>
#include <cstring>
#include <limits>
#include <span>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include "common/base/status.h"
#include "common/net/record.h"
#include "common/wire/messages.h"
#include "common/wire/record_types.h"

namespace tessera::wire {

// Collects the first field of a message that is out of range.
class FieldCheck {
 public:
  explicit FieldCheck(const char* message) : message_(message) {}

  void range(const char* field, std::uint64_t value, std::uint64_t least, std::uint64_t greatest);
  void at_least(const char* field, std::uint64_t value, std::uint64_t least) {
    range(field, value, least, std::numeric_limits<std::uint64_t>::max());
  }
  void finite(const char* field, double value);
  void not_negative(const char* field, double value);  // finite, too
  void name(const char* field, const std::string& text, std::size_t bytes_min,
            std::size_t bytes_max);  // printable ASCII
  void line(const char* field, const std::string& text) { name(field, text, 0, kReasonBytesMax); }
  void payload_bytes(std::size_t present, std::uint64_t expected);
  void no_payload(const net::ReceivedRecord& record) { payload_bytes(record.payload.size(), 0); }
  void fail(const char* field, const std::string& what);

  bool is_ok() const { return status_.is_ok(); }
  const Status& status() const { return status_; }

 private:
  const char* message_;
  Status status_;
};

// Cuts a text to kReasonBytesMax and replaces what FieldCheck::line would refuse.
std::string clean_line(std::string text);

template <typename Header>
[[nodiscard]] bool parse_header(const net::ReceivedRecord& record, Header& header) {
  return header.ParseFromArray(record.header.data(), static_cast<int>(record.header.size()));
}

inline Status bad_header(const char* message) {
  return Status::data_loss(std::string(message) + ": header cannot be parsed");
}

template <typename Header>
net::Record make_record(RecordType type, const Header& header, net::SharedBytes payload = {}) {
  net::Record record;
  record.type = static_cast<std::uint16_t>(type);
  header.SerializeToString(&record.header);
  record.payload = std::move(payload);
  return record;
}

// Entries of StatusReply that are of a log; the readers return the bytes used, 0 when they do not
// hold an entry or a field is out of range.
void put_event(std::vector<std::byte>& out, const PastEvent& event);
std::size_t get_event(std::span<const std::byte> in, FieldCheck& check, PastEvent& event);
void put_suppressed(std::vector<std::byte>& out, const SuppressedLines& lines);
std::size_t get_suppressed(std::span<const std::byte> in, FieldCheck& check,
                           SuppressedLines& lines);

// Appends a number in little-endian order, whatever the machine.
template <typename T>
void put_le(std::vector<std::byte>& out, T value) {
  static_assert(std::is_unsigned_v<T>);
  for (std::size_t i = 0; i < sizeof(T); ++i) {
    out.push_back(static_cast<std::byte>((value >> (8 * i)) & 0xffu));
  }
}

// Requires: sizeof(T) bytes from `at` on.
template <typename T>
T get_le(std::span<const std::byte> bytes, std::size_t at) {
  static_assert(std::is_unsigned_v<T>);
  T value = 0;
  for (std::size_t i = 0; i < sizeof(T); ++i) {
    value = static_cast<T>(value | static_cast<T>(static_cast<T>(bytes[at + i]) << (8 * i)));
  }
  return value;
}

// codec_control.cpp
net::Record encode_one(Hello m);
net::Record encode_one(Welcome m);
net::Record encode_one(Join m);
net::Record encode_one(Joined m);
net::Record encode_one(Refuse m);
net::Record encode_one(Ping m);
net::Record encode_one(Pong m);
net::Record encode_one(Goodbye m);
Result<Message> decode_hello(net::ReceivedRecord record);
Result<Message> decode_welcome(net::ReceivedRecord record);
Result<Message> decode_join(net::ReceivedRecord record);
Result<Message> decode_joined(net::ReceivedRecord record);
Result<Message> decode_refuse(net::ReceivedRecord record);
Result<Message> decode_ping(net::ReceivedRecord record);
Result<Message> decode_pong(net::ReceivedRecord record);
Result<Message> decode_goodbye(net::ReceivedRecord record);
// codec_scene.cpp
net::Record encode_one(SceneAnnounce m);
net::Record encode_one(SceneNeed m);
net::Record encode_one(SceneChunk m);
net::Record encode_one(SceneChunkList m);
net::Record encode_one(SceneChunkNeed m);
net::Record encode_one(SceneBuilt m);
net::Record encode_one(SceneFailed m);
net::Record encode_one(SceneRetire m);
Result<Message> decode_scene_announce(net::ReceivedRecord record);
Result<Message> decode_scene_need(net::ReceivedRecord record);
Result<Message> decode_scene_chunk(net::ReceivedRecord record);
Result<Message> decode_scene_chunk_list(net::ReceivedRecord record);
Result<Message> decode_scene_chunk_need(net::ReceivedRecord record);
Result<Message> decode_scene_built(net::ReceivedRecord record);
Result<Message> decode_scene_failed(net::ReceivedRecord record);
Result<Message> decode_scene_retire(net::ReceivedRecord record);
// codec_relay.cpp
net::Record encode_one(RelayFrom m);
net::Record encode_one(RelayFailed m);
net::Record encode_one(SceneProgress m);
net::Record encode_one(CertificateRequest m);
net::Record encode_one(CertificateGrant m);
net::Record encode_one(RelayJoin m);
Result<Message> decode_relay_from(net::ReceivedRecord record);
Result<Message> decode_relay_failed(net::ReceivedRecord record);
Result<Message> decode_scene_progress(net::ReceivedRecord record);
Result<Message> decode_certificate_request(net::ReceivedRecord record);
Result<Message> decode_certificate_grant(net::ReceivedRecord record);
Result<Message> decode_relay_join(net::ReceivedRecord record);
// codec_work.cpp
net::Record encode_one(FrameBegin m);
net::Record encode_one(TileLease m);
net::Record encode_one(FrameEnd m);
net::Record encode_one(TileResult m);
net::Record encode_one(TileReturned m);
net::Record encode_one(FrameSubmit m);
net::Record encode_one(FrameCancel m);
net::Record encode_one(FrameChunk m);
Result<Message> decode_frame_begin(net::ReceivedRecord record);
Result<Message> decode_tile_lease(net::ReceivedRecord record);
Result<Message> decode_frame_end(net::ReceivedRecord record);
Result<Message> decode_tile_result(net::ReceivedRecord record);
Result<Message> decode_tile_returned(net::ReceivedRecord record);
Result<Message> decode_frame_submit(net::ReceivedRecord record);
Result<Message> decode_frame_cancel(net::ReceivedRecord record);
Result<Message> decode_frame_chunk(net::ReceivedRecord record);
// codec_app.cpp
net::Record encode_one(FrameDone m);
net::Record encode_one(StatusRequest m);
net::Record encode_one(StatusReply m);
Result<Message> decode_frame_done(net::ReceivedRecord record);
Result<Message> decode_status_request(net::ReceivedRecord record);
Result<Message> decode_status_reply(net::ReceivedRecord record);

}  // namespace tessera::wire
