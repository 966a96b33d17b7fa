// SPDX-License-Identifier: Apache-2.0
// Codec of the messages of handshake, liveness and farewell.
#include "common/wire/codec_internal.h"
#include "proto/envelope.pb.h"

namespace tessera::wire {

net::Record encode_one(Hello m) {
  proto::Hello h;
  h.set_role(static_cast<std::uint32_t>(m.role));
  h.set_version_min(m.version_min);
  h.set_version_max(m.version_max);
  h.set_name(clean_line(std::move(m.name)));
  h.set_threads(m.threads);
  h.set_isas(m.isas);
  h.set_build_id(clean_line(std::move(m.build_id)));
  h.set_memory_bytes(m.memory_bytes);
  h.set_relay_port(m.relay_port);
  h.set_relay_token(m.relay_token);
  h.set_instance(m.instance);
  return make_record(RecordType::kHello, h);
}

Result<Message> decode_hello(net::ReceivedRecord record) {
  proto::Hello h;
  if (!parse_header(record, h)) return bad_header("Hello");
  FieldCheck check("Hello");
  check.no_payload(record);
  check.range("role", h.role(), 0, static_cast<std::uint64_t>(Role::kStatus));
  check.range("version_min", h.version_min(), 1, 0xffff);
  check.range("version_max", h.version_max(), h.version_min(), 0xffff);
  check.name("name", h.name(), 1, kNameBytesMax);
  check.name("build_id", h.build_id(), 0, kBuildIdBytesMax);
  const bool is_slave = h.role() == static_cast<std::uint32_t>(Role::kSlave);
  check.range("threads", h.threads(), is_slave ? 1 : 0, kWorkersMax);
  check.range("isas", h.isas(), is_slave ? 1 : 0, kIsaMaskAll);
  check.range("relay_port", h.relay_port(), 0, 0xffff);
  if (!check.is_ok()) return check.status();
  Hello m;
  m.role = static_cast<Role>(h.role());
  m.version_min = static_cast<std::uint16_t>(h.version_min());
  m.version_max = static_cast<std::uint16_t>(h.version_max());
  m.name = std::move(*h.mutable_name());
  m.threads = h.threads();
  m.isas = h.isas();
  m.build_id = std::move(*h.mutable_build_id());
  m.memory_bytes = h.memory_bytes();
  m.relay_port = static_cast<std::uint16_t>(h.relay_port());
  m.relay_token = h.relay_token();
  m.instance = h.instance();
  return Message(std::move(m));
}

net::Record encode_one(Welcome m) {
  proto::Welcome h;
  h.set_version(m.version);
  h.set_session(m.session);
  h.set_token(m.token);
  h.set_heartbeat_ms(m.heartbeat_ms);
  h.set_heartbeats_missed_max(m.heartbeats_missed_max);
  h.set_issues_certificates(m.issues_certificates);
  return make_record(RecordType::kWelcome, h);
}

Result<Message> decode_welcome(net::ReceivedRecord record) {
  proto::Welcome h;
  if (!parse_header(record, h)) return bad_header("Welcome");
  FieldCheck check("Welcome");
  check.no_payload(record);
  check.range("version", h.version(), 1, 0xffff);
  check.at_least("session", h.session(), 1);
  check.range("heartbeat_ms", h.heartbeat_ms(), 1, kHeartbeatMsMax);
  check.range("heartbeats_missed_max", h.heartbeats_missed_max(), 1, kHeartbeatsMissedLimit);
  if (!check.is_ok()) return check.status();
  return Message(Welcome{static_cast<std::uint16_t>(h.version()), h.session(), h.token(),
                         h.heartbeat_ms(), h.heartbeats_missed_max(), h.issues_certificates()});
}

net::Record encode_one(Join m) {
  proto::Join h;
  h.set_version(m.version);
  h.set_session(m.session);
  h.set_token(m.token);
  return make_record(RecordType::kJoin, h);
}

Result<Message> decode_join(net::ReceivedRecord record) {
  proto::Join h;
  if (!parse_header(record, h)) return bad_header("Join");
  FieldCheck check("Join");
  check.no_payload(record);
  check.range("version", h.version(), 1, 0xffff);
  check.at_least("session", h.session(), 1);
  if (!check.is_ok()) return check.status();
  return Message(Join{static_cast<std::uint16_t>(h.version()), h.session(), h.token()});
}

net::Record encode_one(Joined) { return make_record(RecordType::kJoined, proto::Joined()); }

Result<Message> decode_joined(net::ReceivedRecord record) {
  proto::Joined h;
  if (!parse_header(record, h)) return bad_header("Joined");
  FieldCheck check("Joined");
  check.no_payload(record);
  if (!check.is_ok()) return check.status();
  return Message(Joined{});
}

net::Record encode_one(Refuse m) {
  proto::Refuse h;
  h.set_code(static_cast<std::uint32_t>(m.code));
  h.set_reason(clean_line(std::move(m.reason)));
  return make_record(RecordType::kRefuse, h);
}

Result<Message> decode_refuse(net::ReceivedRecord record) {
  proto::Refuse h;
  if (!parse_header(record, h)) return bad_header("Refuse");
  FieldCheck check("Refuse");
  check.no_payload(record);
  check.range("code", h.code(), 0, static_cast<std::uint64_t>(RefuseCode::kProtocol));
  check.line("reason", h.reason());
  if (!check.is_ok()) return check.status();
  return Message(Refuse{static_cast<RefuseCode>(h.code()), std::move(*h.mutable_reason())});
}

net::Record encode_one(Ping m) {
  proto::Ping h;
  h.set_sent_ns(m.sent_ns);
  return make_record(RecordType::kPing, h);
}

Result<Message> decode_ping(net::ReceivedRecord record) {
  proto::Ping h;
  if (!parse_header(record, h)) return bad_header("Ping");
  FieldCheck check("Ping");
  check.no_payload(record);
  if (!check.is_ok()) return check.status();
  return Message(Ping{h.sent_ns()});
}

net::Record encode_one(Pong m) {
  proto::Pong h;
  h.set_sent_ns(m.sent_ns);
  h.set_answered_ns(m.answered_ns);
  return make_record(RecordType::kPong, h);
}

Result<Message> decode_pong(net::ReceivedRecord record) {
  proto::Pong h;
  if (!parse_header(record, h)) return bad_header("Pong");
  FieldCheck check("Pong");
  check.no_payload(record);
  if (!check.is_ok()) return check.status();
  return Message(Pong{h.sent_ns(), h.answered_ns()});
}

net::Record encode_one(Goodbye m) {
  proto::Goodbye h;
  h.set_reason(clean_line(std::move(m.reason)));
  return make_record(RecordType::kGoodbye, h);
}

Result<Message> decode_goodbye(net::ReceivedRecord record) {
  proto::Goodbye h;
  if (!parse_header(record, h)) return bad_header("Goodbye");
  FieldCheck check("Goodbye");
  check.no_payload(record);
  check.line("reason", h.reason());
  if (!check.is_ok()) return check.status();
  return Message(Goodbye{std::move(*h.mutable_reason())});
}

}  // namespace tessera::wire
