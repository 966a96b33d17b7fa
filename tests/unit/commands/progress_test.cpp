// SPDX-License-Identifier: Apache-2.0
// What a person sees of long work: one row on a terminal, lines in a pipe, and a guess of the time
// that is left, which is steady and right.
#include "master/commands/progress.h"

#include <gtest/gtest.h>

#include <cmath>
#include <set>
#include <sstream>
#include <string>
#include <vector>

namespace tessera::master {
namespace {

using namespace std::chrono_literals;

const TimePoint kStart{1000s};

// Seconds that the text says are left ("about 2 h 5 min left"); -1: it does not say.
double left_in(const std::string& text) {
  const std::size_t about = text.find("about ");
  const std::size_t end = text.find(" left");
  if (about == std::string::npos || end == std::string::npos) return -1;
  std::istringstream words(text.substr(about + 6, end - about - 6));
  double seconds = 0, number = 0;
  for (std::string unit; words >> number >> unit;) {
    seconds += number * (unit == "h" ? 3600 : unit == "min" ? 60 : 1);
  }
  return seconds;
}

TEST(TimeLeft, SteadyWorkCountsDownWithoutASecondThoughtAndIsRight) {
  for (const double whole_seconds : {8.0, 40.0, 250.0, 3000.0, 40000.0}) {
    TimeLeft time;
    time.begin(kStart);
    double before = 1e9;
    bool was_said = false;
    for (int i = 0; i < 1000; ++i) {
      const double passed = whole_seconds * i / 1000;
      const std::string text = time.text(i / 1000.0, kStart + from_seconds(passed));
      const double left = left_in(text);
      if (left < 0) {
        EXPECT_LE(passed, 3.0 + whole_seconds / 1000) << text;
        continue;
      }
      was_said = true;
      EXPECT_LE(left, before) << text;
      // The guess is right and is rounded up, by at most a quarter where more than a few seconds
      // are left.
      const double truth = whole_seconds - passed;
      EXPECT_GE(left, truth - 1e-6 * whole_seconds) << text;
      EXPECT_LE(left, std::max(1.25 * truth, truth + 5)) << text;
      before = left;
    }
    EXPECT_TRUE(was_said) << whole_seconds;
  }
}

TEST(TimeLeft, WorkThatIsUnsteadyDoesNotMakeTheGuessDance) {
  TimeLeft time;
  time.begin(kStart);
  std::vector<double> said;
  for (int i = 1; i <= 200; ++i) {  // a fifth too slow, then a fifth too fast, and so on
    const double share = (i + 0.8 * std::sin(i * 0.7)) / 200;
    const double left =
        left_in(time.text(std::min(share, 0.999), kStart + std::chrono::seconds(i)));
    if (left >= 0 && (said.empty() || said.back() != left)) said.push_back(left);
  }
  int rises = 0;
  for (std::size_t i = 1; i < said.size(); ++i) rises += said[i] > said[i - 1] ? 1 : 0;
  EXPECT_LE(rises, 3);
  EXPECT_GT(said.size(), 10u);
}

TEST(TimeLeft, WhatWasSlowBeforeTheFirstShareIsNotCounted) {
  TimeLeft time;
  time.begin(kStart);
  EXPECT_EQ(time.text(-1, kStart + 100s), "1 min 40 s spent") << "building";
  EXPECT_EQ(time.text(0.0, kStart + 120s), "2 min 0 s spent");
  // Half of the work was done in 10 s, so that the rest takes as long.
  EXPECT_EQ(left_in(time.text(0.5, kStart + 130s)), 10);
  EXPECT_EQ(time.text(1, kStart + 140s), "2 min 20 s spent");
}

// ---- what is printed
class ProgressTest : public testing::Test {
 protected:
  ProgressTest() {
    now_ = kStart;
    Clock::set_source([] { return now_; });
  }
  ~ProgressTest() override {
    Clock::set_source(nullptr);
    std::fclose(file_);
  }
  std::string printed() {
    std::fflush(file_);
    std::rewind(file_);
    std::string text;
    for (int c = std::fgetc(file_); c != EOF; c = std::fgetc(file_)) text += static_cast<char>(c);
    return text;
  }
  // Renders frames that take a second each.
  void render(Progress& progress, int frames) {
    for (int i = 0; i < 10 * frames; ++i) {
      now_ += 100ms;
      progress.tick();
      if (i % 10 != 9) continue;
      const int done = i / 10 + 1;
      progress.update("rendered " + std::to_string(done) + " of " + std::to_string(frames) +
                          " frames, 1000 ms, 12.3 Mrays/s, 17 slaves",
                      static_cast<double>(done) / frames);
    }
  }
  static int count(const std::string& text, const std::string& word) {
    int count = 0;
    for (auto at = text.find(word); at != std::string::npos; at = text.find(word, at + 1)) ++count;
    return count;
  }

  static inline TimePoint now_;
  std::FILE* const file_ = std::tmpfile();
};

TEST_F(ProgressTest, OnATerminalOneRowIsDrawnOverAndTheTimeIsInItOnce) {
  {
    Progress progress(false, file_, true);
    progress.finish("loaded a.obj: 12 triangles");
    render(progress, 20);
    progress.finish("wrote a.png");
  }
  const std::string text = printed();
  EXPECT_EQ(count(text, "\n"), 2) << "what was loaded and what was written";
  EXPECT_NE(text.find("loaded a.obj: 12 triangles (0.0 s)\n"), std::string::npos);
  EXPECT_NE(text.find("\033[Kwrote a.png (20 s)\n"), std::string::npos);
  std::size_t rows = 0, guesses = 0;
  std::set<std::size_t> bars;  // lengths of the bars
  for (std::size_t at = text.find('\r'); at != std::string::npos; at = text.find('\r', at + 1)) {
    const std::string row = text.substr(at + 1, text.find("\033[K", at) - at - 1);
    if (row.empty()) continue;  // the bar was removed
    ++rows;
    EXPECT_LT(row.size(), 80u) << row;
    EXPECT_LE(count(row, " left"), 1) << row;
    EXPECT_EQ(count(row, " spent"), 1) << row;
    guesses += left_in(row) >= 0 ? 1u : 0u;
    bars.insert(row.find(']'));
  }
  EXPECT_EQ(bars.size(), 1u) << "the bar does not jump";
  EXPECT_GE(rows, 20u);
  EXPECT_GE(guesses, 10u);
}

TEST_F(ProgressTest, WhileNothingIsDoneTheClockGoesOn) {
  Progress progress(false, file_, true);
  progress.update("building the tree on 1 slave", -1);
  for (int i = 0; i < 50; ++i) {
    now_ += 100ms;
    progress.tick();
  }
  const std::string text = printed();
  EXPECT_NE(text.find("building the tree on 1 slave ... 0.0 s spent"), std::string::npos);
  EXPECT_NE(text.find("building the tree on 1 slave ... 5.0 s spent"), std::string::npos);
  EXPECT_EQ(count(text, "building"), 6) << "once a second";
}

TEST_F(ProgressTest, InAPipeThereAreWholeLinesEveryTwoSecondsAndNoBar) {
  {
    Progress progress(false, file_, false);
    render(progress, 20);
    progress.finish("wrote a.png");
  }
  const std::string text = printed();
  EXPECT_EQ(count(text, "\r") + count(text, "\033") + count(text, "#"), 0) << text;
  EXPECT_EQ(count(text, "\n"), 11) << text;
  EXPECT_EQ(count(text, " spent"), 10);
  EXPECT_NE(text.find("rendered 11 of 20 frames, 1000 ms, 12.3 Mrays/s, 17 slaves (55 %, 11 s "
                      "spent, about 9 s left)\n"),
            std::string::npos)
      << text;
}

TEST_F(ProgressTest, OtherLinesStandAboveTheBar) {
  Progress progress(false, file_, true);
  progress.update("rendering", 0.5);
  progress.say("tessera-master: warning: black");
  const std::string text = printed();
  EXPECT_NE(text.find("\r\033[Ktessera-master: warning: black\n"), std::string::npos);
}

TEST_F(ProgressTest, WhenQuietOnlyWhatIsSaidIsPrinted) {
  {
    Progress progress(true, file_, true);
    render(progress, 5);
    progress.say("a warning");
    progress.finish("wrote a.png");
  }
  EXPECT_EQ(printed(), "a warning\n");
}

}  // namespace
}  // namespace tessera::master
