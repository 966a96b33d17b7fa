// SPDX-License-Identifier: Apache-2.0
// A crash of a library becomes one line that names the file, and exit code 1.
#include "master/import/crash_line.h"

#include <gtest/gtest.h>
#include <signal.h>
#include <sys/resource.h>

#include <cstdlib>

namespace tessera::import {
namespace {

using testing::ExitedWithCode;

#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
#define SKIP_UNDER_SANITIZERS() GTEST_SKIP() << "sanitizers tell of crashes themselves"
#else
#define SKIP_UNDER_SANITIZERS() (void)0
#endif

// Never returns; the stack ends first.
int deepen(volatile char* above, int depth) {
  volatile char room[4096];
  room[0] = above == nullptr ? '\0' : above[0];
  return depth < 0 ? 0 : deepen(room, depth + 1) + room[0];
}

TEST(CrashLineDeathTest, NamesFileReaderAndCrash) {
  SKIP_UNDER_SANITIZERS();
  const auto crash = [](int signal) {
    const CrashLine line("folder/a\nb.step", "Reader");
    raise(signal);
  };
  EXPECT_EXIT(crash(SIGSEGV), ExitedWithCode(1),
              "^tessera-import: folder/a b.step: Reader crashed .segmentation fault.; the file is "
              "probably damaged\n$");
  EXPECT_EXIT(crash(SIGFPE), ExitedWithCode(1), "crashed .arithmetic exception.;");
  EXPECT_EXIT(crash(SIGABRT), ExitedWithCode(1), "crashed .abort.;");
  EXPECT_EXIT(crash(SIGXCPU), ExitedWithCode(1),
              "^tessera-import: folder/a b.step: reading it takes more processor time than the "
              "limit\n$");
}

TEST(CrashLineDeathTest, SaysWhatIsKnownOfTheFile) {
  SKIP_UNDER_SANITIZERS();
  const auto crash = [] {
    const CrashLine line("a.step", "Reader");
    CrashLine::note("entity #7\nis damaged");
    abort();
  };
  EXPECT_EXIT(crash(), ExitedWithCode(1),
              "^tessera-import: a.step: Reader crashed .abort.; entity #7 is damaged\n$");
}

TEST(CrashLineDeathTest, SpeaksWhenTheStackIsFull) {
  SKIP_UNDER_SANITIZERS();
  const auto crash = [] {
    const CrashLine line("a.step", "Reader");
    deepen(nullptr, 0);
  };
  EXPECT_EXIT(crash(), ExitedWithCode(1), "a.step: Reader crashed .segmentation fault.");
}

TEST(CrashLineDeathTest, TheLastOneSpeaksAndTheOneBeforeComesBack) {
  SKIP_UNDER_SANITIZERS();
  const auto crash = [](bool is_over) {
    const CrashLine outer("outer.step", "Reader");
    if (is_over) {
      const CrashLine inner("inner.step", "Reader");
      raise(SIGSEGV);
    }
    { const CrashLine inner("inner.step", "Reader"); }
    raise(SIGSEGV);
  };
  EXPECT_EXIT(crash(true), ExitedWithCode(1), "inner.step");
  // Both are of one program here, so the words are those of the last one; the handler is back.
  EXPECT_EXIT(crash(false), ExitedWithCode(1), "Reader crashed");
}

TEST(CrashLineDeathTest, LongPathsAreCut) {
  SKIP_UNDER_SANITIZERS();
  const auto crash = [] {
    const CrashLine line(std::string(100'000, 'x'), std::string(100'000, 'r'));
    CrashLine::note(std::string(100'000, 'n'));
    raise(SIGSEGV);
  };
  EXPECT_EXIT(crash(), ExitedWithCode(1), "^tessera-import: xxx");
}

}  // namespace
}  // namespace tessera::import
