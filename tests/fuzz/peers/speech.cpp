// SPDX-License-Identifier: Apache-2.0
#include "tests/fuzz/peers/speech.h"

#include <random>
#include <utility>

#include "common/scene/scene_codec.h"
#include "common/wire/codec.h"
#include "common/wire/record_types.h"
#include "tests/sim/picture.h"

namespace tessera::test {
namespace {

std::vector<std::byte> noise(std::size_t bytes, std::uint32_t seed) {
  std::mt19937 random(seed);
  std::vector<std::byte> block(bytes);
  for (std::byte& b : block) b = static_cast<std::byte>(random());
  return block;
}

std::vector<SceneBlock> make_blocks() {
  std::vector<SceneBlock> blocks;
  for (const int tag : {0, 1}) {
    for (const SceneBlock& block : sim::scene_of_tag(tag, sim::SceneWeight::kLight).blocks)
      blocks.push_back(block);
  }
  std::vector<std::byte> first = noise(kSceneChunkBytes + 100, 1), second = first;
  second.back() ^= std::byte{1};
  blocks.push_back(make_scene_block(std::move(first)));
  blocks.push_back(make_scene_block(std::move(second)));
  blocks.push_back(make_scene_block(noise(kSceneChunkBytes, 2)));
  blocks.push_back(make_scene_block(noise(1, 3)));
  return blocks;
}

}  // namespace

const std::vector<SceneBlock>& spoken_blocks() {
  static const std::vector<SceneBlock> blocks = make_blocks();
  return blocks;
}

std::uint64_t Speech::number() {
  const std::uint8_t byte = input_.byte();
  if (byte < 240) return byte % 6u;
  if (byte < 248) return input_.two_bytes();
  return ~std::uint64_t{0} >> (8 * (byte & 7u));
}

std::string Speech::name() {
  const std::uint8_t kind = input_.below(8);
  if (kind < 4) return std::string("s") + static_cast<char>('0' + kind);
  return input_.text(1 + input_.below(64));
}

FrameSettings Speech::settings() {
  FrameSettings s;
  s.width_px = 1 + input_.below(48);
  s.height_px = 1 + input_.below(48);
  s.tile_edge_px = kTileEdgeMinPx + input_.below(32);
  s.pixel_format = static_cast<PixelFormat>(input_.below(8) == 0 ? input_.below(3) : 2);
  s.renderer = static_cast<Renderer>(input_.below(4));
  if (input_.below(8) == 0) {
    s.samples_per_pixel = static_cast<int>(small() & 0x3ff);
    s.time_seconds = static_cast<double>(number());
    s.planes = PlaneSet::of_bits(input_.byte() & PlaneSet::all().bits());
    if (s.planes.is_empty()) s.width_px = static_cast<int>(small() & 0x7fff);
  }
  return s;
}

wire::Message Speech::hello() {
  wire::Hello hello;
  hello.role = static_cast<wire::Role>(input_.below(3));
  hello.name = name();
  hello.threads = 1 + input_.below(4);
  hello.isas = isa_bit(Isa::kScalar);
  if (input_.below(8) == 0) {
    hello.threads = small();
    hello.isas = input_.byte();
    hello.version_min = input_.byte();
    hello.version_max = input_.byte();
  }
  hello.instance = number();
  hello.memory_bytes = number();
  hello.relay_port = static_cast<std::uint16_t>(number());
  hello.relay_token = hello.relay_port == 0 ? 0 : 4711;
  return hello;
}

wire::SceneAnnounce Speech::announce() {
  wire::SceneAnnounce a;
  a.version = number();
  a.is_again = input_.below(8) == 0;
  a.index_bytes = number();
  const auto& blocks = spoken_blocks();
  if (a.is_again) {
    for (std::uint32_t place = input_.below(4); a.places.size() < input_.below(3);
         place += 1 + input_.below(3)) {
      const SceneBlock& block = blocks[input_.byte() % blocks.size()];
      a.places.push_back(place);
      a.digests.push_back(block.digest);
      a.sizes.push_back(block.bytes->size());
    }
    return a;
  }
  const std::uint8_t kind = input_.byte();
  if (kind < 128) {  // a whole scene of tests/sim
    for (const SceneBlock& block : sim::scene_of_tag(kind & 1, sim::SceneWeight::kLight).blocks) {
      a.digests.push_back(block.digest);
      a.sizes.push_back(block.bytes->size());
    }
    return a;
  }
  for (int i = 1 + kind % 5; i > 0; --i) {
    const std::uint8_t which = input_.byte();
    const SceneBlock& block = blocks[which % blocks.size()];
    a.digests.push_back(block.digest);
    a.sizes.push_back(which < 240 ? block.bytes->size() : number());
    if (which >= 252) a.digests.back().bytes[0] ^= 1;
  }
  return a;
}

wire::SceneChunkList Speech::chunk_list() {
  const auto& blocks = spoken_blocks();
  wire::SceneChunkList list{number(), small(), {}};
  const SceneBlock& block = blocks[input_.byte() % blocks.size()];
  if (block.chunks) list.chunks = *block.chunks;
  if (input_.below(16) == 0) list.chunks.resize(input_.below(8), block.digest);
  return list;
}

wire::SceneChunk Speech::chunk() {
  const auto& blocks = spoken_blocks();
  wire::SceneChunk chunk;
  chunk.version = number();
  chunk.block = small();
  const SceneBlock& block = blocks[input_.byte() % blocks.size()];
  const std::uint32_t index = input_.byte() % chunk_count(block.bytes->size());
  chunk.offset = std::uint64_t{index} * kSceneChunkBytes;
  const auto piece = block.bytes->subspan(chunk.offset, chunk_bytes(block.bytes->size(), index));
  std::vector<std::byte> bytes(piece.begin(), piece.end());
  const std::uint8_t kind = input_.byte();
  if (kind >= 224) chunk.offset = number() * kSceneChunkBytes;
  if (kind >= 208) bytes[input_.two_bytes() % bytes.size()] ^= std::byte{1};
  if (kind >= 192) bytes.resize(1 + input_.two_bytes() % bytes.size());
  if (kind >= 128 && kind < 192) {
    const auto coding = kind % 2 == 0 ? wire::ByteCoding::kLz4 : wire::ByteCoding::kZstd;
    std::vector<std::byte> coded;
    if (wire::code_bytes(coding, bytes, coded)) {
      bytes = std::move(coded);
      chunk.coding = coding;
    }
  }
  if (kind >= 248) chunk.coding = static_cast<wire::ByteCoding>(input_.below(3));
  chunk.bytes = net::SharedBytes::of(std::move(bytes));
  return chunk;
}

wire::Message Speech::scene_message() {
  switch (input_.below(4)) {
    case 0:
      return announce();
    case 1:
      return chunk_list();
    case 2:
      return wire::SceneRetire{number(), input_.yes()};
    default:
      return chunk();
  }
}

wire::Message Speech::of_master(std::uint8_t kind) {
  switch (kind) {
    case 0:
      return wire::Welcome{1, number(), number(), 50 + 50u * input_.below(20),
                           1u + input_.below(8)};
    case 1:
      return wire::Joined{};
    case 2:
      return wire::FrameBegin{number(), number(), Isa::kScalar, settings(),
                              input_.byte() & wire::kByteCodingsAll};
    case 3:
      return wire::TileLease{number(), small(), small()};
    case 4:
      return wire::FrameEnd{number()};
    default:
      return scene_message();
  }
}

wire::Message Speech::of_slave(std::uint8_t kind) {
  switch (kind) {
    case 0: {
      wire::TileResult r;
      r.frame = number();
      r.version = number();
      r.tile = small();
      r.attempt = small();
      r.seconds = r.held_seconds = 0.01;
      r.began_ns = number();
      r.worker = small();
      r.coding = static_cast<wire::ByteCoding>(input_.below(8) == 0 ? input_.below(3) : 0);
      r.pixels.resize(1 + input_.two_bytes() % 8192u, static_cast<std::byte>(input_.byte()));
      return r;
    }
    case 1:
      return wire::TileReturned{number(), small(), small()};
    case 2: {
      wire::SceneNeed need{number(), {}, input_.byte() & wire::kByteCodingsAll};
      for (std::uint32_t i = small() % 8; need.blocks.size() < 3 && input_.yes(); i += 1 + small())
        need.blocks.push_back(i);
      return need;
    }
    case 3:
      return wire::SceneBuilt{number(), 0.1, number(),
                              sim::scene_of_tag(input_.below(2), sim::SceneWeight::kLight).digest(),
                              number()};
    case 4:
      return wire::SceneFailed{number(), reason(), number(), number()};
    default:
      return wire::SceneProgress{number(), number()};
  }
}

wire::Message Speech::of_relay(std::uint8_t kind, const Heard& heard) {
  switch (kind) {
    case 0:
      return wire::RelayFrom{number(), number(), input_.yes() ? heard.host : name(),
                             static_cast<std::uint16_t>(1 + input_.byte()), heard.token};
    case 1:
      return wire::RelayFailed{number(), number(), static_cast<wire::RelayFault>(input_.below(3)),
                               reason()};
    case 2:
      return wire::RelayJoin{input_.below(8) == 0 ? number() : heard.token,
                             input_.byte() & wire::kByteCodingsAll};
    default: {
      wire::SceneChunkNeed need{number(), small(), {}};
      for (int i = 1 + input_.below(8); i > 0; --i) need.chunks.push_back(input_.yes());
      return need;
    }
  }
}

wire::Message Speech::of_application(std::uint8_t kind) {
  switch (kind) {
    case 0:
      return wire::FrameSubmit{number(), number(), settings()};
    case 1:
      return wire::FrameCancel{number()};
    case 2:
      return wire::FrameChunk{number(), number(), net::SharedBytes::of({std::byte{1}})};
    case 3:
      return wire::StatusRequest{input_.yes()};
    case 4:
      return wire::StatusReply{};
    default:
      return wire::FrameDone{};
  }
}

wire::Message Speech::message(std::uint8_t kind, const Heard& heard) {
  switch (kind) {
    case 0:
    case 1:
      return hello();
    case 2:
      return wire::Join{1, heard.session, heard.token};
    case 3:
      return wire::Join{1, number(), number()};
    case 4:
      return wire::Refuse{static_cast<wire::RefuseCode>(input_.below(8)), reason()};
    case 5:
      return wire::Ping{number()};
    case 6:
      return wire::Pong{number(), number()};
    case 7:
      return wire::Goodbye{reason()};
    default:
      break;
  }
  if (kind < 16) return of_master(kind - 8);
  if (kind < 22) return of_slave(kind - 16);
  if (kind < 26) return of_relay(kind - 22, heard);
  if (kind < 32) return of_application(kind - 26);
  return scene_message();
}

net::Record Speech::any_record() {
  net::Record record;
  record.type = input_.byte() % net::kRecordTypesMax;
  const std::size_t header_bytes = input_.byte(), payload_bytes = input_.byte();
  record.header = input_.text(header_bytes);
  record.payload = net::SharedBytes::of(input_.bytes(payload_bytes));
  return record;
}

net::Record Speech::record(const Heard& heard) {
  const std::uint8_t kind = input_.below(40);
  return kind >= 38 ? any_record() : wire::encode(message(kind, heard));
}

}  // namespace tessera::test
