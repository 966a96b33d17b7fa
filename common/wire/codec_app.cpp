// SPDX-License-Identifier: Apache-2.0
// Codec of what a frame cost, and of the request for the cluster's state, whose reply is in
// codec_status.cpp.
#include "common/wire/codec_internal.h"
#include "proto/stats.pb.h"

namespace tessera::wire {

net::Record encode_one(FrameDone m) {
  proto::FrameDone h;
  const FrameStats& s = m.stats;
  h.set_frame(s.frame);
  h.set_seconds(s.seconds);
  h.set_scene_version(s.scene_version);
  h.set_isa(static_cast<std::uint32_t>(s.isa));
  h.set_is_mixed(s.is_mixed);
  h.set_slave_count(s.slave_count);
  h.set_tile_count(s.tile_count);
  h.set_tile_edge_px(s.tile_edge_px);
  h.set_tiles_reissued(s.tiles_reissued);
  h.set_tiles_rejected(s.tiles_rejected);
  h.set_rays_primary(s.rays.primary);
  h.set_rays_shadow(s.rays.shadow);
  h.set_rays_secondary(s.rays.secondary);
  h.set_bytes_to_slaves(s.bytes_to_slaves);
  h.set_bytes_from_slaves(s.bytes_from_slaves);
  h.set_build_seconds(s.build_seconds);
  h.set_utilisation(s.utilisation);
  h.set_tiles_duplicated(s.tiles_duplicated);
  h.set_render_seconds(s.render_seconds);
  h.set_tiles_faulty(s.tiles_faulty);
  h.set_pixels_faulty(s.pixels_faulty);
  h.set_prefetch_min(s.prefetch_min);
  h.set_prefetch_max(s.prefetch_max);
  h.set_completed_at_seconds(s.completed_at_seconds);
  h.set_built_primitives(s.scene_cost.built_primitives);
  h.set_scene_wait_seconds(s.scene_cost.wait_seconds);
  h.set_scene_bytes(s.scene_cost.bytes);
  h.set_digest(s.digest.bytes.data(), s.digest.bytes.size());
  h.set_error(clean_line(std::move(m.error)));
  h.set_is_final(m.is_final);
  h.set_tile_slave_count(static_cast<std::uint32_t>(m.tile_slave.size()));
  std::vector<std::byte> payload;
  payload.reserve(m.tile_slave.size() * sizeof(std::uint16_t));
  for (const std::uint16_t slave : m.tile_slave) put_le(payload, slave);
  return make_record(RecordType::kFrameDone, h, net::SharedBytes::of(std::move(payload)));
}

Result<Message> decode_frame_done(net::ReceivedRecord record) {
  proto::FrameDone h;
  if (!parse_header(record, h)) return bad_header("FrameDone");
  FieldCheck check("FrameDone");
  check.not_negative("seconds", h.seconds());
  check.range("isa", h.isa(), 0, static_cast<std::uint64_t>(Isa::kAvx512));
  check.range("slave_count", h.slave_count(), 0, kConnectionsMax);
  check.range("tile_count", h.tile_count(), 0, kTilesPerFrameMax);
  check.range("tile_edge_px", h.tile_edge_px(), 0, kTileEdgeMaxPx);
  check.not_negative("build_seconds", h.build_seconds());
  check.finite("utilisation", h.utilisation());
  check.not_negative("render_seconds", h.render_seconds());
  check.not_negative("completed_at_seconds", h.completed_at_seconds());
  check.not_negative("scene_wait_seconds", h.scene_wait_seconds());
  check.range("digest bytes", h.digest().size(), sizeof(Digest), sizeof(Digest));
  check.line("error", h.error());
  check.range("tile_slave_count", h.tile_slave_count(), 0, kTilesPerFrameMax);
  check.payload_bytes(record.payload.size(), std::uint64_t{h.tile_slave_count()} * 2);
  if (!check.is_ok()) return check.status();
  FrameDone m;
  FrameStats& s = m.stats;
  s.frame = h.frame();
  s.seconds = h.seconds();
  s.scene_version = h.scene_version();
  s.isa = static_cast<Isa>(h.isa());
  s.is_mixed = h.is_mixed();
  s.slave_count = h.slave_count();
  s.tile_count = h.tile_count();
  s.tile_edge_px = h.tile_edge_px();
  s.tiles_reissued = h.tiles_reissued();
  s.tiles_rejected = h.tiles_rejected();
  s.rays = {h.rays_primary(), h.rays_shadow(), h.rays_secondary()};
  s.bytes_to_slaves = h.bytes_to_slaves();
  s.bytes_from_slaves = h.bytes_from_slaves();
  s.build_seconds = h.build_seconds();
  s.utilisation = h.utilisation();
  s.tiles_duplicated = h.tiles_duplicated();
  s.tiles_faulty = h.tiles_faulty();
  s.pixels_faulty = h.pixels_faulty();
  s.render_seconds = h.render_seconds();
  s.prefetch_min = h.prefetch_min();
  s.prefetch_max = h.prefetch_max();
  s.completed_at_seconds = h.completed_at_seconds();
  s.scene_cost = {h.built_primitives(), h.scene_wait_seconds(), h.scene_bytes()};
  std::memcpy(s.digest.bytes.data(), h.digest().data(), sizeof(Digest));
  m.error = std::move(*h.mutable_error());
  m.is_final = h.is_final();
  m.tile_slave.resize(h.tile_slave_count());
  for (std::size_t i = 0; i < m.tile_slave.size(); ++i) {
    m.tile_slave[i] = get_le<std::uint16_t>(record.payload, i * 2);
  }
  return Message(std::move(m));
}

net::Record encode_one(StatusRequest m) {
  proto::StatusRequest h;
  h.set_wants_details(m.wants_details);
  h.set_wants_events(m.wants_events);
  return make_record(RecordType::kStatusRequest, h);
}

Result<Message> decode_status_request(net::ReceivedRecord record) {
  proto::StatusRequest h;
  if (!parse_header(record, h)) return bad_header("StatusRequest");
  FieldCheck check("StatusRequest");
  check.no_payload(record);
  if (!check.is_ok()) return check.status();
  return Message(StatusRequest{h.wants_details(), h.wants_events()});
}

}  // namespace tessera::wire
