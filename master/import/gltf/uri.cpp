// SPDX-License-Identifier: Apache-2.0
#include "master/import/gltf/uri.h"

#include <array>
#include <cstdint>

#include "common/scene_io/confined_path.h"
#include "common/scene_io/text_scanner.h"

namespace tessera::import {
namespace {

constexpr std::size_t kNameShownMax = 100;

int hex_digit(char c) {
  if (c >= '0' && c <= '9') return c - '0';
  const char lower = static_cast<char>(c | 0x20);
  return lower >= 'a' && lower <= 'f' ? lower - 'a' + 10 : -1;
}

int base64_digit(char c) {
  if (c >= 'A' && c <= 'Z') return c - 'A';
  if (c >= 'a' && c <= 'z') return c - 'a' + 26;
  if (c >= '0' && c <= '9') return c - '0' + 52;
  if (c == '+' || c == '-') return 62;
  return c == '/' || c == '_' ? 63 : -1;
}

Result<std::string> read_data_uri(std::string_view uri) {
  const auto comma = uri.find(',');
  if (comma == std::string_view::npos)
    return Status::invalid_argument("is a data URI without a comma");
  const bool is_base64 = uri.substr(0, comma).ends_with(";base64");
  return is_base64 ? base64_decoded(uri.substr(comma + 1)) : percent_decoded(uri.substr(comma + 1));
}

}  // namespace

Result<std::string> percent_decoded(std::string_view text) {
  std::string plain;
  plain.reserve(text.size());
  for (std::size_t i = 0; i < text.size(); ++i) {
    if (text[i] != '%') {
      plain += text[i];
      continue;
    }
    const int high = i + 2 < text.size() ? hex_digit(text[i + 1]) : -1;
    const int low = i + 2 < text.size() ? hex_digit(text[i + 2]) : -1;
    if (high < 0 || low < 0)
      return Status::invalid_argument("has a '%' without two hexadecimal digits");
    plain += static_cast<char>(16 * high + low);
    i += 2;
  }
  return plain;
}

Result<std::string> base64_decoded(std::string_view text) {
  std::string plain;
  plain.reserve(text.size() / 4 * 3 + 3);
  std::uint32_t bits = 0;
  int bit_count = 0;
  for (const char c : text) {
    if (c == '=' || c == ' ' || c == '\n' || c == '\r' || c == '\t') continue;
    const int digit = base64_digit(c);
    if (digit < 0) return Status::invalid_argument("is a data URI that is no base64");
    bits = (bits << 6 | static_cast<std::uint32_t>(digit)) & 0xffffffu;
    bit_count += 6;
    if (bit_count < 8) continue;
    bit_count -= 8;
    plain += static_cast<char>(bits >> bit_count & 0xffu);
  }
  return plain;
}

Result<std::string> read_uri(const std::string& folder, const std::string& uri,
                             std::uint64_t bytes_max) {
  if (uri.starts_with("data:")) return read_data_uri(uri);
  auto name = percent_decoded(uri);
  if (!name.is_ok()) return name.status();
  if (name->find('\0') != std::string::npos)
    return Status::invalid_argument("is a name with a zero byte");
  // Some exporters write names as they are, and a '%' may be part of one.
  auto file = confined_path(folder, *name);
  if (!file.is_ok() && *name != uri) {
    if (auto as_written = confined_path(folder, uri); as_written.is_ok())
      file = std::move(as_written);
  }
  if (!file.is_ok()) {
    return Status(file.status().code(),
                  "'" + name->substr(0, kNameShownMax) + "' " + file.status().message());
  }
  return read_whole_file(*file, bytes_max);
}

}  // namespace tessera::import
