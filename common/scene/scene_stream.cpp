// SPDX-License-Identifier: Apache-2.0
#include "common/scene/scene_stream.h"

#include <cstdint>
#include <cstring>

#include "common/base/limits.h"

namespace tessera {
namespace {

constexpr std::uint32_t kMagic = 0x4d495354;  // "TSIM"
constexpr std::uint32_t kVersion = 1;
constexpr std::uint64_t kWarningsMax = 4096;

void put(std::vector<std::byte>& out, const void* data, std::size_t size) {
  const auto* begin = static_cast<const std::byte*>(data);
  out.insert(out.end(), begin, begin + size);
}
void put_u64(std::vector<std::byte>& out, std::uint64_t value) { put(out, &value, sizeof(value)); }

bool take(std::span<const std::byte>& rest, void* to, std::size_t size) {
  if (rest.size() < size) return false;
  if (size > 0) std::memcpy(to, rest.data(), size);
  rest = rest.subspan(size);
  return true;
}

}  // namespace

std::vector<std::byte> encode_scene_stream(const SceneStream& stream) {
  std::vector<std::byte> out;
  out.reserve(stream.scene.total_bytes() + 4096);
  put(out, &kMagic, sizeof(kMagic));
  put(out, &kVersion, sizeof(kVersion));
  const std::uint64_t warning_count = std::min<std::uint64_t>(stream.warnings.size(), kWarningsMax);
  put_u64(out, warning_count);
  for (std::uint64_t i = 0; i < warning_count; ++i) {
    put_u64(out, stream.warnings[i].size());
    put(out, stream.warnings[i].data(), stream.warnings[i].size());
  }
  put_u64(out, stream.scene.blocks.size());
  for (const SceneBlock& block : stream.scene.blocks) {
    put_u64(out, block.bytes->size());
    put(out, block.digest.bytes.data(), block.digest.bytes.size());
    put(out, block.bytes->data(), block.bytes->size());
  }
  return out;
}

Result<SceneStream> decode_scene_stream(std::span<const std::byte> rest) {
  const Status malformed = Status::data_loss("the scene stream is malformed");
  SceneStream stream;
  std::uint32_t head[2] = {};
  std::uint64_t count = 0;
  if (!take(rest, head, sizeof(head)) || head[0] != kMagic || head[1] != kVersion) return malformed;
  if (!take(rest, &count, sizeof(count)) || count > kWarningsMax) return malformed;
  for (std::uint64_t i = 0; i < count; ++i) {
    std::uint64_t size = 0;
    if (!take(rest, &size, sizeof(size)) || size > rest.size()) return malformed;
    stream.warnings.emplace_back(reinterpret_cast<const char*>(rest.data()), size);
    rest = rest.subspan(size);
  }
  if (!take(rest, &count, sizeof(count)) || count > kSceneBlocksMax) return malformed;
  std::vector<SceneBlock> blocks;
  for (std::uint64_t i = 0; i < count; ++i) {
    std::uint64_t size = 0;
    Digest digest;
    if (!take(rest, &size, sizeof(size)) || !take(rest, digest.bytes.data(), 32) ||
        size > rest.size())
      return malformed;
    SceneBlock block =
        make_scene_block({rest.begin(), rest.begin() + static_cast<std::ptrdiff_t>(size)});
    rest = rest.subspan(size);
    if (block.digest != digest) return Status::data_loss("a scene block's digest differs");
    blocks.push_back(std::move(block));
  }
  stream.scene.blocks = std::move(blocks);
  if (!rest.empty()) return malformed;
  return stream;
}

}  // namespace tessera
