// SPDX-License-Identifier: Apache-2.0
// Scans text in one memory buffer, line by line and word by word, without copies or locale. All
// readers share it.
// Threads. Plain values.
#pragma once

#include <charconv>
#include <cstdint>
#include <limits>
#include <optional>
#include <string>
#include <string_view>
#include <type_traits>

#include "common/base/status.h"

namespace tessera {

// Reads a whole regular file. Returns: one line naming file and reason; kResourceExhausted above
// `bytes_max`.
Result<std::string> read_whole_file(const std::string& path, std::uint64_t bytes_max);

class TextScanner {
 public:
  // A byte order mark at the beginning is passed over.
  explicit TextScanner(std::string_view text)
      : rest_(text.starts_with("\xef\xbb\xbf") ? text.substr(3) : text) {}

  // Goes to the next line; '\r' before '\n' is dropped. Returns: false at the end.
  bool next_line() {
    if (rest_.empty()) return false;
    line_ = physical_line();
    return true;
  }
  // Like next_line(), but a line that ends in a backslash goes on in the next one.
  bool next_logical_line() {
    if (!next_line()) return false;
    if (line_.empty() || line_.back() != '\\') return true;
    joined_.clear();
    while (!line_.empty() && line_.back() == '\\') {
      joined_.append(line_.substr(0, line_.size() - 1)).push_back(' ');
      line_ = rest_.empty() ? std::string_view() : physical_line();
    }
    joined_.append(line_);
    line_ = joined_;
    return true;
  }
  std::string_view line() const { return line_; }
  std::uint64_t line_number() const { return line_number_; }
  std::string_view rest() const { return rest_; }  // behind this line

  // The next word of the line; empty at its end.
  std::string_view word() {
    const auto begin = line_.find_first_not_of(" \t");
    if (begin == std::string_view::npos) {
      line_ = {};
      return {};
    }
    const auto end = line_.find_first_of(" \t", begin);
    const std::string_view found =
        line_.substr(begin, end == std::string_view::npos ? end : end - begin);
    line_ = end == std::string_view::npos ? std::string_view() : line_.substr(end);
    return found;
  }

  // What is left of the line, without spaces around it (file names may hold spaces).
  std::string_view trimmed_rest_of_line() {
    const auto begin = line_.find_first_not_of(" \t");
    if (begin == std::string_view::npos) return {};
    const auto end = line_.find_last_not_of(" \t");
    return line_.substr(begin, end - begin + 1);
  }

  template <typename T>
  std::optional<T> number() {
    return number_of<T>(word());
  }

  template <typename T>
  static std::optional<T> number_of(std::string_view text) {
    if (!text.empty() && text.front() == '+') text.remove_prefix(1);
    T value{};
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
    if (end != text.data() + text.size() || text.empty()) return std::nullopt;
    if (error == std::errc::result_out_of_range) return out_of_range<T>(text);
    if (error != std::errc()) return std::nullopt;
    return value;
  }

 private:
  std::string_view physical_line() {
    const auto end = rest_.find('\n');
    std::string_view line = rest_.substr(0, end);
    rest_ = end == std::string_view::npos ? std::string_view() : rest_.substr(end + 1);
    if (!line.empty() && line.back() == '\r') line.remove_suffix(1);
    ++line_number_;
    return line;
  }

  // A number too small for a float is zero; one too large is infinite, which the caller refuses.
  template <typename T>
  static std::optional<T> out_of_range(std::string_view text) {
    if constexpr (std::is_floating_point_v<T>) {
      double wide = 0;
      const auto parsed = std::from_chars(text.data(), text.data() + text.size(), wide);
      if (parsed.ec == std::errc()) return static_cast<T>(wide);
      return text.find("e-") != std::string_view::npos || text.find("E-") != std::string_view::npos
                 ? T{0}
                 : std::numeric_limits<T>::infinity();
    }
    return std::nullopt;
  }

  std::string_view rest_, line_;
  std::string joined_;  // a line that went on over several
  std::uint64_t line_number_ = 0;
};

}  // namespace tessera
