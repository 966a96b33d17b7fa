// SPDX-License-Identifier: Apache-2.0
#include "master/session/interactive_loop.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "tests/support/seed.h"
#include "tests/unit/session/interactive_world.h"

namespace tessera {
namespace {

constexpr double kBudgetSeconds = 0.1;

FrameSettings full() {
  FrameSettings s;
  s.width_px = 640;
  s.height_px = 480;
  return s;
}
double full_rays() { return InteractiveWorld::rays(full()); }

InteractiveOptions options() {
  InteractiveOptions o;
  o.budget_seconds = kBudgetSeconds;
  o.passes = 4;
  return o;
}

// A world whose full frame takes `full_seconds`.
InteractiveWorld world(double full_seconds, const InteractiveOptions& o = options()) {
  InteractiveWorld w(o);
  w.rays_per_second = full_rays() / full_seconds;
  return w;
}

std::vector<int> widths(const std::vector<InteractiveWorld::Shown>& shown, std::size_t from = 0) {
  std::vector<int> result;
  for (std::size_t i = from; i < shown.size(); ++i) result.push_back(shown[i].settings.width_px);
  return result;
}

// Moves the camera every `interval` seconds, as a hand that drags does.
void drag(InteractiveWorld& w, double drag_seconds, double interval = 0.010) {
  for (double t = 0; t < drag_seconds; t += interval) {
    w.move();
    w.run(interval);
  }
}

TEST(InteractiveLoopAtRest, SizesClimbThenPassesThenNothing) {
  for (const int samples : {1, 16}) {
    InteractiveWorld w = world(3);
    FrameSettings wanted = full();
    wanted.samples_per_pixel = samples;
    w.want(wanted);
    w.run(60 * samples);
    // With sixteen samples, a picture of all pixels with fewer samples comes before the full one.
    EXPECT_EQ(widths(w.shown), samples == 1
                                   ? (std::vector<int>{160, 320, 640, 640, 640, 640})
                                   : (std::vector<int>{160, 320, 640, 640, 640, 640, 640}));
    const std::size_t first_full = w.shown.size() - 4;
    for (std::size_t i = 0; i < w.shown.size(); ++i) {
      EXPECT_EQ(w.shown[i].arrival.is_full, i >= first_full) << i;
      EXPECT_EQ(w.shown[i].arrival.width_px, 640) << "what each stands for";
      if (i < first_full) continue;
      EXPECT_EQ(w.shown[i].arrival.pass, i - first_full);
    }
    EXPECT_TRUE(w.given_up.empty());
    EXPECT_EQ(w.submitted.size(), w.shown.size()) << "and then it rests";
    EXPECT_FALSE(w.loop.has_frames_in_flight());
  }
}

TEST(InteractiveLoopAtRest, StepsThatFitTheBudgetArePassedOver) {
  InteractiveWorld w = world(0.09);
  w.want(full());
  w.run(10);
  w.shown.clear();
  w.resize(648, 488);
  w.run(10);
  EXPECT_EQ(widths(w.shown), (std::vector<int>(4, 648))) << "the four passes";
}

// 1/16 + 1/4 + 1 is the cost in full frames, beside that of giving up and of rounding to pixels.
TEST(InteractiveLoopAtRest, TheWayUpTakesAThirdMoreThanTheFullFrameAlone) {
  for (const double full_seconds : {0.2, 0.5, 2.0, 20.0}) {
    InteractiveWorld w = world(full_seconds);
    w.want(full());
    w.run(40 * full_seconds);
    w.shown.clear();
    const double from = w.now;
    w.resize(320, 240);
    w.run(40 * full_seconds);
    const auto first_full = std::find_if(w.shown.begin(), w.shown.end(),
                                         [](const auto& s) { return s.arrival.is_full; });
    ASSERT_NE(first_full, w.shown.end());
    EXPECT_LE(first_full->at - from, 1.3125 * full_seconds / 4 + 0.005) << full_seconds;
  }
}

TEST(InteractiveLoopAtRest, NoStepShowsLessThanTheOneBefore) {
  for (const double full_seconds : {0.05, 0.15, 0.3, 1.0, 10.0, 100.0}) {
    InteractiveWorld w = world(full_seconds);
    w.want(full());
    w.run(10 * full_seconds);
    drag(w, 2);
    w.run(0.15);  // the last moving frame
    const std::size_t from = w.shown.empty() ? 0 : w.shown.size() - 1;
    w.run(10 * full_seconds + 1);
    for (std::size_t i = from + 1; i < w.shown.size(); ++i)
      ASSERT_FALSE(FramePacer::is_better(w.shown[i - 1].settings, w.shown[i].settings)) << i;
    EXPECT_TRUE(w.shown.back().arrival.is_full) << full_seconds;
  }
}

TEST(InteractiveLoopMoving, FramesKeepTheBudgetAndFollowTheHand) {
  for (const double full_seconds : {0.02, 0.1, 0.5, 1.0, 3.0}) {
    InteractiveWorld w = world(full_seconds);
    w.want(full());
    w.run(1);
    drag(w, 1);  // the loop finds its size
    w.shown.clear();
    const double from = w.now;
    drag(w, 4);
    ASSERT_FALSE(w.shown.empty());
    // 1.12: FramePacer's band of 1.05^2, and sides rounded to pixels.
    for (const auto& shown : w.shown)
      EXPECT_LE(w.frame_seconds(shown.settings), kBudgetSeconds * 1.12) << full_seconds;
    const double frames = static_cast<double>(w.shown.size());
    EXPECT_GE(frames / (w.now - from),
              std::min(1 / (1.12 * kBudgetSeconds), 1 / full_seconds) * 0.9)
        << full_seconds << ": no time is left unused";
    EXPECT_TRUE(w.given_up.size() <= 2) << "of rest, when the drags began";
  }
}

// A movement is seen in the first frame submitted after it. Until then at most these go by: the
// lead of 15 ms that is left of the frame in work, the frame behind that one, and the frame itself.
TEST(InteractiveLoopMoving, AMovementIsSeenWithinTwoFramesAndTheLead) {
  InteractiveWorld w = world(1);
  w.want(full());
  w.run(5);
  drag(w, 1);
  w.shown.clear();
  w.submitted.clear();
  std::vector<std::pair<double, float>> moves;
  for (int i = 0; i < 400; ++i) {
    w.move();
    moves.emplace_back(w.now, w.wanted.camera.eye.x);
    w.run(0.010);
  }
  w.run(1);
  double worst = 0;
  for (const auto& [at, eye_x] : moves) {
    const auto seen = std::find_if(w.shown.begin(), w.shown.end(), [x = eye_x](const auto& shown) {
      return shown.settings.camera.eye.x >= x;
    });
    ASSERT_NE(seen, w.shown.end());
    worst = std::max(worst, seen->at - at);
  }
  EXPECT_LE(worst, 2 * 1.12 * kBudgetSeconds + 0.015 + 0.002);
  EXPECT_LE(worst, 0.250);
}

TEST(InteractiveLoopMoving, AHandThatNeverRestsSeesFramesAllTheTime) {
  const unsigned seed = test::seed();
  TESSERA_TRACE_SEED(seed);
  std::mt19937 random(seed);
  for (int round = 0; round < 200; ++round) {
    const double full_seconds = std::exp(std::uniform_real_distribution(-4.0, 2.0)(random));
    InteractiveWorld w = world(full_seconds);
    w.scene_ready_at = round % 3 == 0 ? 2 : 0;
    w.want(full());
    w.run(std::uniform_real_distribution(0.0, 3.0)(random));
    const double from = w.now;
    std::size_t before = w.shown.size();
    double last = std::max(from, w.scene_ready_at);
    // The time of a moving frame and of a resting one that is given up, and as many pauses.
    const double longest = 2 * std::max(2 * kBudgetSeconds, full_seconds / 64 * 1.2) +
                           2 * InteractiveLoop::kRestSeconds;
    while (w.now < from + 5) {
      const double pause = std::uniform_real_distribution(0.0, 0.3)(random);
      w.move();
      w.run(pause);
      if (w.shown.size() > before) last = w.now;
      before = w.shown.size();
      ASSERT_LE(w.now - last, longest + 0.3) << "full frame: " << full_seconds << " s";
    }
    ASSERT_LE(w.in_flight_max, 2u);
    ASSERT_FALSE(w.is_stuck);
  }
}

TEST(InteractiveLoopMoving, RestingFramesAreLeftBehindAtOnce) {
  for (const double moved_after : {0.01, 0.3, 1.0, 3.9, 9.0}) {  // climbing, full, passes
    InteractiveWorld w = world(3);
    w.want(full());
    w.run(1);
    drag(w, 0.5);
    w.run(InteractiveLoop::kRestSeconds + 0.1 + moved_after);
    const std::size_t given_up = w.given_up.size(), submitted = w.submitted.size();
    ASSERT_TRUE(w.loop.has_frames_in_flight());
    w.move();
    EXPECT_EQ(w.given_up.size(), given_up + 1) << moved_after;
    w.run(0.01);
    ASSERT_EQ(w.submitted.size(), submitted + 1) << moved_after;
    EXPECT_LE(w.frame_seconds(w.submitted.back().settings), kBudgetSeconds * 1.12);
    const std::size_t shown = w.shown.size();
    w.run(0.15);
    ASSERT_GT(w.shown.size(), shown);
    EXPECT_EQ(w.shown[shown].settings.camera, w.wanted.camera) << "nothing older comes first";
  }
}

TEST(InteractiveLoopMoving, AClusterThatSlowsDownIsFoundOut) {
  InteractiveWorld w = world(0.05);
  w.want(full());
  w.run(2);
  drag(w, 1);
  w.rays_per_second /= 40;  // a full frame takes two seconds now
  w.shown.clear();
  drag(w, 3);
  ASSERT_GE(w.shown.size(), 10u);
  EXPECT_LE(w.frame_seconds(w.shown.back().settings), kBudgetSeconds * 1.12);
}

TEST(InteractiveLoopResize, FramesOfTheOldSizeAreLeftBehindInEveryCase) {
  for (const bool has_budget : {true, false}) {
    for (const bool is_dragging : {true, false}) {
      for (const bool is_animated : {true, false}) {
        for (const double after : {0.0, 0.05, 0.4, 1.2, 5.0, 8.0}) {
          InteractiveOptions o = options();
          o.budget_seconds = has_budget ? kBudgetSeconds : 0;
          o.is_animated = is_animated;
          InteractiveWorld w = world(3, o);
          w.want(full());
          w.run(after);
          if (is_dragging) drag(w, 0.5);
          const std::size_t given_up = w.given_up.size(), shown = w.shown.size();
          ASSERT_TRUE(w.loop.has_frames_in_flight());
          w.resize(800, 500);
          EXPECT_EQ(w.given_up.size(), given_up + 1);
          w.run(20);
          ASSERT_GT(w.shown.size(), shown);
          for (std::size_t i = shown; i < w.shown.size(); ++i)
            EXPECT_EQ(w.shown[i].arrival.width_px, 800);
        }
      }
    }
  }
}

TEST(InteractiveLoopStatus, IsAskedForWithoutFramesAndInTime) {
  InteractiveWorld w = world(1);
  w.slave_count = 0;
  w.want(full());
  w.run(10);
  EXPECT_TRUE(w.shown.empty());
  // A remote session answers what it asked for one question before; a loss is seen after two.
  static_assert(2 * InteractiveLoop::kStatusSeconds <= 1.5);
  double last = 0;
  for (const double at : w.asked) {
    EXPECT_LE(at - last, InteractiveLoop::kStatusSeconds + 0.005);
    last = at;
  }
  EXPECT_LE(w.now - last, InteractiveLoop::kStatusSeconds + 0.005);
  EXPECT_LE(w.asked.size(), 25u) << "and not more often than that";
}

TEST(InteractiveLoopStatus, WithoutSlavesTheNewestViewIsTheOneThatWaits) {
  InteractiveWorld w = world(0.3);
  w.want(full());
  w.run(3);
  drag(w, 0.5);
  w.slave_count = 0;
  w.run(2);
  drag(w, 2);
  w.slave_count = 1;
  const std::size_t shown = w.shown.size();
  w.run(1);
  ASSERT_GT(w.shown.size(), shown);
  EXPECT_EQ(w.shown[shown].settings.camera, w.wanted.camera);
  EXPECT_GE(w.shown[shown].settings.width_px, 200) << "time without slaves says nothing of speed";
}

TEST(InteractiveLoopWithoutBudget, NothingIsReducedAndTheHandSeesWhatThereIs) {
  InteractiveOptions o = options();
  o.budget_seconds = 0;
  InteractiveWorld w = world(0.5, o);
  w.want(full());
  w.run(5);
  EXPECT_EQ(w.shown.size(), 4u);
  drag(w, 5);
  for (const auto& submitted : w.submitted) EXPECT_EQ(submitted.settings.width_px, 640);
  EXPECT_GE(w.shown.size(), 4u + 8u) << "a frame each half second";
  const std::size_t before = w.given_up.size();
  w.run(1.8);  // within the passes
  w.move();
  EXPECT_EQ(w.given_up.size(), before + 1) << "nobody will look at a further pass";
}

TEST(InteractiveLoopAnimated, GoesOnWithinTheBudget) {
  InteractiveOptions o = options();
  o.is_animated = true;
  InteractiveWorld w = world(1, o);
  w.want(full());
  w.run(2);
  w.shown.clear();
  w.run(4);
  EXPECT_GE(w.shown.size(), 35u);
  for (const auto& shown : w.shown)
    EXPECT_LE(w.frame_seconds(shown.settings), kBudgetSeconds * 1.12);
}

TEST(InteractiveLoopAnimated, APauseRestsAndASteppedViewClimbsAgain) {
  InteractiveOptions o = options();
  o.is_animated = true;
  InteractiveWorld w = world(1, o);
  w.want(full());
  w.run(4);
  w.loop.set_animated(false);
  w.want(full());
  w.shown.clear();
  w.run(30);
  EXPECT_TRUE(w.shown.back().arrival.is_full);
  EXPECT_EQ(w.shown.back().arrival.pass, 3u) << "it climbs and gets its passes";
  EXPECT_FALSE(w.loop.has_frames_in_flight()) << "and then it rests";
  FrameSettings next = full();
  next.time_seconds = 0.5;  // a step
  w.shown.clear();
  w.want(next);
  w.run(30);
  ASSERT_FALSE(w.shown.empty());
  for (const auto& shown : w.shown) EXPECT_EQ(shown.settings.time_seconds, 0.5);
  EXPECT_LE(w.shown.front().arrival.latency_seconds, kBudgetSeconds * 1.12) << "small at first";
  EXPECT_TRUE(w.shown.back().arrival.is_full);
  w.loop.set_animated(true);
  w.want(full());
  w.shown.clear();
  w.run(4);
  EXPECT_GE(w.shown.size(), 30u) << "it plays again";
}

TEST(InteractiveLoopScene, AnotherSceneIsShownAnewAndNoPassOfTheOldOneCounts) {
  InteractiveWorld w = world(1);
  w.loop.scene_changed();  // before anything is wanted it means nothing
  w.want(full());
  w.run(2.5);  // in the midst of the passes
  ASSERT_TRUE(w.shown.back().arrival.is_full);
  w.loop.scene_changed();
  const std::size_t before = w.shown.size();
  w.run(30);
  EXPECT_EQ(w.given_up.size(), 1u) << "the pass in work is of the old scene";
  ASSERT_GT(w.shown.size(), before);
  EXPECT_LE(w.frame_seconds(w.shown[before].settings), kBudgetSeconds * 1.12) << "it climbs";
  EXPECT_EQ(w.shown[before].arrival.pass, 0u);
  EXPECT_EQ(w.shown.back().arrival.pass, 3u);
}

TEST(InteractiveLoopForScreenshots, FullFramesGoOnForEver) {
  InteractiveOptions o = options();
  o.never_rests = true;
  for (const bool is_animated : {false, true}) {
    o.is_animated = is_animated;
    InteractiveWorld w = world(0.2, o);
    w.want(full());
    w.run(10);
    const auto full_count = std::count_if(w.shown.begin(), w.shown.end(),
                                          [](const auto& s) { return s.arrival.is_full; });
    EXPECT_GE(full_count, 45);
  }
}

TEST(InteractiveLoopStart, TheFirstPixelsAreASixteenthOfThem) {
  InteractiveWorld w = world(1);
  w.scene_ready_at = 4;
  w.want(full());
  w.run(30);
  EXPECT_EQ(w.submitted.front().settings.width_px, 160);
  EXPECT_TRUE(w.given_up.empty());
  drag(w, 1);
  EXPECT_GE(w.shown.back().settings.width_px, 150) << "waiting for the scene was no rendering";
}

}  // namespace
}  // namespace tessera
