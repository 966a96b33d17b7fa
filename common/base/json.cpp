// SPDX-License-Identifier: Apache-2.0
#include "common/base/json.h"

#include <charconv>
#include <cmath>
#include <limits>

#include "common/base/clean_text.h"

namespace tessera {

void append_json_string(std::string& out, std::string_view text) {
  static constexpr char kDigits[] = "0123456789abcdef";
  out.push_back('"');
  for (const char c : text) {
    const auto u = static_cast<unsigned char>(c);
    if (c == '"' || c == '\\') {
      out.push_back('\\');
      out.push_back(c);
    } else if (u < 0x20) {
      out += "\\u00";
      out.push_back(kDigits[u >> 4]);
      out.push_back(kDigits[u & 15]);
    } else {
      out.push_back(c);
    }
  }
  out.push_back('"');
}

JsonObject& JsonObject::add(std::string_view key, std::string_view value) {
  std::string quoted;
  append_json_string(quoted, clean_text(value, std::numeric_limits<std::size_t>::max(),
                                        /*is_block=*/true));
  return add_raw(key, quoted);
}

JsonObject& JsonObject::add(std::string_view key, double value) {
  if (!std::isfinite(value)) return add_raw(key, "null");
  char digits[32];
  const auto end = std::to_chars(digits, digits + sizeof(digits), value).ptr;
  return add_raw(key, std::string_view(digits, static_cast<std::size_t>(end - digits)));
}

JsonObject& JsonObject::add_raw(std::string_view key, std::string_view json) {
  if (body_.size() > 1) body_ += ',';
  append_json_string(body_, key);
  body_ += ':';
  body_ += json;
  return *this;
}

}  // namespace tessera
