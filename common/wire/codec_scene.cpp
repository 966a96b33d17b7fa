// SPDX-License-Identifier: Apache-2.0
// Codec of the messages of the scene stream.
#include <span>

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
  for (const std::uint32_t place : m.places) put_le(payload, place);
  h.set_index_bytes(m.index_bytes);
  h.set_is_again(m.is_again);
  h.set_time_seconds(m.time_seconds);
  return make_record(RecordType::kSceneAnnounce, h, net::SharedBytes::of(std::move(payload)));
}

Result<Message> decode_scene_announce(net::ReceivedRecord record) {
  proto::SceneAnnounce h;
  if (!parse_header(record, h)) return bad_header("SceneAnnounce");
  FieldCheck check("SceneAnnounce");
  check.at_least("version", h.version(), 1);
  check.range("block_count", h.block_count(), h.is_again() ? 0 : 1, kSceneBlocksMax);
  check.not_negative("time_seconds", h.time_seconds());
  const std::uint64_t entry_bytes =
      h.is_again() ? kAnnounceEntryBytes + kAnnouncePlaceBytes : kAnnounceEntryBytes;
  check.payload_bytes(record.payload.size(), h.block_count() * entry_bytes);
  if (!check.is_ok()) return check.status();
  const std::size_t count = h.block_count();
  SceneAnnounce m;
  m.version = h.version();
  m.index_bytes = h.index_bytes();
  m.is_again = h.is_again();
  m.time_seconds = h.time_seconds();
  m.digests.resize(count);
  m.sizes.resize(count);
  for (std::size_t i = 0; i < count; ++i) {
    std::memcpy(m.digests[i].bytes.data(), record.payload.data() + i * sizeof(Digest),
                sizeof(Digest));
    m.sizes[i] = get_le<std::uint64_t>(record.payload, count * sizeof(Digest) + i * 8);
    check.range("sizes", m.sizes[i], 1, kSceneBlockBytesMax);
  }
  for (std::size_t i = 0; h.is_again() && i < count; ++i) {
    const auto place = get_le<std::uint32_t>(record.payload, count * kAnnounceEntryBytes + i * 4);
    check.range("places", place, m.places.empty() ? 0 : std::uint64_t{m.places.back()} + 1,
                kSceneBlocksMax - 1);
    m.places.push_back(place);
  }
  if (!check.is_ok()) return check.status();
  return Message(std::move(m));
}

net::Record encode_one(SceneNeed m) {
  proto::SceneNeed h;
  h.set_version(m.version);
  h.set_block_count(static_cast<std::uint32_t>(m.blocks.size()));
  h.set_codings(m.codings);
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
  m.codings = h.codings() & kByteCodingsAll;
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
  h.set_coding(static_cast<std::uint32_t>(m.coding));
  return make_record(RecordType::kSceneChunk, h, std::move(m.bytes));
}

Result<Message> decode_scene_chunk(net::ReceivedRecord record) {
  proto::SceneChunk h;
  if (!parse_header(record, h)) return bad_header("SceneChunk");
  FieldCheck check("SceneChunk");
  const std::uint64_t bytes = record.payload.size();
  check.at_least("version", h.version(), 1);
  check.range("block", h.block(), 0, kSceneBlocksMax - 1);
  check.range("bytes", bytes, 1, kSceneChunkBytes);
  check.range("coding", h.coding(), 0, kByteCodingCount - 1);
  if (check.is_ok()) check.range("offset", h.offset(), 0, kSceneBlockBytesMax - bytes);
  if (!check.is_ok()) return check.status();
  return Message(SceneChunk{h.version(), h.block(), h.offset(),
                            net::SharedBytes::of(std::move(record.payload)),
                            static_cast<ByteCoding>(h.coding())});
}

net::Record encode_one(SceneChunkList m) {
  proto::SceneChunkList h;
  h.set_version(m.version);
  h.set_block(m.block);
  h.set_chunk_count(static_cast<std::uint32_t>(m.chunks.size()));
  const auto digests = std::as_bytes(std::span(m.chunks));
  std::vector<std::byte> payload(digests.begin(), digests.end());
  return make_record(RecordType::kSceneChunkList, h, net::SharedBytes::of(std::move(payload)));
}

Result<Message> decode_scene_chunk_list(net::ReceivedRecord record) {
  proto::SceneChunkList h;
  if (!parse_header(record, h)) return bad_header("SceneChunkList");
  FieldCheck check("SceneChunkList");
  check.at_least("version", h.version(), 1);
  check.range("block", h.block(), 0, kSceneBlocksMax - 1);
  check.range("chunk_count", h.chunk_count(), 2, kSceneBlockChunksMax);
  check.payload_bytes(record.payload.size(), std::uint64_t{h.chunk_count()} * sizeof(Digest));
  if (!check.is_ok()) return check.status();
  SceneChunkList m;
  m.version = h.version();
  m.block = h.block();
  m.chunks.resize(h.chunk_count());
  std::memcpy(m.chunks.data(), record.payload.data(), record.payload.size());
  return Message(std::move(m));
}

net::Record encode_one(SceneChunkNeed m) {
  proto::SceneChunkNeed h;
  h.set_version(m.version);
  h.set_block(m.block);
  h.set_chunk_count(static_cast<std::uint32_t>(m.chunks.size()));
  std::vector<std::byte> payload((m.chunks.size() + 7) / 8);
  for (std::size_t i = 0; i < m.chunks.size(); ++i) {
    if (m.chunks[i]) payload[i / 8] |= std::byte{1} << (i % 8);
  }
  return make_record(RecordType::kSceneChunkNeed, h, net::SharedBytes::of(std::move(payload)));
}

Result<Message> decode_scene_chunk_need(net::ReceivedRecord record) {
  proto::SceneChunkNeed h;
  if (!parse_header(record, h)) return bad_header("SceneChunkNeed");
  FieldCheck check("SceneChunkNeed");
  check.at_least("version", h.version(), 1);
  check.range("block", h.block(), 0, kSceneBlocksMax - 1);
  check.range("chunk_count", h.chunk_count(), 1, kSceneBlockChunksMax);
  check.payload_bytes(record.payload.size(), (std::uint64_t{h.chunk_count()} + 7) / 8);
  if (!check.is_ok()) return check.status();
  SceneChunkNeed m;
  m.version = h.version();
  m.block = h.block();
  m.chunks.resize(h.chunk_count());
  for (std::size_t i = 0; i < m.chunks.size(); ++i) {
    m.chunks[i] = (record.payload[i / 8] >> (i % 8) & std::byte{1}) != std::byte{0};
  }
  return Message(std::move(m));
}

net::Record encode_one(SceneBuilt m) {
  proto::SceneBuilt h;
  h.set_version(m.version);
  h.set_build_seconds(m.build_seconds);
  h.set_triangle_count(m.triangle_count);
  h.set_scene(m.scene.bytes.data(), m.scene.bytes.size());
  h.set_built_primitives(m.built_primitives);
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
  check.range("built_primitives", h.built_primitives(), 0, kTrianglesMax);
  if (!check.is_ok()) return check.status();
  SceneBuilt m{h.version(), h.build_seconds(), h.triangle_count(), {}, h.built_primitives()};
  std::memcpy(m.scene.bytes.data(), h.scene().data(), sizeof(Digest));
  return Message(m);
}

net::Record encode_one(SceneFailed m) {
  proto::SceneFailed h;
  h.set_version(m.version);
  h.set_reason(clean_line(std::move(m.reason)));
  h.set_needed_bytes(m.needed_bytes);
  h.set_free_bytes(m.free_bytes);
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
  return Message(
      SceneFailed{h.version(), std::move(*h.mutable_reason()), h.needed_bytes(), h.free_bytes()});
}

net::Record encode_one(SceneRetire m) {
  proto::SceneRetire h;
  h.set_first_kept(m.first_kept);
  h.set_keeps_newest(m.keeps_newest);
  return make_record(RecordType::kSceneRetire, h);
}

Result<Message> decode_scene_retire(net::ReceivedRecord record) {
  proto::SceneRetire h;
  if (!parse_header(record, h)) return bad_header("SceneRetire");
  FieldCheck check("SceneRetire");
  check.no_payload(record);
  check.at_least("first_kept", h.first_kept(), 1);
  if (!check.is_ok()) return check.status();
  return Message(SceneRetire{h.first_kept(), h.keeps_newest()});
}

}  // namespace tessera::wire
