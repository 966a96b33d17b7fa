// SPDX-License-Identifier: Apache-2.0
// Codec of the messages of frames, tiles and pixels.
#include "common/wire/codec_internal.h"
#include "proto/work.pb.h"

namespace tessera::wire {

namespace {

void put_settings(const FrameSettings& s, proto::FrameSettings& h) {
  h.set_width_px(static_cast<std::uint32_t>(s.width_px));
  h.set_height_px(static_cast<std::uint32_t>(s.height_px));
  h.set_eye_x(s.camera.eye.x);
  h.set_eye_y(s.camera.eye.y);
  h.set_eye_z(s.camera.eye.z);
  h.set_target_x(s.camera.target.x);
  h.set_target_y(s.camera.target.y);
  h.set_target_z(s.camera.target.z);
  h.set_up_x(s.camera.up.x);
  h.set_up_y(s.camera.up.y);
  h.set_up_z(s.camera.up.z);
  h.set_vfov_degrees(s.camera.vfov_degrees);
  h.set_renderer(static_cast<std::uint32_t>(s.renderer));
  h.set_pixel_format(static_cast<std::uint32_t>(s.pixel_format));
  h.set_tile_edge_px(static_cast<std::uint32_t>(s.tile_edge_px));
  h.set_samples_per_pixel(static_cast<std::uint32_t>(s.samples_per_pixel));
  h.set_light_samples(static_cast<std::uint32_t>(s.light_samples));
  h.set_seed(s.seed);
  h.set_bounces(static_cast<std::uint32_t>(s.bounces));
  h.set_vpls(static_cast<std::uint32_t>(s.vpls));
  h.set_interleave(static_cast<std::uint32_t>(s.interleave));
  h.set_is_filtered(s.is_filtered);
  h.set_clamp(s.clamp);
  h.set_is_compensated(s.is_compensated);
  h.set_pass(s.pass);
  h.set_exposure_ev(s.display.exposure_ev);
  h.set_tone(static_cast<std::uint32_t>(s.display.tone));
  h.set_planes(s.planes.bits());
  h.set_patch_method(static_cast<std::uint32_t>(s.patch_method));
  h.set_time_seconds(s.time_seconds);
}

// Numbers are narrowed only after their range is known.
void get_settings(const proto::FrameSettings& h, int tile_edge_also_px, FieldCheck& check,
                  FrameSettings& s) {
  check.range("settings.width_px", h.width_px(), 1, kImageSideMaxPx);
  check.range("settings.height_px", h.height_px(), 1, kImageSideMaxPx);
  check.range("settings.renderer", h.renderer(), 0, static_cast<std::uint64_t>(Renderer::kIgi));
  check.range("settings.pixel_format", h.pixel_format(), 0,
              static_cast<std::uint64_t>(PixelFormat::kDisplay8));
  if (h.tile_edge_px() != static_cast<std::uint32_t>(tile_edge_also_px))
    check.range("settings.tile_edge_px", h.tile_edge_px(), kTileEdgeMinPx, kTileEdgeMaxPx);
  check.range("settings.samples_per_pixel", h.samples_per_pixel(), 1, kSamplesPerPixelMax);
  check.range("settings.light_samples", h.light_samples(), 1, kLightSamplesMax);
  check.range("settings.bounces", h.bounces(), 0, kBouncesMax);
  check.range("settings.vpls", h.vpls(), 1, kVplsMax);
  check.range("settings.interleave", h.interleave(), 1, 5);
  check.range("settings.tone", h.tone(), 0, static_cast<std::uint64_t>(ToneCurve::kAgx));
  check.range("settings.pass", h.pass(), 0, kPassesMax - 1);
  check.range("settings.planes", h.planes(), 0, PlaneSet::all().bits());
  check.range("settings.patch_method", h.patch_method(), 0,
              static_cast<std::uint64_t>(PatchMethod::kClip));
  if (!check.is_ok()) return;
  s.width_px = static_cast<int>(h.width_px());
  s.height_px = static_cast<int>(h.height_px());
  s.camera.eye = {h.eye_x(), h.eye_y(), h.eye_z()};
  s.camera.target = {h.target_x(), h.target_y(), h.target_z()};
  s.camera.up = {h.up_x(), h.up_y(), h.up_z()};
  s.camera.vfov_degrees = h.vfov_degrees();
  s.renderer = static_cast<Renderer>(h.renderer());
  s.pixel_format = static_cast<PixelFormat>(h.pixel_format());
  s.tile_edge_px = static_cast<int>(h.tile_edge_px());
  s.samples_per_pixel = static_cast<int>(h.samples_per_pixel());
  s.light_samples = static_cast<int>(h.light_samples());
  s.bounces = static_cast<int>(h.bounces());
  s.vpls = static_cast<int>(h.vpls());
  s.interleave = static_cast<int>(h.interleave());
  s.is_filtered = h.is_filtered();
  s.clamp = h.clamp();
  s.is_compensated = h.is_compensated();
  s.pass = h.pass();
  s.display = {h.exposure_ev(), static_cast<ToneCurve>(h.tone())};
  s.planes = PlaneSet::of_bits(h.planes());
  s.patch_method = static_cast<PatchMethod>(h.patch_method());
  s.seed = h.seed();
  s.time_seconds = h.time_seconds();
  const Status status = validate_frame_settings(s);
  if (!status.is_ok()) check.fail("settings", ": " + status.message());
}

}  // namespace

net::Record encode_one(FrameBegin m) {
  proto::FrameBegin h;
  h.set_frame(m.frame);
  h.set_version(m.version);
  h.set_isa(static_cast<std::uint32_t>(m.isa));
  put_settings(m.settings, *h.mutable_settings());
  h.set_pixel_codings(m.pixel_codings);
  return make_record(RecordType::kFrameBegin, h);
}

Result<Message> decode_frame_begin(net::ReceivedRecord record) {
  proto::FrameBegin h;
  if (!parse_header(record, h)) return bad_header("FrameBegin");
  FieldCheck check("FrameBegin");
  FrameBegin m;
  check.no_payload(record);
  check.at_least("version", h.version(), 1);
  check.range("isa", h.isa(), 0, static_cast<std::uint64_t>(Isa::kAvx512));
  get_settings(h.settings(), kTileEdgeMinPx, check, m.settings);
  if (!check.is_ok()) return check.status();
  m.frame = h.frame();
  m.version = h.version();
  m.isa = static_cast<Isa>(h.isa());
  m.pixel_codings = h.pixel_codings() & kByteCodingsAll;  // others are of a later version
  return Message(m);
}

net::Record encode_one(TileLease m) {
  proto::TileLease h;
  h.set_frame(m.frame);
  h.set_tile(m.tile);
  h.set_attempt(m.attempt);
  return make_record(RecordType::kTileLease, h);
}

Result<Message> decode_tile_lease(net::ReceivedRecord record) {
  proto::TileLease h;
  if (!parse_header(record, h)) return bad_header("TileLease");
  FieldCheck check("TileLease");
  check.no_payload(record);
  check.range("tile", h.tile(), 0, kTilesPerFrameMax - 1);
  check.at_least("attempt", h.attempt(), 1);
  if (!check.is_ok()) return check.status();
  return Message(TileLease{h.frame(), h.tile(), h.attempt()});
}

net::Record encode_one(FrameEnd m) {
  proto::FrameEnd h;
  h.set_frame(m.frame);
  return make_record(RecordType::kFrameEnd, h);
}

Result<Message> decode_frame_end(net::ReceivedRecord record) {
  proto::FrameEnd h;
  if (!parse_header(record, h)) return bad_header("FrameEnd");
  FieldCheck check("FrameEnd");
  check.no_payload(record);
  if (!check.is_ok()) return check.status();
  return Message(FrameEnd{h.frame()});
}

net::Record encode_one(TileResult m) {
  proto::TileResult h;
  h.set_frame(m.frame);
  h.set_version(m.version);
  h.set_tile(m.tile);
  h.set_attempt(m.attempt);
  h.set_seconds(m.seconds);
  h.set_starved_seconds(m.starved_seconds);
  h.set_held_seconds(m.held_seconds);
  h.set_rays_primary(m.rays.primary);
  h.set_rays_shadow(m.rays.shadow);
  h.set_rays_secondary(m.rays.secondary);
  h.set_began_ns(m.began_ns);
  h.set_worker(m.worker);
  h.set_coding(static_cast<std::uint32_t>(m.coding));
  return make_record(RecordType::kTileResult, h, net::SharedBytes::of(std::move(m.pixels)));
}

Result<Message> decode_tile_result(net::ReceivedRecord record) {
  proto::TileResult h;
  if (!parse_header(record, h)) return bad_header("TileResult");
  FieldCheck check("TileResult");
  check.at_least("version", h.version(), 1);
  check.range("tile", h.tile(), 0, kTilesPerFrameMax - 1);
  check.at_least("attempt", h.attempt(), 1);
  check.not_negative("seconds", h.seconds());
  check.not_negative("starved_seconds", h.starved_seconds());
  check.not_negative("held_seconds", h.held_seconds());
  check.range("pixels", record.payload.size(), 1, kTilePayloadBytesMax);
  check.range("worker", h.worker(), 0, kWorkersMax - 1);
  check.range("coding", h.coding(), 0, kByteCodingCount - 1);
  if (!check.is_ok()) return check.status();
  TileResult m;
  m.frame = h.frame();
  m.version = h.version();
  m.tile = h.tile();
  m.attempt = h.attempt();
  m.seconds = h.seconds();
  m.starved_seconds = h.starved_seconds();
  m.held_seconds = h.held_seconds();
  m.rays = {h.rays_primary(), h.rays_shadow(), h.rays_secondary()};
  m.began_ns = h.began_ns();
  m.worker = h.worker();
  m.pixels = std::move(record.payload);
  m.coding = static_cast<ByteCoding>(h.coding());
  return Message(std::move(m));
}

net::Record encode_one(TileReturned m) {
  proto::TileReturned h;
  h.set_frame(m.frame);
  h.set_tile(m.tile);
  h.set_attempt(m.attempt);
  return make_record(RecordType::kTileReturned, h);
}

Result<Message> decode_tile_returned(net::ReceivedRecord record) {
  proto::TileReturned h;
  if (!parse_header(record, h)) return bad_header("TileReturned");
  FieldCheck check("TileReturned");
  check.no_payload(record);
  check.range("tile", h.tile(), 0, kTilesPerFrameMax - 1);
  check.at_least("attempt", h.attempt(), 1);
  if (!check.is_ok()) return check.status();
  return Message(TileReturned{h.frame(), h.tile(), h.attempt()});
}

net::Record encode_one(FrameSubmit m) {
  proto::FrameSubmit h;
  h.set_frame(m.frame);
  h.set_version(m.version);
  put_settings(m.settings, *h.mutable_settings());
  return make_record(RecordType::kFrameSubmit, h);
}

Result<Message> decode_frame_submit(net::ReceivedRecord record) {
  proto::FrameSubmit h;
  if (!parse_header(record, h)) return bad_header("FrameSubmit");
  FieldCheck check("FrameSubmit");
  FrameSubmit m;
  check.no_payload(record);
  check.at_least("version", h.version(), 1);
  get_settings(h.settings(), kTileEdgeAuto, check, m.settings);
  if (!check.is_ok()) return check.status();
  m.frame = h.frame();
  m.version = h.version();
  return Message(m);
}

net::Record encode_one(FrameCancel m) {
  proto::FrameCancel h;
  h.set_frame(m.frame);
  return make_record(RecordType::kFrameCancel, h);
}

Result<Message> decode_frame_cancel(net::ReceivedRecord record) {
  proto::FrameCancel h;
  if (!parse_header(record, h)) return bad_header("FrameCancel");
  FieldCheck check("FrameCancel");
  check.no_payload(record);
  if (!check.is_ok()) return check.status();
  return Message(FrameCancel{h.frame()});
}

net::Record encode_one(FrameChunk m) {
  proto::FrameChunk h;
  h.set_frame(m.frame);
  h.set_offset(m.offset);
  return make_record(RecordType::kFrameChunk, h, std::move(m.bytes));
}

Result<Message> decode_frame_chunk(net::ReceivedRecord record) {
  proto::FrameChunk h;
  if (!parse_header(record, h)) return bad_header("FrameChunk");
  FieldCheck check("FrameChunk");
  const std::uint64_t bytes = record.payload.size();
  check.range("bytes", bytes, 1, kFrameChunkBytesMax);
  if (check.is_ok()) check.range("offset", h.offset(), 0, kFrameBytesMax - bytes);
  if (!check.is_ok()) return check.status();
  return Message(
      FrameChunk{h.frame(), h.offset(), net::SharedBytes::of(std::move(record.payload))});
}

}  // namespace tessera::wire
