// SPDX-License-Identifier: Apache-2.0
// Reads the bytes of a fuzz input as small numbers and pieces. Behind the end everything is zero,
// so that every input means something, and a cut one means nearly the same.
//
// Threads. Plain value.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

namespace tessera::test {

class FuzzInput {
 public:
  FuzzInput(const std::uint8_t* data, std::size_t size) : rest_(data, size) {}

  bool is_at_end() const { return rest_.empty(); }
  std::uint8_t byte() {
    if (rest_.empty()) return 0;
    const std::uint8_t value = rest_.front();
    rest_ = rest_.subspan(1);
    return value;
  }
  // A number of two bytes, the lower one first.
  std::uint16_t two_bytes() {
    const std::uint8_t low = byte();
    return static_cast<std::uint16_t>(low | byte() << 8);
  }
  // A number of 0 to count - 1, by one byte. Requires: 1 <= count <= 256.
  std::uint8_t below(std::uint32_t count) { return static_cast<std::uint8_t>(byte() % count); }
  bool yes() { return (byte() & 1) != 0; }

  // The next bytes, as many as there are.
  std::span<const std::uint8_t> take(std::size_t count) {
    const auto piece = rest_.first(std::min(count, rest_.size()));
    rest_ = rest_.subspan(piece.size());
    return piece;
  }
  std::vector<std::byte> bytes(std::size_t count) {
    const auto piece = std::as_bytes(take(count));
    return {piece.begin(), piece.end()};
  }
  std::string text(std::size_t count) {
    const auto piece = take(count);
    return {piece.begin(), piece.end()};
  }
  std::span<const std::uint8_t> rest() { return take(rest_.size()); }

 private:
  std::span<const std::uint8_t> rest_;
};

}  // namespace tessera::test
