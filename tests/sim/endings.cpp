// SPDX-License-Identifier: Apache-2.0
#include "tests/sim/endings.h"

#include <algorithm>

#include "common/base/limits.h"
#include "tests/sim/storm_plan.h"

namespace tessera::sim {
namespace {

constexpr double kRounding = 0.001;  // seconds

std::set<std::string> names_in(const std::string& text) {
  std::set<std::string> names;
  for (std::size_t at = text.find('\''); at != std::string::npos;) {
    const std::size_t end = text.find('\'', at + 1);
    if (end == std::string::npos) break;
    names.insert(text.substr(at + 1, end - at - 1));
    at = text.find('\'', end + 1);
  }
  return names;
}

}  // namespace

// A new master knows nobody.
void Endings::on_master_started() {
  has_rendered_ = false;
  held_until_.clear();
  bad_.clear();
}

void Endings::on_counts(const ClusterStatus& status, double now) {
  for (const SlaveStatus& slave : status.slaves)
    has_rendered_ = has_rendered_ || (slave.tiles_done > 0 && !is_name_of_bad_slave(slave.name));
  for (const QuarantinedSlave& held : status.quarantined) {
    if (held.reason.starts_with("lost ")) continue;
    double& until = held_until_[held.name];
    until = std::max(until, now + held.seconds);
  }
}

void Endings::on_bad_end(const std::string& slave, bool has_brought) {
  const auto [entry, is_first] = bad_.try_emplace(slave);
  BadEnds& ends = entry->second;
  if (is_first) ends.was_proven = has_brought;
  ++(has_rendered_ ? ends.after : ends.before_any);
}

bool Endings::do_excuse(const std::string& reason) const {
  const std::set<std::string> names = names_in(reason);
  if (names.size() < std::size_t{kTileAttemptsMax}) return false;
  const auto was_as_good_as_any = [&](const std::string& name) {
    const auto ends = bad_.find(name);
    return met_.contains(name) || (ends != bad_.end() && ends->second.was_proven);
  };
  const auto ended_before_any = [&](const std::string& name) {
    const auto ends = bad_.find(name);
    return ends != bad_.end() && ends->second.before_any > 0 && ends->second.after == 0;
  };
  return std::any_of(names.begin(), names.end(), was_as_good_as_any) ||
         std::all_of(names.begin(), names.end(), ended_before_any);
}

bool Endings::is_back_too_soon(const std::string& slave, double now) const {
  const auto held = held_until_.find(slave);
  return held != held_until_.end() && now < held->second - kRounding;
}

}  // namespace tessera::sim
