// SPDX-License-Identifier: Apache-2.0
#include "common/base/log.h"

#include <spdlog/sinks/stdout_color_sinks.h>
#include <spdlog/spdlog.h>

#include <atomic>
#include <cstdio>
#include <iterator>
#include <memory>

#include "common/base/clean_text.h"
#include "common/base/json.h"
#include "common/base/log_limiter.h"
#include "common/base/mutex.h"

namespace tessera {
namespace {

constexpr std::string_view kLevels[] = {"trace", "debug", "info", "warn", "error", "off"};

LogFormat g_format = LogFormat::kText;  // written once by init_log, before other threads start

std::shared_ptr<spdlog::logger>& logger() {
  static std::shared_ptr<spdlog::logger> instance = [] {
    auto made = spdlog::stderr_color_mt("tessera");
    made->set_level(spdlog::level::warn);
    made->set_pattern("%H:%M:%S.%e %^%l%$ %v");
    return made;
  }();
  return instance;
}

std::string json_body(std::string_view event, std::string_view text,
                      std::initializer_list<LogField> fields) {
  std::string out = "\"event\":";
  append_json_string(out, clean_text(event));
  out += ",\"text\":";
  append_json_string(out, clean_text(text));
  for (const LogField& field : fields) {
    out.push_back(',');
    append_json_string(out, field.key);
    out.push_back(':');
    append_json_string(out, clean_text(field.value));
  }
  return out;
}

std::string text_body(std::string_view event, std::string_view text,
                      std::initializer_list<LogField> fields) {
  std::string out = clean_text(event);
  out += ": ";
  out += clean_text(text);
  for (const LogField& field : fields) {
    out += ' ';
    out += field.key;
    out += '=';
    out += clean_text(field.value);
  }
  return out;
}

// The limiter and its lock, for all threads.
class Gate {
 public:
  bool admit(std::string_view event) TESSERA_EXCLUDES(mutex_) {
    MutexLock lock(mutex_);
    const bool is_admitted = limiter_.admit(event, Clock::now());
    if (!is_admitted) has_suppressed_.store(true, std::memory_order_relaxed);
    return is_admitted;
  }
  void remember(LogLevel level, std::string_view line) TESSERA_EXCLUDES(mutex_) {
    MutexLock lock(mutex_);
    memory_.add(static_cast<std::uint8_t>(level), line, Clock::now());
  }
  LogMemory memory() TESSERA_EXCLUDES(mutex_) {
    MutexLock lock(mutex_);
    return {memory_.events(Clock::now()), limiter_.ever_suppressed()};
  }
  std::vector<LogLimiter::Summary> summaries(bool is_last) TESSERA_EXCLUDES(mutex_) {
    if (!has_suppressed_.load(std::memory_order_relaxed)) return {};
    MutexLock lock(mutex_);
    auto result = limiter_.summaries(Clock::now(), is_last);
    has_suppressed_.store(limiter_.has_suppressed(), std::memory_order_relaxed);
    return result;
  }

 private:
  std::atomic<bool> has_suppressed_{false};
  Mutex mutex_;
  LogLimiter limiter_ TESSERA_GUARDED_BY(mutex_){kLogLinesMax, kLogInterval};
  EventMemory memory_ TESSERA_GUARDED_BY(mutex_);
};

Gate& gate() {
  static Gate instance;
  return instance;
}

void write_line(LogLevel level, std::string_view event, std::string_view text,
                std::initializer_list<LogField> fields) {
  const std::string line = text_body(event, text, fields);
  if (level >= LogLevel::kInfo) gate().remember(level, line);
  const std::string body = g_format == LogFormat::kJson ? json_body(event, text, fields) : line;
  logger()->log(static_cast<spdlog::level::level_enum>(level), "{}", body);
}

}  // namespace

void init_log(LogLevel level, LogFormat format) {
  g_format = format;
  logger()->set_level(static_cast<spdlog::level::level_enum>(level));
  if (format == LogFormat::kJson) {
    logger()->set_pattern(R"({"time":"%Y-%m-%dT%H:%M:%S.%e%z","level":"%l",%v})");
  }
}

LogMemory log_memory() { return gate().memory(); }

std::string_view log_level_name(LogLevel level) { return kLevels[static_cast<std::size_t>(level)]; }

Result<LogLevel> parse_log_level(std::string_view text) {
  for (std::size_t i = 0; i < std::size(kLevels); ++i) {
    if (text == kLevels[i]) return static_cast<LogLevel>(i);
  }
  return Status::invalid_argument("--log-level " + std::string(text) +
                                  ": give one of trace, debug, info, warn, error, off");
}

void log_event(LogLevel level, std::string_view event, std::string_view text,
               std::initializer_list<LogField> fields) {
  const auto spd_level = static_cast<spdlog::level::level_enum>(level);
  if (!logger()->should_log(spd_level)) return;
  if (level >= LogLevel::kInfo) {
    log_summaries();
    if (!gate().admit(event)) return;
  }
  write_line(level, event, text, fields);
}

void log_summaries(bool is_last) {
  for (const LogLimiter::Summary& summary : gate().summaries(is_last)) {
    char text[64];
    std::snprintf(text, sizeof(text), "... and %llu more in %.0f s",
                  static_cast<unsigned long long>(summary.suppressed), summary.seconds);
    write_line(LogLevel::kWarn, summary.event, text,
               {{"suppressed", std::to_string(summary.suppressed)}});
  }
}

}  // namespace tessera
