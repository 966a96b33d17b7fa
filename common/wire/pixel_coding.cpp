// SPDX-License-Identifier: Apache-2.0
#include "common/wire/pixel_coding.h"

#include <array>
#include <cstdint>
#include <cstring>
#include <type_traits>
#include <utility>

#include "common/base/check.h"

namespace tessera::wire {
namespace {

constexpr std::array<std::size_t, 3> kChannels = {1, 0, 2};  // green first, the others refer to it

template <typename T>
T load(const std::byte* from, std::size_t component) {
  T value{};
  std::memcpy(&value, from + component * sizeof(T), sizeof(T));
  return value;
}

// fold() maps differences of either sign to small unsigned numbers, and unfold() maps them back.
template <typename T>
T fold(T difference) {
  const auto sign =
      static_cast<std::make_signed_t<T>>(difference) < 0 ? static_cast<T>(~T{0}) : T{0};
  return static_cast<T>(static_cast<T>(difference << 1) ^ sign);
}
template <typename T>
T unfold(T folded) {
  const T sign = (folded & 1) != 0 ? static_cast<T>(~T{0}) : T{0};
  return static_cast<T>(static_cast<T>(folded >> 1) ^ sign);
}

template <typename T>
void split(const std::byte* pixels, std::size_t count, std::byte* planes) {
  for (std::size_t place = 0; place < 3; ++place) {
    const std::size_t channel = kChannels[place];
    T before = 0;
    for (std::size_t i = 0; i < count; ++i) {
      const T green = place == 0 ? T{0} : load<T>(pixels, 3 * i + 1);
      const T value = static_cast<T>(load<T>(pixels, 3 * i + channel) - green);
      const T folded = fold(static_cast<T>(value - before));
      before = value;
      for (std::size_t b = 0; b < sizeof(T); ++b) {
        planes[(3 * b + place) * count + i] = static_cast<std::byte>(folded >> (8 * b) & 0xff);
      }
    }
  }
}

template <typename T>
void join(const std::byte* planes, std::size_t count, std::byte* pixels) {
  for (std::size_t place = 0; place < 3; ++place) {
    const std::size_t channel = kChannels[place];
    T before = 0;
    for (std::size_t i = 0; i < count; ++i) {
      T folded = 0;
      for (std::size_t b = 0; b < sizeof(T); ++b) {
        folded =
            static_cast<T>(folded | static_cast<T>(planes[(3 * b + place) * count + i]) << (8 * b));
      }
      before = static_cast<T>(before + unfold(folded));
      const T green = place == 0 ? T{0} : load<T>(pixels, 3 * i + 1);
      const T value = static_cast<T>(before + green);
      std::memcpy(pixels + (3 * i + channel) * sizeof(T), &value, sizeof(T));
    }
  }
}

// Like split(), for a plane of the picture: `channels` floats a pixel, which do not refer to each
// other.
void split_plane(const std::byte* pixels, std::size_t count, std::size_t channels,
                 std::byte* planes) {
  for (std::size_t c = 0; c < channels; ++c) {
    std::uint32_t before = 0;
    for (std::size_t i = 0; i < count; ++i) {
      const auto value = load<std::uint32_t>(pixels, channels * i + c);
      const std::uint32_t folded = fold(value - before);
      before = value;
      for (std::size_t b = 0; b < sizeof(folded); ++b)
        planes[(channels * b + c) * count + i] = static_cast<std::byte>(folded >> (8 * b) & 0xff);
    }
  }
}

void join_plane(const std::byte* planes, std::size_t count, std::size_t channels,
                std::byte* pixels) {
  for (std::size_t c = 0; c < channels; ++c) {
    std::uint32_t value = 0;
    for (std::size_t i = 0; i < count; ++i) {
      std::uint32_t folded = 0;
      for (std::size_t b = 0; b < sizeof(folded); ++b)
        folded |= static_cast<std::uint32_t>(planes[(channels * b + c) * count + i]) << (8 * b);
      value += unfold(folded);
      std::memcpy(pixels + (channels * i + c) * sizeof(value), &value, sizeof(value));
    }
  }
}

}  // namespace

bool code_pixels(ByteCoding coding, const PixelLayout& layout, std::span<const std::byte> pixels,
                 std::vector<std::byte>& coded) {
  TESSERA_CHECK_EQ(pixels.size() % layout.pixel_bytes(), 0u);
  const std::size_t count = pixels.size() / layout.pixel_bytes();
  thread_local std::vector<std::byte> planes;
  planes.resize(pixels.size());
  switch (layout.format()) {
    case PixelFormat::kFloat:
      split<std::uint32_t>(pixels.data(), count, planes.data());
      break;
    case PixelFormat::kHalf:
      split<std::uint16_t>(pixels.data(), count, planes.data());
      break;
    case PixelFormat::kDisplay8:
      split<std::uint8_t>(pixels.data(), count, planes.data());
      break;
  }
  layout.for_each_plane([&](Plane, std::size_t before_bytes, std::size_t bytes) {
    const std::size_t at = count * before_bytes;
    split_plane(pixels.data() + at, count, bytes / sizeof(float), planes.data() + at);
  });
  return code_bytes(coding, planes, coded);
}

Status restore_pixels(ByteCoding coding, const PixelLayout& layout,
                      std::span<const std::byte> coded, std::span<std::byte> pixels) {
  if (coding == ByteCoding::kNone) return decode_bytes(coding, coded, pixels);
  TESSERA_CHECK_EQ(pixels.size() % layout.pixel_bytes(), 0u);
  const std::size_t count = pixels.size() / layout.pixel_bytes();
  thread_local std::vector<std::byte> planes;
  planes.resize(pixels.size());
  TESSERA_RETURN_IF_ERROR(decode_bytes(coding, coded, planes));
  switch (layout.format()) {
    case PixelFormat::kFloat:
      join<std::uint32_t>(planes.data(), count, pixels.data());
      break;
    case PixelFormat::kHalf:
      join<std::uint16_t>(planes.data(), count, pixels.data());
      break;
    case PixelFormat::kDisplay8:
      join<std::uint8_t>(planes.data(), count, pixels.data());
      break;
  }
  layout.for_each_plane([&](Plane, std::size_t before_bytes, std::size_t bytes) {
    const std::size_t at = count * before_bytes;
    join_plane(planes.data() + at, count, bytes / sizeof(float), pixels.data() + at);
  });
  return Status::ok();
}

Status make_plain(const PixelLayout& layout, std::size_t plain_bytes, TileResult& result) {
  if (result.coding == ByteCoding::kNone && result.pixels.size() == plain_bytes) {
    return Status::ok();
  }
  std::vector<std::byte> plain(plain_bytes);
  TESSERA_RETURN_IF_ERROR(restore_pixels(result.coding, layout, result.pixels, plain));
  result.pixels = std::move(plain);
  result.coding = ByteCoding::kNone;
  return Status::ok();
}

}  // namespace tessera::wire
