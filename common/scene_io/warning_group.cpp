// SPDX-License-Identifier: Apache-2.0
#include "common/scene_io/warning_group.h"

namespace tessera {

void WarningGroup::add(std::string_view kind, std::string text) {
  const auto known = index_.find(std::string(kind));
  if (known != index_.end()) {
    ++entries_[known->second].more;
  } else if (entries_.size() >= kWarningKindsMax) {
    ++left_out_;
  } else {
    index_.emplace(kind, entries_.size());
    entries_.push_back({std::move(text)});
  }
}

void WarningGroup::add_once(std::string_view kind, std::string text) {
  if (!index_.contains(std::string(kind))) add(kind, std::move(text));
}

std::vector<std::string> WarningGroup::lines() const {
  std::vector<std::string> lines;
  for (const Entry& entry : entries_) {
    std::string& line = lines.emplace_back(file_ + ": " + entry.text);
    if (entry.more > 0) line += " (and " + std::to_string(entry.more) + " more like it)";
  }
  if (left_out_ > 0)
    lines.push_back(file_ + ": and " + std::to_string(left_out_) + " warnings of other kinds");
  return lines;
}

}  // namespace tessera
