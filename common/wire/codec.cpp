// SPDX-License-Identifier: Apache-2.0
#include "common/wire/codec.h"

#include <array>
#include <utility>

#include "common/wire/codec_internal.h"

namespace tessera::wire {

namespace {

void set_limit(net::RecordLimits& limits, RecordType type, std::size_t header_bytes_max,
               std::size_t payload_bytes_max) {
  limits[static_cast<std::size_t>(type)] = {static_cast<std::int64_t>(header_bytes_max),
                                            static_cast<std::int64_t>(payload_bytes_max)};
}

net::RecordLimits make_pre_auth_limits() {
  net::RecordLimits limits;
  for (const RecordType type : {RecordType::kHello, RecordType::kJoin, RecordType::kRefuse}) {
    set_limit(limits, type, kPreAuthRecordBytesMax, 0);
  }
  return limits;
}

net::RecordLimits make_session_limits() {
  net::RecordLimits limits;
  for (const RecordType type :
       {RecordType::kWelcome, RecordType::kJoin, RecordType::kJoined, RecordType::kPing,
        RecordType::kPong, RecordType::kSceneBuilt, RecordType::kRelayFrom,
        RecordType::kSceneProgress, RecordType::kSceneRetire, RecordType::kFrameBegin,
        RecordType::kTileLease, RecordType::kFrameEnd, RecordType::kTileReturned,
        RecordType::kFrameSubmit, RecordType::kFrameCancel, RecordType::kStatusRequest}) {
    set_limit(limits, type, kSmallHeaderBytesMax, 0);
  }
  for (const RecordType type : {RecordType::kHello, RecordType::kRefuse, RecordType::kGoodbye,
                                RecordType::kSceneFailed, RecordType::kRelayFailed}) {
    set_limit(limits, type, kTextHeaderBytesMax, 0);
  }
  set_limit(limits, RecordType::kCertificateRequest, kSmallHeaderBytesMax, kCertificateBytesMax);
  set_limit(limits, RecordType::kCertificateGrant, kTextHeaderBytesMax, kCertificateBytesMax);
  set_limit(limits, RecordType::kSceneAnnounce, kSmallHeaderBytesMax,
            kSceneBlocksMax * kAnnounceEntryBytes);
  set_limit(limits, RecordType::kSceneNeed, kSmallHeaderBytesMax,
            kSceneBlocksMax * sizeof(std::uint32_t));
  set_limit(limits, RecordType::kSceneChunk, kSmallHeaderBytesMax, kSceneChunkBytes);
  set_limit(limits, RecordType::kSceneChunkList, kSmallHeaderBytesMax, kSceneChunkListBytesMax);
  set_limit(limits, RecordType::kSceneChunkNeed, kSmallHeaderBytesMax, kSceneBlockChunksMax / 8);
  set_limit(limits, RecordType::kTileResult, kSmallHeaderBytesMax, kTilePayloadBytesMax);
  set_limit(limits, RecordType::kFrameChunk, kSmallHeaderBytesMax, kFrameChunkBytesMax);
  set_limit(limits, RecordType::kFrameDone, kTextHeaderBytesMax,
            std::size_t{kTilesPerFrameMax} * sizeof(std::uint16_t));
  set_limit(limits, RecordType::kStatusReply, kSmallHeaderBytesMax,
            std::size_t{kConnectionsMax} * (kStatusEntryBytesMax + kQuarantineEntryBytesMax) +
                kLogBytesMax);
  return limits;
}

using Decoder = Result<Message> (*)(net::ReceivedRecord);

std::array<Decoder, net::kRecordTypesMax> make_decoders() {
  std::array<Decoder, net::kRecordTypesMax> table{};
  const auto set = [&table](RecordType type, Decoder decoder) {
    table[static_cast<std::size_t>(type)] = decoder;
  };
  set(RecordType::kHello, decode_hello);
  set(RecordType::kWelcome, decode_welcome);
  set(RecordType::kJoin, decode_join);
  set(RecordType::kJoined, decode_joined);
  set(RecordType::kRefuse, decode_refuse);
  set(RecordType::kPing, decode_ping);
  set(RecordType::kPong, decode_pong);
  set(RecordType::kGoodbye, decode_goodbye);
  set(RecordType::kSceneAnnounce, decode_scene_announce);
  set(RecordType::kSceneNeed, decode_scene_need);
  set(RecordType::kSceneChunk, decode_scene_chunk);
  set(RecordType::kSceneChunkList, decode_scene_chunk_list);
  set(RecordType::kSceneChunkNeed, decode_scene_chunk_need);
  set(RecordType::kRelayFrom, decode_relay_from);
  set(RecordType::kRelayFailed, decode_relay_failed);
  set(RecordType::kSceneProgress, decode_scene_progress);
  set(RecordType::kRelayJoin, decode_relay_join);
  set(RecordType::kCertificateRequest, decode_certificate_request);
  set(RecordType::kCertificateGrant, decode_certificate_grant);
  set(RecordType::kSceneBuilt, decode_scene_built);
  set(RecordType::kSceneFailed, decode_scene_failed);
  set(RecordType::kSceneRetire, decode_scene_retire);
  set(RecordType::kFrameBegin, decode_frame_begin);
  set(RecordType::kTileLease, decode_tile_lease);
  set(RecordType::kFrameEnd, decode_frame_end);
  set(RecordType::kTileResult, decode_tile_result);
  set(RecordType::kTileReturned, decode_tile_returned);
  set(RecordType::kFrameSubmit, decode_frame_submit);
  set(RecordType::kFrameCancel, decode_frame_cancel);
  set(RecordType::kFrameChunk, decode_frame_chunk);
  set(RecordType::kFrameDone, decode_frame_done);
  set(RecordType::kStatusRequest, decode_status_request);
  set(RecordType::kStatusReply, decode_status_reply);
  return table;
}

struct NameOf {
  const char* operator()(const Hello&) const { return "Hello"; }
  const char* operator()(const Welcome&) const { return "Welcome"; }
  const char* operator()(const Join&) const { return "Join"; }
  const char* operator()(const Joined&) const { return "Joined"; }
  const char* operator()(const Refuse&) const { return "Refuse"; }
  const char* operator()(const Ping&) const { return "Ping"; }
  const char* operator()(const Pong&) const { return "Pong"; }
  const char* operator()(const Goodbye&) const { return "Goodbye"; }
  const char* operator()(const SceneAnnounce&) const { return "SceneAnnounce"; }
  const char* operator()(const SceneNeed&) const { return "SceneNeed"; }
  const char* operator()(const SceneChunk&) const { return "SceneChunk"; }
  const char* operator()(const SceneChunkList&) const { return "SceneChunkList"; }
  const char* operator()(const SceneChunkNeed&) const { return "SceneChunkNeed"; }
  const char* operator()(const RelayFrom&) const { return "RelayFrom"; }
  const char* operator()(const RelayFailed&) const { return "RelayFailed"; }
  const char* operator()(const SceneProgress&) const { return "SceneProgress"; }
  const char* operator()(const RelayJoin&) const { return "RelayJoin"; }
  const char* operator()(const CertificateRequest&) const { return "CertificateRequest"; }
  const char* operator()(const CertificateGrant&) const { return "CertificateGrant"; }
  const char* operator()(const SceneBuilt&) const { return "SceneBuilt"; }
  const char* operator()(const SceneFailed&) const { return "SceneFailed"; }
  const char* operator()(const SceneRetire&) const { return "SceneRetire"; }
  const char* operator()(const FrameBegin&) const { return "FrameBegin"; }
  const char* operator()(const TileLease&) const { return "TileLease"; }
  const char* operator()(const FrameEnd&) const { return "FrameEnd"; }
  const char* operator()(const TileResult&) const { return "TileResult"; }
  const char* operator()(const TileReturned&) const { return "TileReturned"; }
  const char* operator()(const FrameSubmit&) const { return "FrameSubmit"; }
  const char* operator()(const FrameCancel&) const { return "FrameCancel"; }
  const char* operator()(const FrameChunk&) const { return "FrameChunk"; }
  const char* operator()(const FrameDone&) const { return "FrameDone"; }
  const char* operator()(const StatusRequest&) const { return "StatusRequest"; }
  const char* operator()(const StatusReply&) const { return "StatusReply"; }
};

}  // namespace

const net::RecordLimits& pre_auth_limits() {
  static const net::RecordLimits limits = make_pre_auth_limits();
  return limits;
}

const net::RecordLimits& session_limits() {
  static const net::RecordLimits limits = make_session_limits();
  return limits;
}

const net::RecordLimits& relay_join_limits() {
  static const net::RecordLimits limits = [] {
    net::RecordLimits made;
    set_limit(made, RecordType::kRelayJoin, kSmallHeaderBytesMax, 0);
    return made;
  }();
  return limits;
}

const net::RecordLimits& relay_feeder_limits() {
  static const net::RecordLimits limits = [] {
    net::RecordLimits made;
    set_limit(made, RecordType::kSceneChunkNeed, kSmallHeaderBytesMax, kSceneBlockChunksMax / 8);
    return made;
  }();
  return limits;
}

const net::RecordLimits& relay_child_limits() {
  static const net::RecordLimits limits = [] {
    net::RecordLimits made;
    set_limit(made, RecordType::kSceneChunk, kSmallHeaderBytesMax, kSceneChunkBytes);
    set_limit(made, RecordType::kRefuse, kTextHeaderBytesMax, 0);
    return made;
  }();
  return limits;
}

net::Record encode(Message message) {
  return std::visit([](auto m) { return encode_one(std::move(m)); }, std::move(message));
}

Result<Message> decode(net::ReceivedRecord record) {
  static const std::array<Decoder, net::kRecordTypesMax> decoders = make_decoders();
  const Decoder decoder = record.type < decoders.size() ? decoders[record.type] : nullptr;
  if (decoder == nullptr) {
    return Status::data_loss("record type " + std::to_string(record.type) + " does not exist");
  }
  if (record.header.size() > kRecordHeaderBytesMax) {
    return Status::data_loss("record type " + std::to_string(record.type) + ": header too long");
  }
  return decoder(std::move(record));
}

const char* message_name(const Message& message) { return std::visit(NameOf{}, message); }

void FieldCheck::fail(const char* field, const std::string& what) {
  if (status_.is_ok()) status_ = Status::data_loss(std::string(message_) + "." + field + what);
}

void FieldCheck::range(const char* field, std::uint64_t value, std::uint64_t least,
                       std::uint64_t greatest) {
  if (value >= least && value <= greatest) return;
  fail(field, " is " + std::to_string(value) + ", outside [" + std::to_string(least) + ", " +
                  std::to_string(greatest) + "]");
}

void FieldCheck::finite(const char* field, double value) {
  if (!std::isfinite(value)) fail(field, " is not finite");
}

void FieldCheck::not_negative(const char* field, double value) {
  if (!(std::isfinite(value) && value >= 0)) fail(field, " is not a finite number >= 0");
}

void FieldCheck::name(const char* field, const std::string& text, std::size_t bytes_min,
                      std::size_t bytes_max) {
  range(field, text.size(), bytes_min, bytes_max);
  for (const char c : text) {
    if (c < 0x20 || c > 0x7e) return fail(field, " has a byte that is not printable");
  }
}

void FieldCheck::payload_bytes(std::size_t present, std::uint64_t expected) {
  if (present == expected) return;
  fail("payload",
       " has " + std::to_string(present) + " bytes instead of " + std::to_string(expected));
}

std::string clean_line(std::string text) {
  if (text.size() > kReasonBytesMax) text.resize(kReasonBytesMax);
  for (char& c : text) {
    if (c < 0x20 || c > 0x7e) c = '?';
  }
  return text;
}

}  // namespace tessera::wire
