// SPDX-License-Identifier: Apache-2.0
// One JSON object of a glTF file with the name that messages give it: "material 3 'Leaf'".
//
// Values are checked here when they are asked for: one of the wrong type or out of range becomes
// one warning that names file, object and key, and the value that is used instead. Such repairs are
// for values that only looks depend on. Geometry depends on those that the refused_...() functions
// ask for, and a wrong one refuses the file.
//
// Threads. One. An object points into the document, which outlives it. An absent object answers
// every question with its fallback, so that optional parts need no branches.
#pragma once

#include <nlohmann/json_fwd.hpp>

#include <array>
#include <cstdint>
#include <initializer_list>
#include <limits>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "common/base/status.h"
#include "common/scene_io/warning_group.h"

namespace tessera::import {

// The range that a number may have. For a number outside of it the nearest end is used, or the
// fallback where that end is open or unbounded.
struct GltfRange {
  double low = -std::numeric_limits<float>::max();
  double high = std::numeric_limits<float>::max();
  bool is_low_open = false;
};
inline constexpr GltfRange kShare{0, 1};
inline constexpr GltfRange kFromZero{0};
inline constexpr GltfRange kPositive{0, std::numeric_limits<float>::max(), true};
inline constexpr GltfRange kAnyNumber{};

// Text of a file, short and without control characters, for a line of a message.
std::string printable(const std::string& text);

class GltfObject {
 public:
  GltfObject() = default;  // an absent object
  // json: null, or any value; one that is no JSON object makes an absent object, with a warning.
  // Requires: json and warnings outlive the object.
  GltfObject(const nlohmann::json* json, std::string name, WarningGroup* warnings);

  bool is_there() const { return json_ != nullptr; }
  const std::string& name() const { return name_; }  // "material 3 'Leaf'"
  bool has(std::string_view key) const;
  // This object, called `what` with its own name behind that: "light 2 'Key'".
  GltfObject named(std::string what) const;

  // Parts of this object. Their messages begin with its name.
  GltfObject object(std::string_view key) const;
  GltfObject extension(std::string_view name) const;
  std::vector<GltfObject> objects(std::string_view key) const;  // elements of an array

  double number(std::string_view key, double fallback, const GltfRange& range) const;
  float real(std::string_view key, float fallback, const GltfRange& range) const;
  bool flag(std::string_view key, bool fallback) const;
  std::string text(std::string_view key) const;  // empty when it is not there
  std::vector<std::string> texts(std::string_view key) const;
  template <std::size_t N>
  std::array<float, N> reals(std::string_view key, const std::array<float, N>& fallback,
                             const GltfRange& range) const {
    std::array<float, N> values = fallback;
    read_reals(key, values.data(), N, range);
    return values;
  }
  // Sets `count` numbers; they stay as they are where the key is absent or of another length.
  void read_reals(std::string_view key, float* values, std::size_t count,
                  const GltfRange& range) const;
  // Names of the members, in alphabetical order.
  std::vector<std::string> keys() const;

  // An index below `count`. Returns: nothing when the key is absent; nothing, with a warning that
  // ends in `instead`, when its value is no such index.
  std::optional<std::uint32_t> index(std::string_view key, std::uint64_t count,
                                     std::string_view instead) const;
  // An index below `count`, and an array of such; a value that is none is an error.
  Result<std::optional<std::uint32_t>> refused_index(std::string_view key,
                                                     std::uint64_t count) const;
  Result<std::vector<std::uint32_t>> refused_indices(std::string_view key,
                                                     std::uint64_t count) const;
  // A whole number from `low` to `high`. Any other value is an error, and so is an absent key where
  // `fallback` is outside of that range.
  Result<std::uint64_t> refused_whole(std::string_view key, std::uint64_t fallback,
                                      std::uint64_t low, std::uint64_t high) const;

  // Warns of members that are not among `known`, and of extensions that are not among
  // `extensions`: nothing in a file goes unread in silence.
  void check_keys(std::initializer_list<std::string_view> known,
                  std::initializer_list<std::string_view> extensions) const;

  // A message about a key of this object, "key is 7; it must be ...", as a warning or as an error.
  void warn(std::string_view key, const std::string& text) const;
  Status refuse(std::string_view key, const std::string& text) const;

 private:
  const nlohmann::json* find(std::string_view key) const;
  double checked(const nlohmann::json& value, const std::string& key, double fallback,
                 const GltfRange& range) const;
  std::string why_no_index(const nlohmann::json& value, std::uint64_t count) const;

  const nlohmann::json* json_ = nullptr;
  std::string name_;
  std::string prefix_;  // of keys: "pbrMetallicRoughness."
  WarningGroup* warnings_ = nullptr;
};

}  // namespace tessera::import
