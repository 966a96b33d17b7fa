// SPDX-License-Identifier: Apache-2.0
#include "master/import/crash_line.h"

#include <unistd.h>

#include <algorithm>
#include <cstddef>
#include <cstring>
#include <string_view>

namespace tessera::import {
namespace {

#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
constexpr bool kIsOn = false;
#else
constexpr bool kIsOn = true;
#endif
constexpr std::size_t kStackBytes = 64 * 1024;  // the handler's own: the stack may be what ran out
constexpr std::size_t kPathBytesMax = 2000;
constexpr const char* kCrashes[] = {"segmentation fault", "bus error", "arithmetic exception",
                                    "illegal instruction", "abort"};
constexpr std::string_view kTimeLimit = "reading it takes more processor time than the limit\n";
constexpr std::string_view kUsualEnd = "; the file is probably damaged\n";

// Text of a part of the line, which a handler can read at any time: its length is set last.
class Text {
 public:
  void set(std::string_view text) {
    size_ = 0;
    const std::size_t size = std::min(text.size(), sizeof(bytes_));
    std::memcpy(bytes_, text.data(), size);
    std::replace(bytes_, bytes_ + size - (text.ends_with('\n') ? 1 : 0), '\n', ' ');
    size_ = size;
  }
  std::string_view view() const { return {bytes_, size_}; }

 private:
  char bytes_[2048];
  volatile std::size_t size_ = 0;
};

Text g_file, g_reader, g_end;
alignas(16) char g_stack[kStackBytes];

[[noreturn]] void tell(int signal) {
  // One write, so that no other thread's line comes between.
  char line[4 * sizeof(Text)];
  std::size_t size = 0;
  const auto add = [&](std::string_view text) {
    std::memcpy(line + size, text.data(), text.size());
    size += text.size();
  };
  add(g_file.view());
  if (signal == SIGXCPU) {
    add(kTimeLimit);
  } else {
    const auto at = std::find(CrashLine::kSignals.begin(), CrashLine::kSignals.end(), signal);
    add(g_reader.view());
    add(kCrashes[at - CrashLine::kSignals.begin()]);
    add(")");
    add(g_end.view());
  }
  [[maybe_unused]] const ssize_t written = ::write(STDERR_FILENO, line, size);
  ::_exit(1);
}

}  // namespace

CrashLine::CrashLine(const std::string& path, const std::string& reader)
    : before_{}, stack_before_{} {
  g_file.set("tessera-import: " + path.substr(0, kPathBytesMax) + ": ");
  g_reader.set(reader + " crashed (");
  g_end.set(kUsualEnd);
  if constexpr (!kIsOn) return;
  stack_t stack{};
  stack.ss_sp = g_stack;
  stack.ss_size = kStackBytes;
  ::sigaltstack(&stack, &stack_before_);
  struct sigaction action {};
  action.sa_handler = tell;
  action.sa_flags = SA_ONSTACK;
  for (std::size_t i = 0; i < kSignals.size(); ++i) ::sigaction(kSignals[i], &action, &before_[i]);
}

CrashLine::~CrashLine() {
  if constexpr (!kIsOn) return;
  for (std::size_t i = 0; i < kSignals.size(); ++i) ::sigaction(kSignals[i], &before_[i], nullptr);
  ::sigaltstack(&stack_before_, nullptr);
}

void CrashLine::note(const std::string& text) { g_end.set("; " + text + "\n"); }

}  // namespace tessera::import
