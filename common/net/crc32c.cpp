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

__attribute__((target("sse4.2"))) std::uint32_t by_instruction(std::uint32_t c, const std::byte* p,
                                                               std::size_t n) {
  std::uint64_t wide = c;
  for (; n >= 8; p += 8, n -= 8) {
    std::uint64_t word = 0;
    std::memcpy(&word, p, 8);
    wide = __builtin_ia32_crc32di(wide, word);
  }
  return by_table(static_cast<std::uint32_t>(wide), p, n);
}

}  // namespace

std::uint32_t crc32c(std::uint32_t crc, std::span<const std::byte> bytes) {
  static const bool has_instruction = __builtin_cpu_supports("sse4.2") != 0;
  const std::uint32_t c = ~crc;
  return ~(has_instruction ? by_instruction(c, bytes.data(), bytes.size())
                           : by_table(c, bytes.data(), bytes.size()));
}

}  // namespace tessera::net
