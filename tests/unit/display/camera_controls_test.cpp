// SPDX-License-Identifier: Apache-2.0
#include "master/display/camera_controls.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <random>

#include "common/scene/validate.h"
#include "tests/support/seed.h"

namespace tessera::master {
namespace {

using Kind = InputEvent::Kind;

// Eye and target are rounded to float once each. That is 2^-24 of a coordinate (here below 64) for
// each of two roundings and three axes, on a distance of at least 0.01 x scene.
constexpr double kRelative = 1e-4;

Camera home_camera() { return {{3, 2, 5}, {0.5f, 0.25f, -1}, {0, 1, 0}, 40}; }

Bounds3f scene_box() {
  Bounds3f box;
  box.grow(Vec3f{-2, -1, -3});
  box.grow(Vec3f{4, 3, 2});
  return box;
}

InputEvent key(Kind kind, Key which, bool has_shift = false, bool has_control = false) {
  InputEvent e;
  e.kind = kind;
  e.key = which;
  e.has_shift = has_shift;
  e.has_control = has_control;
  return e;
}

InputEvent move_to(double x_px, double y_px) {
  InputEvent e;
  e.kind = Kind::kMove;
  e.x_px = x_px;
  e.y_px = y_px;
  return e;
}

InputEvent button(Kind kind, MouseButton which, bool has_shift = false) {
  InputEvent e;
  e.kind = kind;
  e.button = which;
  e.has_shift = has_shift;
  return e;
}

InputEvent scroll(double steps) {
  InputEvent e;
  e.kind = Kind::kScroll;
  e.scroll_steps = steps;
  return e;
}

void drag(CameraControls& controls, MouseButton which, double dx_px, double dy_px,
          bool has_shift = false) {
  controls.handle(move_to(300, 200));
  controls.handle(button(Kind::kButtonDown, which, has_shift));
  controls.handle(move_to(300 + dx_px, 200 + dy_px));
  controls.handle(button(Kind::kButtonUp, which));
}

double distance(const Camera& c) { return length(c.eye - c.target); }
Vec3f direction(const Camera& c) { return normalize(c.target - c.eye); }
Vec3f right_of(const Camera& c) { return normalize(cross(direction(c), c.up)); }

TEST(CameraControls, StandsAtHomeUntilMoved) {
  CameraControls controls(home_camera(), scene_box());
  controls.handle(move_to(10, 10));
  controls.handle(move_to(90, 50));  // no button down
  controls.advance(1);
  EXPECT_EQ(controls.camera(), home_camera());
  EXPECT_EQ(controls.revision(), 0u);
}

TEST(CameraControls, OrbitKeepsDistanceAndTarget) {
  CameraControls controls(home_camera(), scene_box());
  const double before = distance(controls.camera());
  for (int i = 0; i < 1000; ++i) {
    drag(controls, MouseButton::kLeft, 37, i % 2 == 0 ? 11 : -13);
    ASSERT_NEAR(distance(controls.camera()), before, before * kRelative) << "after drag " << i;
    ASSERT_EQ(controls.camera().target, home_camera().target);
  }
  EXPECT_EQ(controls.revision(), 1000u);
}

TEST(CameraControls, DraggingRightTurnsTheSceneRight) {
  CameraControls controls(home_camera(), scene_box());
  const Vec3f right = right_of(home_camera());
  drag(controls, MouseButton::kLeft, 20, 0);
  EXPECT_LT(dot(controls.camera().eye - home_camera().eye, right), 0);  // the eye goes left
  drag(controls, MouseButton::kLeft, -20, 20);
  EXPECT_GT(controls.camera().eye.y, home_camera().eye.y);  // dragging down lifts the eye
}

TEST(CameraControls, UpNeverFlipsHoweverFarOneDrags) {
  CameraControls controls(home_camera(), scene_box());
  for (const double dy_px : {1e6, -1e6, 300.0, -5000.0, 1e9}) {
    drag(controls, MouseButton::kLeft, 3, dy_px);
    const Camera& c = controls.camera();
    EXPECT_EQ(c.up, home_camera().up);
    EXPECT_TRUE(validate_camera(c).is_ok()) << validate_camera(c).message();
    EXPECT_LT(std::abs(dot(direction(c), c.up)), std::cos(0.9 * 3.14159 / 180));
  }
  // Running into a pole did not change the side on which the scene lies: the eye's horizontal
  // direction is still that of home, but for the few sideways pixels.
  Vec3f level = controls.camera().eye - controls.camera().target,
        home = home_camera().eye - home_camera().target;
  level.y = home.y = 0;
  EXPECT_GT(dot(normalize(level), normalize(home)), 0.9f);
}

TEST(CameraControls, PanKeepsDirectionAndFollowsTheMouse) {
  for (const bool is_middle : {true, false}) {
    CameraControls controls(home_camera(), scene_box());
    controls.set_viewport(640, 480);
    drag(controls, is_middle ? MouseButton::kMiddle : MouseButton::kLeft, 0, 480, !is_middle);
    const Camera& c = controls.camera();
    EXPECT_NEAR(dot(direction(c), direction(home_camera())), 1, 1e-6);
    EXPECT_NEAR(distance(c), distance(home_camera()), 1e-4);
    // A drag over the whole height moves by the height of the target plane, upwards in the scene.
    const double height = 2 * distance(home_camera()) * std::tan(20 * 3.14159265358979 / 180);
    EXPECT_NEAR(length(c.target - home_camera().target), height, height * kRelative);
    EXPECT_GT(c.target.y, home_camera().target.y);
  }
}

TEST(CameraControls, ZoomNeverPassesTheTarget) {
  CameraControls controls(home_camera(), scene_box());
  const Vec3f towards = direction(home_camera());
  double before = distance(controls.camera());
  for (int i = 0; i < 500; ++i) {
    controls.handle(scroll(1));
    const double now = distance(controls.camera());
    ASSERT_LE(now, before);
    ASSERT_GT(dot(direction(controls.camera()), towards), 0.99f) << "after step " << i;
    ASSERT_TRUE(validate_camera(controls.camera()).is_ok());
    before = now;
  }
  controls.handle(scroll(1e30));
  EXPECT_TRUE(validate_camera(controls.camera()).is_ok());
  controls.handle(scroll(-1e30));
  EXPECT_TRUE(validate_camera(controls.camera()).is_ok());
  EXPECT_GT(distance(controls.camera()), distance(home_camera()));
  EXPECT_EQ(controls.camera().target, home_camera().target);
}

TEST(CameraControls, ZoomKeepsEyeAndTargetApartFarFromTheOrigin) {
  const Camera far{{1e6f, 1e6f, 1e6f + 10}, {1e6f, 1e6f, 1e6f}, {0, 1, 0}, 45};
  CameraControls controls(far, Bounds3f{});
  for (int i = 0; i < 300; ++i) controls.handle(scroll(1));
  EXPECT_TRUE(validate_camera(controls.camera()).is_ok());
}

TEST(CameraControls, ResetIsHomeToTheBit) {
  CameraControls controls(home_camera(), scene_box());
  drag(controls, MouseButton::kLeft, 120, 45);
  drag(controls, MouseButton::kMiddle, -40, 300);
  controls.handle(scroll(-4));
  ASSERT_NE(controls.camera(), home_camera());
  const std::uint64_t before = controls.revision();
  EXPECT_EQ(controls.handle(key(Kind::kKeyDown, Key::kR)), ViewerCommand::kNone);
  EXPECT_EQ(controls.camera(), home_camera());
  EXPECT_EQ(controls.revision(), before + 1);
  controls.handle(key(Kind::kKeyDown, Key::kR));
  EXPECT_EQ(controls.revision(), before + 1);
}

TEST(CameraControls, FliesWhileKeysAreDownAndShiftIsFaster) {
  CameraControls slow(home_camera(), scene_box()), fast(home_camera(), scene_box());
  slow.handle(key(Kind::kKeyDown, Key::kW));
  fast.handle(key(Kind::kKeyDown, Key::kW, true));
  EXPECT_TRUE(slow.is_flying());
  slow.advance(0.05);
  fast.advance(0.05);
  const Vec3f slow_step = slow.camera().eye - home_camera().eye;
  const Vec3f fast_step = fast.camera().eye - home_camera().eye;
  EXPECT_NEAR(dot(normalize(slow_step), direction(home_camera())), 1, 1e-5);
  EXPECT_NEAR(length(fast_step), 4 * length(slow_step), 1e-4);
  EXPECT_NEAR(dot(direction(slow.camera()), direction(home_camera())), 1, 1e-6);

  slow.handle(key(Kind::kKeyUp, Key::kW));
  EXPECT_FALSE(slow.is_flying());
  const Camera stopped = slow.camera();
  slow.advance(0.05);
  EXPECT_EQ(slow.camera(), stopped);
}

TEST(CameraControls, FlyKeysGoTheirWays) {
  const struct {
    Key which;
    Vec3f way;
  } cases[] = {{Key::kW, direction(home_camera())},
               {Key::kS, -direction(home_camera())},
               {Key::kD, right_of(home_camera())},
               {Key::kA, -right_of(home_camera())},
               {Key::kE, {0, 1, 0}},
               {Key::kQ, {0, -1, 0}}};
  for (const auto& c : cases) {
    CameraControls controls(home_camera(), scene_box());
    EXPECT_EQ(controls.handle(key(Kind::kKeyDown, c.which)), ViewerCommand::kNone);
    controls.advance(0.05);
    EXPECT_NEAR(dot(normalize(controls.camera().eye - home_camera().eye), c.way), 1, 1e-5);
  }
}

TEST(CameraControls, AStallIsNotALeapAndLostFocusStops) {
  CameraControls stalled(home_camera(), scene_box()), smooth(home_camera(), scene_box());
  stalled.handle(key(Kind::kKeyDown, Key::kW));
  smooth.handle(key(Kind::kKeyDown, Key::kW));
  stalled.advance(3600);
  smooth.advance(CameraControls::kStepSecondsMax);
  EXPECT_EQ(stalled.camera(), smooth.camera());
  stalled.handle(InputEvent{});  // focus lost
  EXPECT_FALSE(stalled.is_flying());
}

TEST(CameraControls, SpeedsGrowWithTheScene) {
  Bounds3f large;
  large.grow(Vec3f{-200, -100, -300});
  large.grow(Vec3f{400, 300, 200});
  CameraControls near(home_camera(), scene_box()), far(home_camera(), large);
  for (CameraControls* c : {&near, &far}) {
    c->handle(key(Kind::kKeyDown, Key::kD));
    c->advance(0.05);
  }
  EXPECT_NEAR(
      length(far.camera().eye - home_camera().eye) / length(near.camera().eye - home_camera().eye),
      100, 0.1);
}

TEST(CameraControls, FitTakesTheScenesOwnAnswer) {
  CameraControls controls(home_camera(), scene_box());
  controls.set_viewport(800, 400);
  controls.handle(button(Kind::kButtonDown, MouseButton::kLeft));
  controls.handle(move_to(10, 10));
  controls.handle(move_to(60, 40));
  Camera asked;
  double aspect = 0;
  const Camera answer{{1, 0.5f, 1}, {1.25f, 0.5f, 1}, {0, 1, 0}, 40};
  controls.set_camera_of_all([&](const Camera& seen, double asked_aspect) {
    asked = seen;
    aspect = asked_aspect;
    return answer;
  });
  const Camera before = controls.camera();
  controls.handle(key(Kind::kKeyDown, Key::kF));
  EXPECT_EQ(asked, before);
  EXPECT_EQ(aspect, 2);
  EXPECT_NEAR(length(controls.camera().eye - answer.eye), 0, kRelative);
  EXPECT_NEAR(length(controls.camera().target - answer.target), 0, kRelative);
}

TEST(CameraControls, FitOfAViewAlongUpStaysValid) {
  CameraControls controls(home_camera(), scene_box());
  controls.set_camera_of_all([](const Camera&, double) {
    return Camera{{0, 5, 0}, {0, 0, 0}, {1, 0, 0}, 40};
  });
  controls.handle(key(Kind::kKeyDown, Key::kF));
  EXPECT_TRUE(validate_camera(controls.camera()).is_ok());
}

TEST(CameraControls, FitShowsTheWholeBox) {
  CameraControls controls(home_camera(), scene_box());
  controls.set_viewport(300, 600);  // the width is the narrow side
  controls.handle(key(Kind::kKeyDown, Key::kF));
  const Camera& c = controls.camera();
  EXPECT_NEAR(dot(direction(c), direction(home_camera())), 1, 1e-6);
  const Vec3f right = right_of(c), up = cross(right, direction(c));
  const double tan_vertical = std::tan(20 * 3.14159265358979 / 180);
  const Bounds3f box = scene_box();
  for (int i = 0; i < 8; ++i) {
    const Vec3f corner{i & 1 ? box.lower.x : box.upper.x, i & 2 ? box.lower.y : box.upper.y,
                       i & 4 ? box.lower.z : box.upper.z};
    const Vec3f v = corner - c.eye;
    const double depth = dot(v, direction(c));
    ASSERT_GT(depth, 0);
    EXPECT_LE(std::abs(dot(v, up)) / depth, tan_vertical);
    EXPECT_LE(std::abs(dot(v, right)) / depth, tan_vertical / 2);
  }
}

TEST(CameraControls, KeysGiveCommands) {
  CameraControls controls(home_camera(), scene_box());
  const auto press = [&](Key which, bool has_control = false) {
    return controls.handle(key(Kind::kKeyDown, which, false, has_control));
  };
  EXPECT_EQ(press(Key::kH), ViewerCommand::kToggleHelp);
  EXPECT_EQ(press(Key::kO), ViewerCommand::kToggleOverlay);
  EXPECT_EQ(press(Key::kT), ViewerCommand::kToggleTint);
  EXPECT_EQ(press(Key::kL), ViewerCommand::kToggleSlaves);
  EXPECT_EQ(press(Key::kEscape), ViewerCommand::kQuit);
  EXPECT_EQ(press(Key::kQ, true), ViewerCommand::kQuit);
  EXPECT_FALSE(controls.is_flying());
  EXPECT_EQ(press(Key::kQ), ViewerCommand::kNone);
  EXPECT_TRUE(controls.is_flying());
}

TEST(CameraControls, AnySequenceOfEventsGivesAValidCamera) {
  constexpr unsigned kSeed = 20240607;
  SCOPED_TRACE(kSeed);
  std::mt19937 random(test::seed(kSeed));
  std::uniform_real_distribution<double> pixels(-2000, 2000), steps(-20, 20), seconds(0, 0.2);
  std::uniform_int_distribution<int> which(0, 9), keys(0, 11);
  CameraControls controls(home_camera(), scene_box());
  for (int i = 0; i < 20000; ++i) {
    const std::uint64_t revision = controls.revision();
    const Camera before = controls.camera();
    switch (which(random)) {
      case 0:
        drag(controls, MouseButton::kLeft, pixels(random), pixels(random));
        break;
      case 1:
        drag(controls, MouseButton::kMiddle, pixels(random), pixels(random));
        break;
      case 2:
        controls.handle(scroll(steps(random)));
        break;
      case 3:
        controls.handle(key(Kind::kKeyUp, static_cast<Key>(keys(random))));
        break;
      case 4:
        controls.handle(key(Kind::kKeyDown, static_cast<Key>(keys(random)), i % 3 == 0));
        break;
      default:
        controls.advance(seconds(random));
    }
    const Camera& c = controls.camera();
    ASSERT_TRUE(validate_camera(c).is_ok())
        << "event " << i << ": " << validate_camera(c).message();
    ASSERT_EQ(c.up, home_camera().up);
    ASSERT_EQ(c == before, controls.revision() == revision) << "event " << i;
  }
}

}  // namespace
}  // namespace tessera::master
