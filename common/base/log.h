// SPDX-License-Identifier: Apache-2.0
// Log lines for operators, as text or as one JSON object per line, on stderr.
//
// One event of the world gives one line: a short event name ("slave-lost"), a sentence, and fields.
// Never logged: keys, pixels, scene content. spdlog is confined to log.cpp.
//
// An event of level info and above is written kLogLinesMax times in kLogInterval; further lines are
// summed up in one line of their own (log_limiter.h). Levels below are for debugging and are not
// limited.
//
// Threads. Any thread may log after init_log(); lines never interleave. Before init_log() lines of
// level warn and above go out as text.
#pragma once

#include <chrono>
#include <initializer_list>
#include <string>
#include <string_view>
#include <vector>

#include "common/base/api.h"
#include "common/base/event_memory.h"
#include "common/base/status.h"

namespace tessera {

enum class LogLevel { kTrace, kDebug, kInfo, kWarn, kError, kOff };
enum class LogFormat { kText, kJson };

struct LogField {
  std::string_view key;
  std::string value;
};

inline constexpr int kLogLinesMax = 20;
inline constexpr std::chrono::seconds kLogInterval{10};

// Call once, at the start of main.
TESSERA_API void init_log(LogLevel level, LogFormat format);

// Returns: kInvalidArgument naming the values that exist.
Result<LogLevel> parse_log_level(std::string_view text);

// Writes one line for each event of which lines were suppressed in intervals that are over. A call
// costs one atomic read when there are none. Call it now and then: an event that has stopped would
// never be summed up otherwise. `is_last`: sums up the present interval, too.
void log_summaries(bool is_last = false);

// What this process has logged: its last lines of level info and above, and how many it kept back.
struct LogMemory {
  std::vector<PastEvent> events;  // oldest first
  std::vector<SuppressedLines> suppressed;
};
LogMemory log_memory();
std::string_view log_level_name(LogLevel level);

void log_event(LogLevel level, std::string_view event, std::string_view text,
               std::initializer_list<LogField> fields = {});

inline void log_debug(std::string_view event, std::string_view text,
                      std::initializer_list<LogField> fields = {}) {
  log_event(LogLevel::kDebug, event, text, fields);
}
inline void log_info(std::string_view event, std::string_view text,
                     std::initializer_list<LogField> fields = {}) {
  log_event(LogLevel::kInfo, event, text, fields);
}
inline void log_warn(std::string_view event, std::string_view text,
                     std::initializer_list<LogField> fields = {}) {
  log_event(LogLevel::kWarn, event, text, fields);
}
inline void log_error(std::string_view event, std::string_view text,
                      std::initializer_list<LogField> fields = {}) {
  log_event(LogLevel::kError, event, text, fields);
}

}  // namespace tessera
