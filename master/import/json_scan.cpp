#include "master/import/json_scan.h"

#include <algorithm>
#include <charconv>

namespace tessera::import {
namespace {

constexpr std::string_view kSpace = " \t\r\n";

// What `text` begins with is cut off and returned: a string, an object or an array to its end,
// anything else to the next delimiter. Empty at the end.
std::string_view take_value(std::string_view& text) {
  text.remove_prefix(std::min(text.find_first_not_of(kSpace), text.size()));
  std::size_t depth = 0, end = 0;
  bool is_string = false;
  for (; end < text.size(); ++end) {
    const char c = text[end];
    if (is_string) {
      if (c == '\\') ++end;
      if (c == '"') is_string = false;
    } else if (c == '"') {
      is_string = true;
    } else if (c == '{' || c == '[') {
      ++depth;
      continue;
    } else if (c == '}' || c == ']') {
      if (depth == 0) break;
      --depth;
    } else if (depth == 0 && (c == ',' || c == ':' || kSpace.find(c) != kSpace.npos)) {
      break;
    } else {
      continue;
    }
    if (depth == 0 && !is_string) {
      ++end;
      break;
    }
  }
  end = std::min(end, text.size());
  const std::string_view value = text.substr(0, end);
  text.remove_prefix(end);
  return value;
}

// Returns: whether `mark` came next, which is then cut off.
bool take(std::string_view& text, char mark) {
  text.remove_prefix(std::min(text.find_first_not_of(kSpace), text.size()));
  if (text.empty() || text.front() != mark) return false;
  text.remove_prefix(1);
  return true;
}

}  // namespace

std::string_view json_member(std::string_view object, std::string_view key) {
  if (!take(object, '{')) return {};
  do {
    const std::string_view name = take_value(object);
    if (!take(object, ':')) return {};
    const std::string_view value = take_value(object);
    if (name.size() == key.size() + 2 && name.substr(1, key.size()) == key) return value;
  } while (take(object, ','));
  return {};
}

std::vector<std::string_view> json_elements(std::string_view array) {
  std::vector<std::string_view> elements;
  if (!take(array, '[')) return elements;
  do {
    const std::string_view value = take_value(array);
    if (value.empty()) break;
    elements.push_back(value);
  } while (take(array, ','));
  return elements;
}

std::optional<float> json_number(std::string_view value) {
  float number = 0;
  const auto [end, error] = std::from_chars(value.data(), value.data() + value.size(), number);
  if (error != std::errc() || end != value.data() + value.size()) return std::nullopt;
  return number;
}

}  // namespace tessera::import
