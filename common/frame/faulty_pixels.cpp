// SPDX-License-Identifier: Apache-2.0
#include "common/frame/faulty_pixels.h"

#include <array>
#include <cstring>
#include <limits>

#include "common/frame/frame_image.h"

namespace tessera {
namespace {

constexpr std::size_t kComponents = 3;

// Whether the exponent bits are all ones (NaN, infinity), or the number is negative and not -0.
template <typename Bits>
bool is_faulty(Bits bits, Bits sign, Bits exponent) {
  return (bits & exponent) == exponent || ((bits & sign) != 0 && bits != sign);
}

// Quick test, a vector of components at a time, of whether a component may be faulty: adding one to
// the lowest bit of an exponent of ones, and of no other, carries into the sign's place. As a rule
// a tile has no such component and no sign.
template <typename Bits>
bool may_be_faulty(std::span<const std::byte> bytes, Bits exponent) {
  constexpr std::size_t kLanes = 16 / sizeof(Bits);
  using Vector [[gnu::vector_size(16)]] = Bits;
  const Bits lowest = static_cast<Bits>(exponent & -exponent);
  constexpr Bits kSign = static_cast<Bits>(~(std::numeric_limits<Bits>::max() >> 1));
  constexpr std::size_t kStep = 2 * sizeof(Vector);
  Vector found = {}, found_odd = {};  // two chains of operations, side by side
  std::size_t i = 0;
  for (; i + kStep <= bytes.size(); i += kStep) {
    Vector word, word_odd;
    std::memcpy(&word, bytes.data() + i, sizeof(word));
    std::memcpy(&word_odd, bytes.data() + i + sizeof(word), sizeof(word_odd));
    found |= ((word & exponent) + lowest) | word;
    found_odd |= ((word_odd & exponent) + lowest) | word_odd;
  }
  if (i < bytes.size()) return true;  // sizes that leave a remainder are rare
  const Vector any = found | found_odd;
  Bits sum = 0;
  for (std::size_t lane = 0; lane < kLanes; ++lane) sum = static_cast<Bits>(sum | any[lane]);
  return (sum & kSign) != 0;
}

template <typename Bits, typename OnFaulty>
std::uint64_t find_faulty(std::size_t pixel_count, const std::byte* bytes, Bits sign, Bits exponent,
                          const OnFaulty& on_faulty) {
  if (!may_be_faulty(std::span(bytes, pixel_count * kComponents * sizeof(Bits)), exponent))
    return 0;
  std::uint64_t count = 0;
  for (std::size_t pixel = 0; pixel < pixel_count; ++pixel) {
    std::array<Bits, kComponents> bits;
    std::memcpy(bits.data(), bytes + pixel * sizeof(bits), sizeof(bits));
    bool has_fault = false;
    for (const Bits one : bits) has_fault = has_fault || is_faulty(one, sign, exponent);
    if (!has_fault) continue;
    ++count;
    on_faulty(pixel);
  }
  return count;
}

template <typename OnFaulty>
std::uint64_t find_faulty(std::span<const std::byte> bytes, PixelFormat format,
                          const OnFaulty& on_faulty) {
  const std::size_t pixel_count = bytes.size() / static_cast<std::size_t>(bytes_per_pixel(format));
  switch (format) {
    case PixelFormat::kFloat:
      return find_faulty<std::uint32_t>(pixel_count, bytes.data(), 0x80000000u, 0x7f800000u,
                                        on_faulty);
    case PixelFormat::kHalf:
      return find_faulty<std::uint16_t>(pixel_count, bytes.data(), 0x8000u, 0x7c00u, on_faulty);
    case PixelFormat::kDisplay8:
      break;
  }
  return 0;
}

}  // namespace

std::uint64_t count_faulty_pixels(std::span<const std::byte> bytes, PixelFormat format) {
  return find_faulty(bytes, format, [](std::size_t) {});
}

std::uint64_t paint_faulty_pixels(std::span<std::byte> bytes, PixelFormat format) {
  const auto pixel_bytes = static_cast<std::size_t>(bytes_per_pixel(format));
  std::array<std::byte, kComponents * sizeof(float)> colour{};
  encode_pixels(kErrorColour, format, std::span(colour).first(pixel_bytes));
  return find_faulty(bytes, format, [&](std::size_t pixel) {
    std::memcpy(bytes.data() + pixel * pixel_bytes, colour.data(), pixel_bytes);
  });
}

}  // namespace tessera
