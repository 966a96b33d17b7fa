// SPDX-License-Identifier: Apache-2.0
// Writer of the bytes of one scene block, and a reader that does not trust them.
// Threads. One at a time.
#pragma once

#include <bit>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include "common/base/limits.h"

namespace tessera {

static_assert(std::endian::native == std::endian::little,
              "arrays are copied as they lie in memory");

// The first eight bytes of a block are its kind and the version of its layout.
enum class BlockKind : std::uint32_t {
  kRoot = 0x52535354,
  kMesh = 0x4d535354,
  kPatchSurface = 0x50535354,
  kTexture = 0x54535354,
  kEnvironment = 0x45535354,
  kAnimation = 0x41535354
};
inline constexpr std::uint32_t kLayoutVersion = 10;

// The bytes behind a large array begin at a chunk, so that an array that grew or shrank leaves the
// chunks behind it as they were (README.md). An array is large when that costs 6 % at most.
inline constexpr std::uint64_t kLargeArrayBytes = 16 * kSceneChunkBytes;
constexpr std::uint64_t padding_behind(std::uint64_t array_bytes, std::uint64_t block_bytes) {
  const std::uint64_t over = block_bytes % kSceneChunkBytes;
  return array_bytes < kLargeArrayBytes || over == 0 ? 0 : kSceneChunkBytes - over;
}

// A record lies in one chunk, so that one that changed changes no other chunk.
constexpr std::uint64_t padding_before(std::uint64_t record_bytes, std::uint64_t block_bytes) {
  const std::uint64_t over = block_bytes % kSceneChunkBytes;
  return over + record_bytes <= kSceneChunkBytes ? 0 : kSceneChunkBytes - over;
}

class BlockWriter {
 public:
  explicit BlockWriter(BlockKind kind) {
    put(kind);
    put(kLayoutVersion);
  }
  // Takes memory for so many bytes at once.
  void reserve(std::uint64_t bytes) { bytes_.reserve(bytes); }
  template <typename T>
  void put(const T& value) {
    static_assert(std::is_trivially_copyable_v<T>);
    append(&value, sizeof(T));
  }
  template <typename T>
  void put_array(const std::vector<T>& values) {
    static_assert(std::is_trivially_copyable_v<T>);
    put(std::uint64_t{values.size()});
    append(values.data(), values.size() * sizeof(T));
    bytes_.resize(bytes_.size() + padding_behind(values.size() * sizeof(T), bytes_.size()));
  }
  void put_text(const std::string& text) {
    put(std::uint64_t{text.size()});
    append(text.data(), text.size());
  }
  // Must be called before a record of this many bytes, at most a chunk, is put.
  void begin_record(std::uint64_t record_bytes) {
    bytes_.resize(bytes_.size() + padding_before(record_bytes, bytes_.size()));
  }
  std::vector<std::byte> finish() { return std::move(bytes_); }

 private:
  void append(const void* data, std::size_t size) {
    const auto* begin = static_cast<const std::byte*>(data);
    bytes_.insert(bytes_.end(), begin, begin + size);
  }
  std::vector<std::byte> bytes_;
};

// Every read says whether its bytes were there; after one that failed, all fail.
class BlockReader {
 public:
  explicit BlockReader(std::span<const std::byte> bytes)
      : block_bytes_(bytes.size()), rest_(bytes) {}

  bool open(BlockKind kind) {
    return get<BlockKind>() == kind && get<std::uint32_t>() == kLayoutVersion && is_good_;
  }
  template <typename T>
  T get() {
    T value{};
    if (take(sizeof(T))) std::memcpy(&value, taken_.data(), sizeof(T));
    return value;
  }
  template <typename T>
  bool get_array(std::vector<T>& values) {
    const std::uint64_t count = get<std::uint64_t>();
    if (!is_good_ || count > rest_.size() / sizeof(T)) return is_good_ = false;
    take(count * sizeof(T));
    values.resize(count);
    if (count > 0) std::memcpy(values.data(), taken_.data(), taken_.size());
    return skip_padding(count * sizeof(T));
  }
  bool get_text(std::string& text) {
    const std::uint64_t count = get<std::uint64_t>();
    if (!take(count)) return false;
    text.assign(reinterpret_cast<const char*>(taken_.data()), count);
    return true;
  }
  // A count of elements of at least `bytes_each` bytes, checked against what is left.
  std::uint64_t get_count(std::uint64_t bytes_each) {
    const std::uint64_t count = get<std::uint64_t>();
    if (!is_good_ || count > rest_.size() / bytes_each) {
      is_good_ = false;
      return 0;
    }
    return count;
  }
  // To be called before the fields of a record are got, as by the writer.
  bool begin_record(std::uint64_t record_bytes) {
    return skip_zeros(padding_before(record_bytes, block_bytes_ - rest_.size()));
  }
  bool skip_array(std::uint64_t bytes_each) {
    const std::uint64_t bytes = get_count(bytes_each) * bytes_each;
    return take(bytes) && skip_padding(bytes);
  }
  bool is_good() const { return is_good_; }
  bool is_finished() const { return is_good_ && rest_.empty(); }

 private:
  bool take(std::uint64_t size) {
    if (!is_good_ || size > rest_.size()) return is_good_ = false;
    taken_ = rest_.first(size);
    rest_ = rest_.subspan(size);
    return true;
  }
  bool skip_padding(std::uint64_t array_bytes) {
    return skip_zeros(padding_behind(array_bytes, block_bytes_ - rest_.size()));
  }
  // Padding must be zeros, so that equal content has equal bytes.
  bool skip_zeros(std::uint64_t size) {
    if (!take(size)) return false;
    for (const std::byte b : taken_) is_good_ &= b == std::byte{0};
    return is_good_;
  }

  const std::uint64_t block_bytes_;
  std::span<const std::byte> rest_, taken_;
  bool is_good_ = true;
};

// Returns: false for a value above `last`.
template <typename Enum>
bool get_enum(BlockReader& in, Enum& value, Enum last) {
  const auto number = in.get<std::uint32_t>();
  if (number > static_cast<std::uint32_t>(last)) return false;
  value = static_cast<Enum>(number);
  return in.is_good();
}

}  // namespace tessera
