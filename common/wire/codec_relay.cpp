// SPDX-License-Identifier: Apache-2.0
// Codec of the messages with which slaves feed slaves.
#include "common/wire/codec_internal.h"
#include "proto/scene.pb.h"

namespace tessera::wire {

net::Record encode_one(RelayFrom m) {
  proto::RelayFrom h;
  h.set_version(m.version);
  h.set_feeder(m.feeder);
  h.set_host(clean_line(std::move(m.host)));
  h.set_port(m.port);
  h.set_token(m.token);
  return make_record(RecordType::kRelayFrom, h);
}

Result<Message> decode_relay_from(net::ReceivedRecord record) {
  proto::RelayFrom h;
  if (!parse_header(record, h)) return bad_header("RelayFrom");
  FieldCheck check("RelayFrom");
  check.no_payload(record);
  check.at_least("version", h.version(), 1);
  const bool is_slave = h.feeder() != 0;
  check.name("host", h.host(), is_slave ? 1 : 0, is_slave ? kNameBytesMax : 0);
  check.range("port", h.port(), is_slave ? 1 : 0, is_slave ? 0xffff : 0);
  if (!check.is_ok()) return check.status();
  return Message(RelayFrom{h.version(), h.feeder(), std::move(*h.mutable_host()),
                           static_cast<std::uint16_t>(h.port()), h.token()});
}

net::Record encode_one(RelayFailed m) {
  proto::RelayFailed h;
  h.set_version(m.version);
  h.set_feeder(m.feeder);
  h.set_fault(static_cast<std::uint32_t>(m.fault));
  h.set_reason(clean_line(std::move(m.reason)));
  return make_record(RecordType::kRelayFailed, h);
}

Result<Message> decode_relay_failed(net::ReceivedRecord record) {
  proto::RelayFailed h;
  if (!parse_header(record, h)) return bad_header("RelayFailed");
  FieldCheck check("RelayFailed");
  check.no_payload(record);
  check.at_least("version", h.version(), 1);
  check.at_least("feeder", h.feeder(), 1);
  check.range("fault", h.fault(), 0, static_cast<std::uint64_t>(RelayFault::kAltered));
  check.line("reason", h.reason());
  if (!check.is_ok()) return check.status();
  return Message(RelayFailed{h.version(), h.feeder(), static_cast<RelayFault>(h.fault()),
                             std::move(*h.mutable_reason())});
}

net::Record encode_one(SceneProgress m) {
  proto::SceneProgress h;
  h.set_version(m.version);
  h.set_bytes(m.bytes);
  return make_record(RecordType::kSceneProgress, h);
}

Result<Message> decode_scene_progress(net::ReceivedRecord record) {
  proto::SceneProgress h;
  if (!parse_header(record, h)) return bad_header("SceneProgress");
  FieldCheck check("SceneProgress");
  check.no_payload(record);
  check.at_least("version", h.version(), 1);
  if (!check.is_ok()) return check.status();
  return Message(SceneProgress{h.version(), h.bytes()});
}

net::Record encode_one(RelayJoin m) {
  proto::RelayJoin h;
  h.set_token(m.token);
  h.set_codings(m.codings);
  return make_record(RecordType::kRelayJoin, h);
}

Result<Message> decode_relay_join(net::ReceivedRecord record) {
  proto::RelayJoin h;
  if (!parse_header(record, h)) return bad_header("RelayJoin");
  FieldCheck check("RelayJoin");
  check.no_payload(record);
  if (!check.is_ok()) return check.status();
  return Message(RelayJoin{h.token(), h.codings() & kByteCodingsAll});
}

}  // namespace tessera::wire
