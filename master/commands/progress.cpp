// SPDX-License-Identifier: Apache-2.0
#include "master/commands/progress.h"

#include <sys/ioctl.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>

#include "common/base/clean_text.h"

namespace tessera::master {
namespace {

using std::chrono::milliseconds;

constexpr milliseconds kBarInterval{100}, kTickInterval{1000}, kLineInterval{2000};
// Before this much of a stage is known, a guess is as good as none.
constexpr std::chrono::seconds kGuessAfter{3};
constexpr double kGuessKept = 0.2;  // of what is left
constexpr int kBarCellsMax = 30, kBarCellsMin = 4;
constexpr std::size_t kUsualWidth = 80;
constexpr int kTextColumns = 50;  // for all that is no bar; the bar has half of the rest

std::string time_text(double time_seconds) {
  char text[40];
  const auto whole = static_cast<long>(std::max(time_seconds, 0.0));
  if (time_seconds < 10) {
    std::snprintf(text, sizeof(text), "%.1f s", std::max(time_seconds, 0.0));
  } else if (whole < 60) {
    std::snprintf(text, sizeof(text), "%ld s", whole);
  } else if (whole < 3600) {
    std::snprintf(text, sizeof(text), "%ld min %ld s", whole / 60, whole % 60);
  } else {
    std::snprintf(text, sizeof(text), "%ld h %ld min", whole / 3600, whole / 60 % 60);
  }
  return text;
}

// The time left in coarse steps, rounded up, since no guess is good to the second.
std::string left_text(double left_seconds) {
  const double step = left_seconds < 10     ? 1
                      : left_seconds < 60   ? 5
                      : left_seconds < 300  ? 15
                      : left_seconds < 3600 ? 60
                                            : 600;
  const long whole = static_cast<long>(step * std::max(1.0, std::ceil(left_seconds / step)));
  if (whole < 60) return std::to_string(whole) + " s";
  if (whole < 300) return time_text(static_cast<double>(whole));
  return whole < 3600 ? std::to_string(whole / 60) + " min" : time_text(static_cast<double>(whole));
}

std::size_t width_of(std::FILE* terminal) {
  winsize size{};
  if (ioctl(fileno(terminal), TIOCGWINSZ, &size) != 0 || size.ws_col == 0) return kUsualWidth;
  return size.ws_col;
}

bool is_continued(char c) { return (static_cast<unsigned char>(c) & 0xc0) == 0x80; }  // UTF-8

// The first `columns` letters of `text`.
std::string cut(const std::string& text, std::size_t columns) {
  std::size_t end = 0;
  for (std::size_t letters = 0; end < text.size(); ++end) {
    if (!is_continued(text[end]) && ++letters > columns) break;
  }
  return text.substr(0, end);
}

std::string percent_text(double share) {
  return std::to_string(static_cast<int>(100 * std::clamp(share, 0.0, 1.0))) + " %";
}

std::string bar_of(double share, int cells) {
  std::string bar = "[";
  const auto filled = static_cast<int>(std::clamp(share, 0.0, 1.0) * cells);
  for (int i = 0; i < cells; ++i) bar += i < filled ? '#' : '.';
  return bar + "] ";
}

}  // namespace

void TimeLeft::begin(TimePoint now) {
  *this = TimeLeft();
  began_ = now;
}

std::string TimeLeft::spent_text(TimePoint now) const { return time_text(seconds(now - began_)); }

void TimeLeft::guess(double share, TimePoint now) {
  if (!known_since_) {
    known_since_ = now;
    first_share_ = share;
  }
  if (now - *known_since_ < kGuessAfter || share <= first_share_) return;
  const double left = seconds(now - *known_since_) * (1 - share) / (share - first_share_);
  const TimePoint end = now + from_seconds(std::min(left, 1e8));
  if (!end_ || std::abs(seconds(end - *end_)) > kGuessKept * left) end_ = end;
}

std::string TimeLeft::text(double share, TimePoint now) {
  const std::string spent = spent_text(now) + " spent";
  if (share < 0 || share >= 1) return spent;
  guess(share, now);
  return end_ ? spent + ", about " + left_text(seconds(*end_ - now)) + " left" : spent;
}

Progress::Progress(bool is_quiet) : Progress(is_quiet, stderr, isatty(STDERR_FILENO) == 1) {}

Progress::Progress(bool is_quiet, std::FILE* out, bool is_terminal)
    : is_quiet_(is_quiet), out_(out), is_terminal_(is_terminal) {
  MutexLock lock(mutex_);
  time_.begin(Clock::now());
}

Progress::~Progress() { clear(); }

void Progress::clear() {
  MutexLock lock(mutex_);
  clear_line();
}

void Progress::say(const std::string& line) {
  MutexLock lock(mutex_);
  clear_line();
  std::fprintf(out_, "%s\n", clean_text(line).c_str());
}

void Progress::clear_line() {
  if (has_bar_) std::fputs("\r\033[K", out_);
  has_bar_ = false;
}

void Progress::update(const std::string& text, double share) {
  MutexLock lock(mutex_);
  text_ = clean_text(text);
  share_ = share;
  if (is_quiet_) return;
  const TimePoint now = Clock::now();
  if (last_shown_ && now - *last_shown_ < (is_terminal_ ? kBarInterval : kLineInterval)) return;
  draw(now);
}

void Progress::tick() {
  MutexLock lock(mutex_);
  if (is_quiet_ || !is_terminal_ || !has_bar_) return;
  const TimePoint now = Clock::now();
  if (now - *last_shown_ >= kTickInterval) draw(now);
}

void Progress::draw(TimePoint now) {
  last_shown_ = now;
  const std::string time = time_.text(share_, now);
  const bool is_known = share_ >= 0;
  if (!is_terminal_) {
    std::fprintf(out_, "%s (%s%s)\n", text_.c_str(),
                 is_known ? (percent_text(share_) + ", ").c_str() : "", time.c_str());
    std::fflush(out_);
    return;
  }
  // The last column stays free: some terminals begin the next row with what stands there.
  const std::size_t room = width_of(out_) - 1;
  const std::string percent = percent_text(share_);
  const std::string pad(std::string("100 %").size() - percent.size(), ' ');
  std::string line = is_known ? pad + percent + ", " + time + ": " : "";
  if (is_known) {
    // The bar's length follows from the width alone, so that it does not jump with the text.
    const int cells = std::min(kBarCellsMax, (static_cast<int>(room) - kTextColumns) / 2);
    if (cells >= kBarCellsMin) line = bar_of(share_, cells) + line;
    line += text_;
  } else {
    const std::string end = " ... " + time;
    line = cut(text_, room - std::min(room, end.size())) + end;
  }
  // The row is drawn over, since most of it stays the same; only then is its rest cleared.
  std::fprintf(out_, "\r%s\033[K", cut(line, room).c_str());
  std::fflush(out_);
  has_bar_ = true;
}

void Progress::finish(const std::string& text) {
  MutexLock lock(mutex_);
  const TimePoint now = Clock::now();
  if (!is_quiet_) {
    clear_line();
    std::fprintf(out_, "%s (%s)\n", clean_text(text).c_str(), time_.spent_text(now).c_str());
  }
  time_.begin(now);
  last_shown_.reset();
  text_.clear();
  share_ = -1;
}

}  // namespace tessera::master
