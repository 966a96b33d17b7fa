// SPDX-License-Identifier: Apache-2.0
// Warnings of one file, one line for each kind however often it is met: the first of a kind is said
// in full, those after it are counted behind that line.
//
// Invariants. Lines come in the order in which their kinds were met first; there are at most
// kWarningKindsMax of them, and one more that counts what was left out.
// Threads. Plain value.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <unordered_map>
#include <vector>

namespace tessera {

// A bound for files that are made to cause warnings; no format has nearly as many keys.
inline constexpr std::size_t kWarningKindsMax = 1000;

class WarningGroup {
 public:
  // `file` opens every line.
  explicit WarningGroup(std::string file) : file_(std::move(file)) {}

  // `kind` says which warnings are alike (a key of the format, as a rule) and is never shown;
  // `text` names object and key, says what is wrong and what is done instead.
  void add(std::string_view kind, std::string text);
  // Like add(), for a warning that needs no count.
  void add_once(std::string_view kind, std::string text);

  // "FILE: TEXT" or "FILE: TEXT (and N more like it)".
  std::vector<std::string> lines() const;

 private:
  struct Entry {
    std::string text;
    std::uint64_t more = 0;  // of the same kind, after the first
  };

  const std::string file_;
  std::vector<Entry> entries_;
  std::unordered_map<std::string, std::size_t> index_;  // kind -> entry
  std::uint64_t left_out_ = 0;
};

}  // namespace tessera
