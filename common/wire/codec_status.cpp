// SPDX-License-Identifier: Apache-2.0
// Codec of the cluster's state: one packed entry for each slave, and its details where wanted.
#include <bit>

#include "common/wire/codec_internal.h"
#include "proto/stats.pb.h"

namespace tessera::wire {

namespace {

// Numbers of an entry, behind the name: threads u32, isa u8, tiles_in_flight u32, tiles_done u64,
// utilisation f64, rtt_seconds f64, scene_version u64, tile_port u16, scene_port u16.
constexpr std::size_t kStatusNumbersBytes = 4 + 1 + 4 + 8 + 8 + 8 + 8 + 2 + 2;
static_assert(1 + kNameBytesMax + kStatusNumbersBytes <= kStatusEntryBytesMax);
static_assert(kNameBytesMax <= 255, "the length of a name is one byte");

void put_slave(std::vector<std::byte>& out, const SlaveStatus& s) {
  const std::string name = s.name.substr(0, kNameBytesMax);
  put_le(out, static_cast<std::uint8_t>(name.size()));
  for (const char c : name) out.push_back(static_cast<std::byte>(c));
  put_le(out, s.threads);
  put_le(out, static_cast<std::uint8_t>(s.isa));
  put_le(out, s.tiles_in_flight);
  put_le(out, s.tiles_done);
  put_le(out, std::bit_cast<std::uint64_t>(s.utilisation));
  put_le(out, std::bit_cast<std::uint64_t>(s.rtt_seconds));
  put_le(out, s.scene_version);
  put_le(out, s.tile_port);
  put_le(out, s.scene_port);
}

// Returns: the bytes used; 0 when they do not hold an entry or a field is out of range.
std::size_t get_slave(std::span<const std::byte> in, FieldCheck& check, SlaveStatus& s) {
  if (in.empty()) return 0;
  const std::size_t name_bytes = std::to_integer<std::size_t>(in[0]);
  const std::size_t entry_bytes = 1 + name_bytes + kStatusNumbersBytes;
  if (in.size() < entry_bytes) return 0;
  s.name.assign(reinterpret_cast<const char*>(in.data()) + 1, name_bytes);
  check.name("slaves.name", s.name, 1, kNameBytesMax);
  std::size_t at = 1 + name_bytes;
  const auto take = [&in, &at]<typename T>(T& value) {
    value = get_le<T>(in, at);
    at += sizeof(T);
  };
  std::uint8_t isa = 0;
  std::uint64_t utilisation = 0;
  std::uint64_t rtt_seconds = 0;
  take(s.threads);
  take(isa);
  take(s.tiles_in_flight);
  take(s.tiles_done);
  take(utilisation);
  take(rtt_seconds);
  take(s.scene_version);
  take(s.tile_port);
  take(s.scene_port);
  s.utilisation = std::bit_cast<double>(utilisation);
  s.rtt_seconds = std::bit_cast<double>(rtt_seconds);
  check.range("slaves.threads", s.threads, 1, kWorkersMax);
  check.range("slaves.isa", isa, 0, static_cast<std::uint64_t>(Isa::kAvx512));
  check.finite("slaves.utilisation", s.utilisation);
  check.not_negative("slaves.rtt_seconds", s.rtt_seconds);
  if (!check.is_ok()) return 0;
  s.isa = static_cast<Isa>(isa);
  return entry_bytes;
}

// Details of a slave, behind its entry, little-endian in this order: state u8, prefetch_depth u32,
// tiles_per_second f64, tile_seconds f64, issued, accepted, rejected, abandoned, queue_bytes,
// bytes_sent, bytes_received u64, ordinal u16, is_stalled u8. The first version had no is_stalled.
// A later one puts more behind; bytes that this one does not know are skipped.
constexpr std::size_t kDetailBytesMin = 1 + 4 + 2 * 8 + 7 * 8 + 2;
constexpr std::size_t kDetailBytes = kDetailBytesMin + 1;
static_assert(1 + kNameBytesMax + kStatusNumbersBytes + kDetailBytes <= kStatusEntryBytesMax);

void put_details(std::vector<std::byte>& out, const SlaveStatus& s) {
  const bool is_stalled = s.state == SlaveState::kStalled;
  put_le(out, static_cast<std::uint8_t>(is_stalled ? SlaveState::kReady : s.state));
  put_le(out, s.prefetch_depth);
  put_le(out, std::bit_cast<std::uint64_t>(s.tiles_per_second));
  put_le(out, std::bit_cast<std::uint64_t>(s.tile_seconds));
  put_le(out, s.tiles.issued);
  put_le(out, s.tiles.accepted);
  put_le(out, s.tiles.rejected);
  put_le(out, s.tiles.abandoned);
  put_le(out, s.queue_bytes);
  put_le(out, s.bytes_sent);
  put_le(out, s.bytes_received);
  put_le(out, s.ordinal);
  put_le(out, static_cast<std::uint8_t>(is_stalled));
}

// Requires: at least kDetailBytesMin bytes.
void get_details(std::span<const std::byte> in, FieldCheck& check, SlaveStatus& s) {
  std::size_t at = 0;
  const auto take = [&in, &at]<typename T>(T& value) {
    value = get_le<T>(in, at);
    at += sizeof(T);
  };
  std::uint8_t state = 0;
  std::uint64_t tiles_per_second = 0;
  std::uint64_t tile_seconds = 0;
  take(state);
  take(s.prefetch_depth);
  take(tiles_per_second);
  take(tile_seconds);
  take(s.tiles.issued);
  take(s.tiles.accepted);
  take(s.tiles.rejected);
  take(s.tiles.abandoned);
  take(s.queue_bytes);
  take(s.bytes_sent);
  take(s.bytes_received);
  take(s.ordinal);
  std::uint8_t is_stalled = 0;
  if (in.size() >= kDetailBytes) take(is_stalled);
  s.tiles.in_flight = s.tiles_in_flight;
  s.tiles_per_second = std::bit_cast<double>(tiles_per_second);
  s.tile_seconds = std::bit_cast<double>(tile_seconds);
  check.range("slaves.state", state, 0, static_cast<std::uint64_t>(SlaveState::kReady));
  check.not_negative("slaves.tiles_per_second", s.tiles_per_second);
  check.not_negative("slaves.tile_seconds", s.tile_seconds);
  check.range("slaves.is_stalled", is_stalled, 0, 1);
  if (!check.is_ok()) return;
  s.state = is_stalled != 0 ? SlaveState::kStalled : static_cast<SlaveState>(state);
}

void put_quarantined(std::vector<std::byte>& out, const QuarantinedSlave& q) {
  const std::string reason = clean_line(q.reason).substr(0, kQuarantineReasonBytesMax);
  for (const std::string& text : {q.name.substr(0, kNameBytesMax), reason}) {
    put_le(out, static_cast<std::uint8_t>(text.size()));
    for (const char c : text) out.push_back(static_cast<std::byte>(c));
  }
  put_le(out, std::bit_cast<std::uint64_t>(q.seconds));
  put_le(out, q.times);
}

// Returns: as get_slave().
std::size_t get_quarantined(std::span<const std::byte> in, FieldCheck& check, QuarantinedSlave& q) {
  std::size_t at = 0;
  for (std::string* text : {&q.name, &q.reason}) {
    if (in.size() <= at) return 0;
    const std::size_t bytes = std::to_integer<std::size_t>(in[at]);
    if (in.size() < at + 1 + bytes) return 0;
    text->assign(reinterpret_cast<const char*>(in.data()) + at + 1, bytes);
    at += 1 + bytes;
  }
  if (in.size() < at + sizeof(std::uint64_t) + sizeof(std::uint32_t)) return 0;
  q.seconds = std::bit_cast<double>(get_le<std::uint64_t>(in, at));
  q.times = get_le<std::uint32_t>(in, at + sizeof(std::uint64_t));
  check.name("quarantined.name", q.name, 1, kNameBytesMax);
  check.name("quarantined.reason", q.reason, 0, kQuarantineReasonBytesMax);
  check.not_negative("quarantined.seconds", q.seconds);
  return check.is_ok() ? at + sizeof(std::uint64_t) + sizeof(std::uint32_t) : 0;
}

void put_pace(const ClusterPace& p, proto::ClusterPace& h) {
  h.set_heartbeat_ms(p.heartbeat_ms);
  h.set_heartbeats_missed_max(p.heartbeats_missed_max);
  h.set_handshake_ms(p.handshake_ms);
  h.set_reconnect_max_ms(p.reconnect_max_ms);
  h.set_rtt_seconds_max(p.rtt_seconds_max);
  h.set_tile_seconds_median(p.tile_seconds_median);
  h.set_tile_seconds_p95(p.tile_seconds_p95);
}

// An older master sends no pace; all values are zero then.
ClusterPace get_pace(const proto::ClusterPace& h, FieldCheck& check) {
  check.range("pace.heartbeat_ms", h.heartbeat_ms(), 0, kHeartbeatMsMax);
  check.range("pace.heartbeats_missed_max", h.heartbeats_missed_max(), 0, kHeartbeatsMissedLimit);
  check.not_negative("pace.rtt_seconds_max", h.rtt_seconds_max());
  check.not_negative("pace.tile_seconds_median", h.tile_seconds_median());
  check.not_negative("pace.tile_seconds_p95", h.tile_seconds_p95());
  return {h.heartbeat_ms(),    h.heartbeats_missed_max(), h.handshake_ms(),    h.reconnect_max_ms(),
          h.rtt_seconds_max(), h.tile_seconds_median(),   h.tile_seconds_p95()};
}

// Of too many the last events are kept.
void put_log(std::vector<std::byte>& out, ClusterStatus& s, proto::StatusReply& h) {
  if (s.events.size() > kEventsMax)
    s.events.erase(s.events.begin(), s.events.end() - std::ptrdiff_t{kEventsMax});
  if (s.suppressed.size() > kSuppressedMax) s.suppressed.resize(kSuppressedMax);
  h.set_event_count(static_cast<std::uint32_t>(s.events.size()));
  h.set_suppressed_count(static_cast<std::uint32_t>(s.suppressed.size()));
  h.set_alone_reason(clean_line(s.alone_reason).substr(0, kAloneReasonBytesMax));
  for (const PastEvent& event : s.events) put_event(out, event);
  for (const SuppressedLines& lines : s.suppressed) put_suppressed(out, lines);
}

// Takes its entries off the front of the payload. An older master sends none.
void take_log(const proto::StatusReply& h, std::span<const std::byte>& rest, FieldCheck& check,
              ClusterStatus& s) {
  check.range("event_count", h.event_count(), 0, kEventsMax);
  check.range("suppressed_count", h.suppressed_count(), 0, kSuppressedMax);
  check.name("alone_reason", h.alone_reason(), 0, kAloneReasonBytesMax);
  if (!check.is_ok()) return;
  s.alone_reason = h.alone_reason();
  s.events.resize(h.event_count());
  s.suppressed.resize(h.suppressed_count());
  const auto take = [&](const char* field, std::size_t used) {
    if (used == 0) check.fail(field, ": payload ends within an entry");
    rest = rest.subspan(used);
    return check.is_ok();
  };
  for (PastEvent& event : s.events) {
    if (!take("events", get_event(rest, check, event))) return;
  }
  for (SuppressedLines& lines : s.suppressed) {
    if (!take("suppressed", get_suppressed(rest, check, lines))) return;
  }
}

}  // namespace

net::Record encode_one(StatusReply m) {
  if (m.status.slaves.size() > kConnectionsMax) m.status.slaves.resize(kConnectionsMax);
  proto::StatusReply h;
  h.set_frames_done(m.status.frames_done);
  h.set_has_application(m.status.has_application);
  h.set_slave_count(static_cast<std::uint32_t>(m.status.slaves.size()));
  if (m.status.quarantined.size() > kConnectionsMax) m.status.quarantined.resize(kConnectionsMax);
  h.set_quarantined_count(static_cast<std::uint32_t>(m.status.quarantined.size()));
  put_pace(m.status.pace, *h.mutable_pace());
  const TileAccounts& tiles = m.status.tiles;
  h.mutable_tiles()->set_issued(tiles.issued);
  h.mutable_tiles()->set_accepted(tiles.accepted);
  h.mutable_tiles()->set_rejected(tiles.rejected);
  h.mutable_tiles()->set_abandoned(tiles.abandoned);
  h.mutable_tiles()->set_in_flight(tiles.in_flight);
  std::vector<std::byte> payload;
  for (const SlaveStatus& slave : m.status.slaves) {
    put_slave(payload, slave);
    if (m.has_details) put_details(payload, slave);
  }
  for (const QuarantinedSlave& slave : m.status.quarantined) put_quarantined(payload, slave);
  put_log(payload, m.status, h);
  h.set_detail_bytes(m.has_details ? kDetailBytes : 0);
  h.set_frames_failed(m.status.frames_failed);
  h.set_frames_cancelled(m.status.frames_cancelled);
  h.set_frames_open(m.status.frames_open);
  h.set_tiles_reissued(m.status.tiles_reissued);
  h.set_slaves_lost(m.status.slaves_lost);
  return make_record(RecordType::kStatusReply, h, net::SharedBytes::of(std::move(payload)));
}

Result<Message> decode_status_reply(net::ReceivedRecord record) {
  proto::StatusReply h;
  if (!parse_header(record, h)) return bad_header("StatusReply");
  FieldCheck check("StatusReply");
  check.range("slave_count", h.slave_count(), 0, kConnectionsMax);
  // The details are absent, or hold at least what this version knows.
  if (h.detail_bytes() != 0)
    check.range("detail_bytes", h.detail_bytes(), kDetailBytesMin, kStatusEntryBytesMax);
  if (!check.is_ok()) return check.status();
  // Each entry has at least its byte of length and its numbers.
  check.range("slave_count", h.slave_count(), 0,
              record.payload.size() / (1 + kStatusNumbersBytes + h.detail_bytes()));
  check.range("quarantined_count", h.quarantined_count(), 0, kConnectionsMax);
  const ClusterPace pace = get_pace(h.pace(), check);
  if (!check.is_ok()) return check.status();
  StatusReply m;
  m.status.pace = pace;
  m.status.frames_done = h.frames_done();
  m.status.has_application = h.has_application();
  m.status.frames_failed = h.frames_failed();
  m.status.frames_cancelled = h.frames_cancelled();
  m.status.frames_open = h.frames_open();
  m.status.tiles = {h.tiles().issued(), h.tiles().accepted(), h.tiles().rejected(),
                    h.tiles().abandoned(), h.tiles().in_flight()};
  m.status.tiles_reissued = h.tiles_reissued();
  m.status.slaves_lost = h.slaves_lost();
  m.has_details = h.detail_bytes() != 0;
  m.status.slaves.resize(h.slave_count());
  std::span<const std::byte> rest(record.payload);
  for (SlaveStatus& slave : m.status.slaves) {
    const std::size_t used = get_slave(rest, check, slave);
    if (used == 0) check.fail("slaves", ": payload ends within an entry");
    if (!check.is_ok()) return check.status();
    rest = rest.subspan(used);
    if (!m.has_details) continue;
    if (rest.size() < h.detail_bytes()) {
      check.fail("slaves", ": payload ends within an entry");
    } else {
      get_details(rest, check, slave);
    }
    if (!check.is_ok()) return check.status();
    rest = rest.subspan(h.detail_bytes());
  }
  m.status.quarantined.resize(h.quarantined_count());
  for (QuarantinedSlave& slave : m.status.quarantined) {
    const std::size_t used = get_quarantined(rest, check, slave);
    if (used == 0) check.fail("quarantined", ": payload ends within an entry");
    if (!check.is_ok()) return check.status();
    rest = rest.subspan(used);
  }
  take_log(h, rest, check, m.status);
  check.payload_bytes(record.payload.size(), record.payload.size() - rest.size());
  if (!check.is_ok()) return check.status();
  return Message(std::move(m));
}

}  // namespace tessera::wire
