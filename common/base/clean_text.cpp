// SPDX-License-Identifier: Apache-2.0
#include "common/base/clean_text.h"

#include <algorithm>
#include <cstdint>

namespace tessera {
namespace {

struct Character {
  std::uint32_t code = 0;
  std::size_t bytes = 0;  // 0: no character begins there
};

// The character that `text` begins with, in the shortest form, no surrogate, at most 0x10ffff.
Character first_of(std::string_view text) {
  const auto at = [&](std::size_t i) { return static_cast<unsigned char>(text[i]); };
  const std::uint32_t lead = at(0);
  if (lead < 0x80) return {lead, 1};
  const std::size_t bytes = lead >= 0xf0 && lead < 0xf8   ? 4
                            : lead >= 0xe0 && lead < 0xf0 ? 3
                            : lead >= 0xc0 && lead < 0xe0 ? 2
                                                          : 0;
  if (bytes == 0 || text.size() < bytes) return {};
  std::uint32_t code = lead & (0x7fu >> bytes);
  for (std::size_t i = 1; i < bytes; ++i) {
    if ((at(i) & 0xc0u) != 0x80u) return {};
    code = code << 6 | (at(i) & 0x3fu);
  }
  constexpr std::uint32_t kLeast[] = {0, 0, 0x80, 0x800, 0x10000};
  if (code < kLeast[bytes] || code > 0x10ffff || (code >= 0xd800 && code < 0xe000)) return {};
  return {code, bytes};
}

bool is_harmful(std::uint32_t code) {
  return code < 0x20 || (code >= 0x7f && code < 0xa0) ||  // controls
         code == 0x2028 || code == 0x2029 ||              // ends of lines and paragraphs
         code == 0x200e || code == 0x200f || code == 0x61c ||
         (code >= 0x202a && code <= 0x202e) ||  // directions of writing
         (code >= 0x2066 && code <= 0x2069);
}

}  // namespace

std::string clean_text(std::string_view text, std::size_t bytes_max, bool is_block) {
  constexpr std::string_view kCut = "...";
  std::string clean;
  clean.reserve(std::min(text.size(), bytes_max));
  std::size_t fits = 0;  // bytes in front of which the text can be cut to hold kCut, too
  while (!text.empty()) {
    const Character c = first_of(text);
    const bool is_break = is_block && c.code == '\n' && c.bytes == 1;
    const bool is_kept = c.bytes > 0 && (is_break || !is_harmful(c.code));
    const std::string_view piece = is_kept ? text.substr(0, c.bytes) : std::string_view("?");
    if (clean.size() + piece.size() > bytes_max) {
      clean.resize(fits);
      return clean.append(kCut.substr(0, bytes_max));
    }
    clean += piece;
    if (clean.size() + kCut.size() <= bytes_max) fits = clean.size();
    text.remove_prefix(std::max<std::size_t>(c.bytes, 1));
  }
  return clean;
}

}  // namespace tessera
