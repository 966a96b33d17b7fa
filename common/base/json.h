// SPDX-License-Identifier: Apache-2.0
// Writes JSON objects for --stats lines, traces and status output. Nothing here reads JSON. A value
// belongs to whoever makes it; there are no threads.
//
// Texts of files and peers may be added as they are: clean_text() makes each fit for a terminal,
// which is where `status --json` often goes, and for readers that refuse what is not UTF-8.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

namespace tessera {

// Appends `text` in quotes, escaped (RFC 8259, section 7).
void append_json_string(std::string& out, std::string_view text);

// One object, whose members stand in the order of the calls. Plain value, one thread at a time.
class JsonObject {
 public:
  JsonObject& add(std::string_view key, std::string_view value);
  JsonObject& add(std::string_view key, const char* value) {
    return add(key, std::string_view(value));
  }
  JsonObject& add(std::string_view key, bool value) {
    return add_raw(key, value ? "true" : "false");
  }
  JsonObject& add(std::string_view key, double value);  // NaN and infinity become null
  JsonObject& add(std::string_view key, std::uint64_t value) {
    return add_raw(key, std::to_string(value));
  }
  JsonObject& add(std::string_view key, std::uint32_t value) {
    return add(key, std::uint64_t{value});
  }
  JsonObject& add(std::string_view key, int value) { return add_raw(key, std::to_string(value)); }
  // `json` is a complete JSON value.
  JsonObject& add_raw(std::string_view key, std::string_view json);

  std::string text() const { return body_ + "}"; }

 private:
  std::string body_ = "{";
};

}  // namespace tessera
