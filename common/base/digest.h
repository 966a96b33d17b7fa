// SPDX-License-Identifier: Apache-2.0
// SHA-256, the name of every scene block and of every finished frame (FIPS 180-4; by OpenSSL, which
// is confined to digest.cpp here and to common/net).
#pragma once

#include <array>
#include <compare>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string>

#include "common/base/api.h"

namespace tessera {

struct TESSERA_API Digest {
  std::array<std::uint8_t, 32> bytes{};
  auto operator<=>(const Digest&) const = default;

  std::string hex() const;  // 64 lower-case digits
};

struct DigestHash {
  std::size_t operator()(const Digest& d) const;
};

TESSERA_API Digest sha256(std::span<const std::byte> bytes);

// SHA-256 of bytes that come in pieces. Used by one thread at a time.
class Sha256 {
 public:
  Sha256();
  ~Sha256();
  Sha256(Sha256&&) noexcept;
  Sha256& operator=(Sha256&&) noexcept;

  void update(std::span<const std::byte> bytes);
  Digest finish();  // Requires: called once, last.

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace tessera
