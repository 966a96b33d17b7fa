// SPDX-License-Identifier: Apache-2.0
#include "master/import/gltf/object.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <nlohmann/json.hpp>

namespace tessera::import {
namespace {

using nlohmann::json;

constexpr std::size_t kShownMax = 60;

std::string shown(double value) {
  char text[32];
  std::snprintf(text, sizeof(text), "%.9g", value);
  return text;
}

// A value as a person can read it in one line.
std::string shown(const json& value) {
  if (value.is_object()) return "an object";
  if (value.is_array()) return "an array";
  if (value.is_number_float()) return shown(value.get<double>());
  if (!value.is_string()) return value.dump();
  return "'" + printable(value.get_ref<const std::string&>()) + "'";
}

std::string shown(const GltfRange& range) {
  constexpr double kMost = std::numeric_limits<float>::max();
  if (range.low <= -kMost && range.high >= kMost) return "a finite number";
  if (range.high >= kMost)
    return range.is_low_open ? "more than " + shown(range.low) : shown(range.low) + " or more";
  return (range.is_low_open ? "more than " : "from ") + shown(range.low) +
         (range.is_low_open ? " and at most " : " to ") + shown(range.high);
}

std::optional<std::uint64_t> whole(const json& value) {
  if (value.is_number_unsigned()) return value.get<std::uint64_t>();
  if (!value.is_number()) return std::nullopt;
  // Some exporters write 3.0. Above 2^53 a double is no certain whole number.
  const double number = value.get<double>();
  if (!(number >= 0 && number <= 9007199254740992.0) || number != std::floor(number))
    return std::nullopt;
  return static_cast<std::uint64_t>(number);
}

}  // namespace

std::string printable(const std::string& text) {
  std::string plain;
  for (const char c : text.substr(0, kShownMax))
    plain += static_cast<unsigned char>(c) < 0x20 || c == 0x7f ? '?' : c;
  return plain + (text.size() > kShownMax ? "..." : "");
}

GltfObject::GltfObject(const json* value, std::string name, WarningGroup* warnings)
    : json_(value), name_(std::move(name)), warnings_(warnings) {
  if (json_ == nullptr || json_->is_object()) return;
  warnings_->add("no object", name_ + " is " + shown(*json_) + "; it must be an object");
  json_ = nullptr;
}

const json* GltfObject::find(std::string_view key) const {
  if (json_ == nullptr) return nullptr;
  const auto member = json_->find(std::string(key));
  return member == json_->end() ? nullptr : &*member;
}

bool GltfObject::has(std::string_view key) const { return find(key) != nullptr; }

GltfObject GltfObject::named(std::string what) const {
  GltfObject same = *this;
  same.name_ = std::move(what);
  same.prefix_.clear();
  const json* name = find("name");
  if (name != nullptr && name->is_string())
    same.name_ += " '" + printable(name->get<std::string>()) + "'";
  return same;
}

void GltfObject::warn(std::string_view key, const std::string& text) const {
  const std::string full = prefix_ + std::string(key);
  warnings_->add(full, name_ + ": " + full + " " + text);
}

Status GltfObject::refuse(std::string_view key, const std::string& text) const {
  return Status::invalid_argument(name_ + ": " + prefix_ + std::string(key) + " " + text);
}

GltfObject GltfObject::object(std::string_view key) const {
  GltfObject part;
  const json* value = find(key);
  if (value == nullptr) return part;
  part.name_ = name_;
  part.prefix_ = prefix_ + std::string(key) + ".";
  part.warnings_ = warnings_;
  if (value->is_object()) {
    part.json_ = value;
  } else {
    warn(key, "is " + shown(*value) + "; it must be an object, and is passed over");
  }
  return part;
}

GltfObject GltfObject::extension(std::string_view name) const {
  const json* all = find("extensions");
  if (all == nullptr || !all->is_object() || !all->contains(std::string(name))) return {};
  GltfObject parts = object("extensions");
  parts.prefix_ = prefix_;
  return parts.object(name);
}

std::vector<GltfObject> GltfObject::objects(std::string_view key) const {
  std::vector<GltfObject> parts;
  const json* array = find(key);
  if (array == nullptr) return parts;
  if (!array->is_array()) {
    warn(key, "is " + shown(*array) + "; it must be an array, and is passed over");
    return parts;
  }
  for (std::size_t i = 0; i < array->size(); ++i) {
    GltfObject& part = parts.emplace_back();
    part.name_ = name_;
    part.prefix_ = prefix_ + std::string(key) + "[" + std::to_string(i) + "].";
    part.warnings_ = warnings_;
    if ((*array)[i].is_object()) {
      part.json_ = &(*array)[i];
    } else {
      warn(key, "holds " + shown((*array)[i]) + "; it must hold objects");
    }
  }
  return parts;
}

double GltfObject::checked(const json& value, const std::string& key, double fallback,
                           const GltfRange& range) const {
  const std::string must = "; it must be " + shown(range) + "; ";
  if (!value.is_number()) {
    warn(key, "is " + shown(value) + must + shown(fallback) + " is used");
    return fallback;
  }
  const double number = value.get<double>();
  const bool is_low = !(number >= range.low) || (range.is_low_open && number == range.low);
  if (!is_low && number <= range.high) return number;
  const double used = !is_low ? range.high : range.is_low_open ? fallback : range.low;
  // An unbounded range ends at the greatest float, which is no useful value.
  const double kept = std::fabs(used) >= std::numeric_limits<float>::max() ? fallback : used;
  warn(key, "is " + shown(number) + must + shown(kept) + " is used");
  return kept;
}

double GltfObject::number(std::string_view key, double fallback, const GltfRange& range) const {
  const json* value = find(key);
  return value == nullptr ? fallback : checked(*value, std::string(key), fallback, range);
}

float GltfObject::real(std::string_view key, float fallback, const GltfRange& range) const {
  return static_cast<float>(number(key, static_cast<double>(fallback), range));
}

void GltfObject::read_reals(std::string_view key, float* values, std::size_t count,
                            const GltfRange& range) const {
  const json* array = find(key);
  if (array == nullptr) return;
  if (!array->is_array() || array->size() != count) {
    warn(key, "is no array of " + std::to_string(count) + " numbers; its default is used");
    return;
  }
  for (std::size_t i = 0; i < count; ++i) {
    values[i] = static_cast<float>(
        checked((*array)[i], std::string(key), static_cast<double>(values[i]), range));
  }
}

bool GltfObject::flag(std::string_view key, bool fallback) const {
  const json* value = find(key);
  if (value == nullptr) return fallback;
  if (value->is_boolean()) return value->get<bool>();
  warn(key, "is " + shown(*value) + "; it must be true or false; " + (fallback ? "true" : "false") +
                " is used");
  return fallback;
}

std::string GltfObject::text(std::string_view key) const {
  const json* value = find(key);
  if (value == nullptr) return {};
  if (value->is_string()) return value->get<std::string>();
  warn(key, "is " + shown(*value) + "; it must be a text, and is passed over");
  return {};
}

std::vector<std::string> GltfObject::texts(std::string_view key) const {
  std::vector<std::string> all;
  const json* array = find(key);
  if (array == nullptr) return all;
  if (!array->is_array()) {
    warn(key, "is " + shown(*array) + "; it must be an array, and is passed over");
    return all;
  }
  for (const json& value : *array) {
    if (value.is_string()) {
      all.push_back(value.get<std::string>());
    } else {
      warn(key, "holds " + shown(value) + "; it must hold texts");
    }
  }
  return all;
}

std::vector<std::string> GltfObject::keys() const {
  std::vector<std::string> names;
  if (json_ == nullptr) return names;
  for (const auto& [name, value] : json_->items()) names.push_back(name);
  return names;
}

std::string GltfObject::why_no_index(const json& value, std::uint64_t count) const {
  const auto number = whole(value);
  if (number && *number < count) return {};
  if (number && count == 0) return "is " + shown(value) + ", but there are none";
  return "is " + shown(value) +
         (count == 0 ? "; it must be an index"
                     : "; it must be from 0 to " + std::to_string(count - 1));
}

std::optional<std::uint32_t> GltfObject::index(std::string_view key, std::uint64_t count,
                                               std::string_view instead) const {
  const json* value = find(key);
  if (value == nullptr) return std::nullopt;
  const std::string why = why_no_index(*value, count);
  if (why.empty()) return static_cast<std::uint32_t>(*whole(*value));
  warn(key, why + "; " + std::string(instead));
  return std::nullopt;
}

Result<std::optional<std::uint32_t>> GltfObject::refused_index(std::string_view key,
                                                               std::uint64_t count) const {
  const json* value = find(key);
  if (value == nullptr) return std::optional<std::uint32_t>();
  if (const std::string why = why_no_index(*value, count); !why.empty()) return refuse(key, why);
  return std::optional(static_cast<std::uint32_t>(*whole(*value)));
}

Result<std::vector<std::uint32_t>> GltfObject::refused_indices(std::string_view key,
                                                               std::uint64_t count) const {
  std::vector<std::uint32_t> all;
  const json* array = find(key);
  if (array == nullptr) return all;
  if (!array->is_array()) return refuse(key, "is " + shown(*array) + "; it must be an array");
  for (const json& value : *array) {
    if (const std::string why = why_no_index(value, count); !why.empty()) {
      return refuse(key, "holds one that " + why);
    }
    all.push_back(static_cast<std::uint32_t>(*whole(value)));
  }
  return all;
}

Result<std::uint64_t> GltfObject::refused_whole(std::string_view key, std::uint64_t fallback,
                                                std::uint64_t low, std::uint64_t high) const {
  const json* value = find(key);
  if (value == nullptr && (fallback < low || fallback > high)) return refuse(key, "is missing");
  if (value == nullptr) return fallback;
  const auto number = whole(*value);
  if (number && *number >= low && *number <= high) return *number;
  return refuse(key, "is " + shown(*value) + "; it must be a whole number from " +
                         std::to_string(low) + " to " + std::to_string(high));
}

void GltfObject::check_keys(std::initializer_list<std::string_view> known,
                            std::initializer_list<std::string_view> extensions) const {
  if (json_ == nullptr) return;
  const auto is_in = [](const std::string& name, std::initializer_list<std::string_view> list) {
    return std::find(list.begin(), list.end(), name) != list.end();
  };
  for (const auto& [key, value] : json_->items()) {
    if (key == "extras" || key == "extensions" || key == "name" || is_in(key, known)) continue;
    warn(printable(key), "is no key that is known here, and is passed over");
  }
  const json* all = find("extensions");
  if (all == nullptr) return;
  if (!all->is_object())
    return warn("extensions", "is " + shown(*all) + "; it must be an object, and is passed over");
  for (const auto& [key, value] : all->items()) {
    if (is_in(key, extensions)) continue;
    warnings_->add_once("extension " + key, name_ + ": the extension " + printable(key) +
                                                " is not known here, and is passed over");
  }
}

}  // namespace tessera::import
