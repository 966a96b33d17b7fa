#include "master/commands/progress.h"

#include <unistd.h>

#include <algorithm>
#include <cstdio>

namespace tessera::master {
namespace {
constexpr int kBarCells = 30;
constexpr auto kBarInterval = std::chrono::milliseconds(100);
constexpr auto kLineInterval = std::chrono::seconds(2);
}  // namespace

Progress::Progress(bool is_quiet) : is_quiet_(is_quiet), is_terminal_(isatty(STDERR_FILENO) == 1) {}

Progress::~Progress() { clear_line(); }

void Progress::clear_line() {
  if (has_bar_) std::fprintf(stderr, "\r\033[K");
  has_bar_ = false;
}

void Progress::update(const std::string& text, double fraction) {
  if (is_quiet_) return;
  const TimePoint now = Clock::now();
  if (now - last_shown_ < (is_terminal_ ? Duration(kBarInterval) : Duration(kLineInterval))) return;
  last_shown_ = now;
  const int percent = static_cast<int>(100 * std::clamp(fraction, 0.0, 1.0));
  if (!is_terminal_) {
    if (fraction < 0) {
      std::fprintf(stderr, "%s\n", text.c_str());
    } else {
      std::fprintf(stderr, "%s (%d %%)\n", text.c_str(), percent);
    }
    return;
  }
  std::string bar;
  const int filled = percent * kBarCells / 100;
  for (int i = 0; i < kBarCells; ++i) bar += i < filled ? "#" : ".";
  if (fraction < 0) {
    std::fprintf(stderr, "\r\033[K%s ...", text.c_str());
  } else {
    std::fprintf(stderr, "\r\033[K[%s] %3d %% %s", bar.c_str(), percent, text.c_str());
  }
  std::fflush(stderr);
  has_bar_ = true;
}

void Progress::finish(const std::string& text) {
  if (is_quiet_) return;
  clear_line();
  std::fprintf(stderr, "%s\n", text.c_str());
  last_shown_ = {};
}

}  // namespace tessera::master
