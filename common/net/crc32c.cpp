// SPDX-License-Identifier: Apache-2.0
#include "common/net/crc32c.h"

#include <array>
#include <cstring>

namespace tessera::net {
namespace {

constexpr std::uint32_t kPolynomial = 0x82f63b78u;  // reflected

constexpr std::array<std::uint32_t, 256> make_table() {
  std::array<std::uint32_t, 256> table{};
  for (std::uint32_t i = 0; i < 256; ++i) {
    std::uint32_t c = i;
    for (int bit = 0; bit < 8; ++bit) c = (c & 1u) != 0 ? c >> 1 ^ kPolynomial : c >> 1;
    table[i] = c;
  }
  return table;
}
constexpr auto kTable = make_table();

std::uint32_t by_table(std::uint32_t c, const std::byte* p, std::size_t n) {
  for (; n > 0; ++p, --n) c = kTable[(c ^ static_cast<std::uint32_t>(*p)) & 0xffu] ^ c >> 8;
  return c;
}

// Shift gives the register after kStreamBytes more bytes of zero. That is linear in the register
// before, so four tables of a byte each give it. With it three streams of instructions go side by
// side, each of which waits only for its own last result.
constexpr std::size_t kStreamBytes = 512;
struct Shift {
  std::uint32_t table[4][256];

  Shift() {
    for (std::uint32_t byte = 0; byte < 4; ++byte) {
      for (std::uint32_t value = 0; value < 256; ++value) {
        std::uint32_t c = value << 8 * byte;
        for (std::size_t i = 0; i < kStreamBytes; ++i) c = kTable[c & 0xffu] ^ c >> 8;
        table[byte][value] = c;
      }
    }
  }
  std::uint32_t operator()(std::uint32_t c) const {
    return table[0][c & 0xffu] ^ table[1][c >> 8 & 0xffu] ^ table[2][c >> 16 & 0xffu] ^
           table[3][c >> 24];
  }
};

std::uint64_t word_at(const std::byte* p) {
  std::uint64_t word = 0;
  std::memcpy(&word, p, sizeof(word));
  return word;
}

__attribute__((target("sse4.2"))) std::uint32_t by_instruction(std::uint32_t c, const std::byte* p,
                                                               std::size_t n) {
  static const Shift shift;
  std::uint64_t first = c;
  for (; n >= 3 * kStreamBytes; p += 3 * kStreamBytes, n -= 3 * kStreamBytes) {
    std::uint64_t second = 0, third = 0;
    for (std::size_t i = 0; i < kStreamBytes; i += 8) {
      first = __builtin_ia32_crc32di(first, word_at(p + i));
      second = __builtin_ia32_crc32di(second, word_at(p + kStreamBytes + i));
      third = __builtin_ia32_crc32di(third, word_at(p + 2 * kStreamBytes + i));
    }
    const std::uint32_t two = shift(static_cast<std::uint32_t>(first));
    first = shift(two ^ static_cast<std::uint32_t>(second)) ^ third;
  }
  for (; n >= 8; p += 8, n -= 8) first = __builtin_ia32_crc32di(first, word_at(p));
  return by_table(static_cast<std::uint32_t>(first), p, n);
}

}  // namespace

std::uint32_t crc32c(std::uint32_t crc, std::span<const std::byte> bytes) {
  static const bool has_instruction = __builtin_cpu_supports("sse4.2") != 0;
  const std::uint32_t c = ~crc;
  return ~(has_instruction ? by_instruction(c, bytes.data(), bytes.size())
                           : by_table(c, bytes.data(), bytes.size()));
}

}  // namespace tessera::net
