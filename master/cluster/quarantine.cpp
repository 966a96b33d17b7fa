// SPDX-License-Identifier: Apache-2.0
#include "master/cluster/quarantine.h"

#include <algorithm>
#include <utility>

namespace tessera::master {

Quarantine::Record& Quarantine::record_of(const std::string& name, TimePoint now) {
  const auto known = records_.find(name);
  if (known != records_.end()) {
    if (now - known->second.last_offence > kForgiven) known->second = {};
    return known->second;
  }
  if (records_.size() >= kNamesMax) {
    records_.erase(
        std::min_element(records_.begin(), records_.end(), [](const auto& a, const auto& b) {
          return a.second.last_offence < b.second.last_offence;
        }));
  }
  return records_[name];
}

void Quarantine::hold(Record& record, const std::string& reason, TimePoint now) {
  Duration length = kFirst;
  for (std::uint32_t i = 0; i < record.times && length < kLongest; ++i) length *= 2;
  record.until = now + std::min<Duration>(length, kLongest);
  ++record.times;
  record.reason = reason;
  record.held_for.clear();
  record.losses.clear();
  record.wrong.clear();
}

bool Quarantine::count_loss(const std::string& name, std::uint64_t instance,
                            std::uint64_t tiles_brought, std::uint32_t tiles_held, TimePoint now) {
  if (tiles_brought >= tiles_held) return false;
  Record& record = record_of(name, now);
  record.last_offence = now;
  record.losses.push_back({now, instance});
  std::erase_if(record.losses, [now](const Loss& loss) { return now - loss.at > kWindow; });
  if (record.losses.size() < kLossesMax) return false;
  std::vector<Loss> losses = std::move(record.losses);
  hold(record,
       "lost " + std::to_string(kLossesMax) +
           " times within a minute, each time with more "
           "tiles than it had brought",
       now);
  record.held_for = std::move(losses);
  return true;
}

void Quarantine::forget_losses(const std::string& name, std::uint64_t instance, TimePoint now) {
  const auto found = records_.find(name);
  if (found == records_.end() || instance == 0) return;
  Record& record = found->second;
  const auto is_of_link = [&](const Loss& loss) { return loss.instance == instance; };
  std::erase_if(record.losses, is_of_link);
  if (std::erase_if(record.held_for, is_of_link) == 0 || record.until <= now) return;
  record.until = now;
  --record.times;
  record.losses = std::exchange(record.held_for, {});
}

bool Quarantine::count_wrong(const std::string& name, TimePoint now) {
  Record& record = record_of(name, now);
  record.last_offence = now;
  record.wrong.push_back(now);
  std::erase_if(record.wrong, [now](TimePoint at) { return now - at > kWindow; });
  return record.wrong.size() >= kWrongMax;
}

void Quarantine::count_violation(const std::string& name, const std::string& reason,
                                 TimePoint now) {
  Record& record = record_of(name, now);
  record.last_offence = now;
  hold(record, reason, now);
}

std::optional<QuarantinedSlave> Quarantine::find(const std::string& name, TimePoint now) const {
  const auto found = records_.find(name);
  if (found == records_.end() || found->second.until <= now) return std::nullopt;
  const Record& record = found->second;
  return QuarantinedSlave{name, seconds(record.until - now), record.times, record.reason};
}

std::vector<QuarantinedSlave> Quarantine::entries(TimePoint now) const {
  std::vector<QuarantinedSlave> held;
  for (const auto& [name, record] : records_) {
    if (const auto one = find(name, now)) held.push_back(*one);
  }
  return held;
}

}  // namespace tessera::master
