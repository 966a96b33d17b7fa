// The scene stream.
#include "common/wire/codec_internal.h"
#include "proto/scene.pb.h"

namespace tessera::wire {

net::Record encode_one(SceneAnnounce m) {
  proto::SceneAnnounce h;
  h.set_version(m.version);
  h.set_block_count(static_cast<std::uint32_t>(m.digests.size()));
  std::vector<std::byte> payload;
  payload.reserve(m.digests.size() * kAnnounceEntryBytes);
  for (const Digest& digest : m.digests) {
    for (const std::uint8_t byte : digest.bytes) payload.push_back(std::byte{byte});
  }
  for (const std::uint64_t size : m.sizes) put_le(payload, size);
  return make_record(RecordType::kSceneAnnounce, h, net::SharedBytes::of(std::move(payload)));
}

Result<Message> decode_scene_announce(net::ReceivedRecord record) {
  proto::SceneAnnounce h;
  if (!parse_header(record, h)) return bad_header("SceneAnnounce");
  FieldCheck check("SceneAnnounce");
  check.at_least("version", h.version(), 1);
  check.range("block_count", h.block_count(), 1, kSceneBlocksMax);
  check.payload_bytes(record.payload.size(), std::uint64_t{h.block_count()} * kAnnounceEntryBytes);
  if (!check.is_ok()) return check.status();
  const std::size_t count = h.block_count();
  SceneAnnounce m;
  m.version = h.version();
  m.digests.resize(count);
  m.sizes.resize(count);
  for (std::size_t i = 0; i < count; ++i) {
    std::memcpy(m.digests[i].bytes.data(), record.payload.data() + i * sizeof(Digest),
                sizeof(Digest));
    m.sizes[i] = get_le<std::uint64_t>(record.payload, count * sizeof(Digest) + i * 8);
    check.range("sizes", m.sizes[i], 1, kSceneBlockBytesMax);
  }
  if (!check.is_ok()) return check.status();
  return Message(std::move(m));
}

net::Record encode_one(SceneNeed m) {
  proto::SceneNeed h;
  h.set_version(m.version);
  h.set_block_count(static_cast<std::uint32_t>(m.blocks.size()));
  std::vector<std::byte> payload;
  payload.reserve(m.blocks.size() * sizeof(std::uint32_t));
  for (const std::uint32_t block : m.blocks) put_le(payload, block);
  return make_record(RecordType::kSceneNeed, h, net::SharedBytes::of(std::move(payload)));
}

Result<Message> decode_scene_need(net::ReceivedRecord record) {
  proto::SceneNeed h;
  if (!parse_header(record, h)) return bad_header("SceneNeed");
  FieldCheck check("SceneNeed");
  check.at_least("version", h.version(), 1);
  check.range("block_count", h.block_count(), 0, kSceneBlocksMax);
  check.payload_bytes(record.payload.size(),
                      std::uint64_t{h.block_count()} * sizeof(std::uint32_t));
  if (!check.is_ok()) return check.status();
  SceneNeed m;
  m.version = h.version();
  m.blocks.reserve(h.block_count());
  for (std::size_t i = 0; i < h.block_count(); ++i) {
    const std::uint32_t block = get_le<std::uint32_t>(record.payload, i * 4);
    check.range("blocks", block, m.blocks.empty() ? 0 : std::uint64_t{m.blocks.back()} + 1,
                kSceneBlocksMax - 1);
    m.blocks.push_back(block);
  }
  if (!check.is_ok()) return check.status();
  return Message(std::move(m));
}

net::Record encode_one(SceneChunk m) {
  proto::SceneChunk h;
  h.set_version(m.version);
  h.set_block(m.block);
  h.set_offset(m.offset);
  return make_record(RecordType::kSceneChunk, h, std::move(m.bytes));
}

Result<Message> decode_scene_chunk(net::ReceivedRecord record) {
  proto::SceneChunk h;
  if (!parse_header(record, h)) return bad_header("SceneChunk");
  FieldCheck check("SceneChunk");
  const std::uint64_t bytes = record.payload.size();
  check.at_least("version", h.version(), 1);
  check.range("block", h.block(), 0, kSceneBlocksMax - 1);
  check.range("bytes", bytes, 1, kSceneChunkBytesMax);
  if (check.is_ok()) check.range("offset", h.offset(), 0, kSceneBlockBytesMax - bytes);
  if (!check.is_ok()) return check.status();
  return Message(SceneChunk{h.version(), h.block(), h.offset(),
                            net::SharedBytes::of(std::move(record.payload))});
}

net::Record encode_one(SceneBuilt m) {
  proto::SceneBuilt h;
  h.set_version(m.version);
  h.set_build_seconds(m.build_seconds);
  h.set_triangle_count(m.triangle_count);
  h.set_scene(m.scene.bytes.data(), m.scene.bytes.size());
  return make_record(RecordType::kSceneBuilt, h);
}

Result<Message> decode_scene_built(net::ReceivedRecord record) {
  proto::SceneBuilt h;
  if (!parse_header(record, h)) return bad_header("SceneBuilt");
  FieldCheck check("SceneBuilt");
  check.no_payload(record);
  check.at_least("version", h.version(), 1);
  check.not_negative("build_seconds", h.build_seconds());
  check.range("triangle_count", h.triangle_count(), 0, kTrianglesMax);
  check.range("scene bytes", h.scene().size(), sizeof(Digest), sizeof(Digest));
  if (!check.is_ok()) return check.status();
  SceneBuilt m{h.version(), h.build_seconds(), h.triangle_count(), {}};
  std::memcpy(m.scene.bytes.data(), h.scene().data(), sizeof(Digest));
  return Message(m);
}

net::Record encode_one(SceneFailed m) {
  proto::SceneFailed h;
  h.set_version(m.version);
  h.set_reason(clean_line(std::move(m.reason)));
  return make_record(RecordType::kSceneFailed, h);
}

Result<Message> decode_scene_failed(net::ReceivedRecord record) {
  proto::SceneFailed h;
  if (!parse_header(record, h)) return bad_header("SceneFailed");
  FieldCheck check("SceneFailed");
  check.no_payload(record);
  check.at_least("version", h.version(), 1);
  check.line("reason", h.reason());
  if (!check.is_ok()) return check.status();
  return Message(SceneFailed{h.version(), std::move(*h.mutable_reason())});
}

net::Record encode_one(SceneRetire m) {
  proto::SceneRetire h;
  h.set_first_kept(m.first_kept);
  return make_record(RecordType::kSceneRetire, h);
}

Result<Message> decode_scene_retire(net::ReceivedRecord record) {
  proto::SceneRetire h;
  if (!parse_header(record, h)) return bad_header("SceneRetire");
  FieldCheck check("SceneRetire");
  check.no_payload(record);
  check.at_least("first_kept", h.first_kept(), 1);
  if (!check.is_ok()) return check.status();
  return Message(SceneRetire{h.first_kept()});
}

}  // namespace tessera::wire
