// SPDX-License-Identifier: Apache-2.0
#include "common/base/log_limiter.h"

#include <algorithm>

namespace tessera {
namespace {
constexpr std::string_view kOthers = "other-events";
}  // namespace

bool LogLimiter::admit(std::string_view event, TimePoint now) {
  auto found = accounts_.find(event);
  if (found == accounts_.end()) {
    const bool has_room = accounts_.size() < kEventsMax;
    found = accounts_.try_emplace(std::string(has_room ? event : kOthers), Account{now}).first;
  }
  Account& account = found->second;
  // An account with suppressed lines keeps its interval until they are summed up.
  if (now - account.begin >= interval_ && account.suppressed == 0) begin_interval(account, now);
  if (account.lines < lines_max_) {
    ++account.lines;
    return true;
  }
  ++account.suppressed;
  ++suppressed_;
  return false;
}

std::vector<LogLimiter::Summary> LogLimiter::summaries(TimePoint now, bool is_last) {
  std::vector<Summary> result;
  if (suppressed_ == 0) return result;
  for (auto& [event, account] : accounts_) {
    if (account.suppressed == 0 || (now - account.begin < interval_ && !is_last)) continue;
    result.push_back({event, account.suppressed, seconds(now - account.begin)});
    suppressed_ -= account.suppressed;
    begin_interval(account, now);
  }
  return result;
}

void LogLimiter::begin_interval(Account& account, TimePoint now) {
  account = {now, 0, 0, account.suppressed_before + account.suppressed};
}

std::vector<SuppressedLines> LogLimiter::ever_suppressed() const {
  std::vector<SuppressedLines> result;
  for (const auto& [event, account] : accounts_) {
    const std::uint64_t lines = account.suppressed_before + account.suppressed;
    if (lines > 0) result.push_back({event, lines});
  }
  return result;
}

}  // namespace tessera
