// SPDX-License-Identifier: Apache-2.0
#include "master/look/first_look.h"

#include <gtest/gtest.h>

#include <cmath>

#include "master/look/usual_samples.h"

namespace tessera {
namespace {

// A ball of albedo 0.5 in front of the camera.
Scene ball() {
  Scene scene;
  auto mesh = std::make_shared<Mesh>();
  constexpr int kAround = 24, kRows = 12;
  for (int i = 0; i <= kRows; ++i) {
    for (int j = 0; j < kAround; ++j) {
      const float theta = 3.14159265f * static_cast<float>(i) / kRows;
      const float phi = 6.2831853f * static_cast<float>(j) / kAround;
      mesh->positions.push_back(
          {std::sin(theta) * std::cos(phi), std::cos(theta), std::sin(theta) * std::sin(phi)});
    }
  }
  for (std::uint32_t i = 0; i < kRows; ++i) {
    for (std::uint32_t j = 0; j < kAround; ++j) {
      const std::uint32_t a = i * kAround + j, b = i * kAround + (j + 1) % kAround;
      mesh->triangles.push_back({a, b, b + kAround});
      mesh->triangles.push_back({a, b + kAround, a + kAround});
    }
  }
  mesh->materials = {0};
  scene.meshes = {mesh};
  scene.materials.resize(1);
  scene.materials[0].albedo = {0.5f, 0.5f, 0.5f};
  scene.instances.resize(1);
  return scene;
}

class FirstLook : public testing::Test {
 protected:
  FirstLook() {
    SessionOptions options;
    options.local_slaves = 1;
    options.local_threads = 2;
    auto opened = Session::open(options);
    EXPECT_TRUE(opened.is_ok()) << opened.status().message();
    session_ = std::move(*opened);
    settings_.width_px = 96;
    settings_.height_px = 64;
    settings_.camera = {{0, 0, 4}, {0, 0, 0}, {0, 1, 0}, 40};
  }
  Look settle(const Scene& scene, const LookOptions& options = {}) {
    auto look = settle_look(*session_, scene, settings_, options, [] { return false; });
    EXPECT_TRUE(look.is_ok()) << look.status().message();
    return *look;
  }
  // A lamp at infinity whose light comes from `side`.
  static Scene lit_from(Vec3f side, float irradiance) {
    Scene scene = ball();
    scene.lights = {
        {LightKind::kDirectional, {}, -side, {irradiance, irradiance, irradiance}, 1, 0}};
    return scene;
  }

  std::unique_ptr<Session> session_;
  FrameSettings settings_;
};

TEST_F(FirstLook, ASceneWithoutLightGetsTheStudioAndOneLine) {
  const Look look = settle(ball());
  EXPECT_TRUE(look.has_studio);
  EXPECT_NE(look.words.find("studio"), std::string::npos);
  EXPECT_EQ(look.display.exposure_ev, 0) << "the studio is made for it";
  EXPECT_EQ(look.background.kind, BackgroundKind::kGradient);
  Scene scene = ball();
  look.apply(scene);
  EXPECT_TRUE(scene.environment_map);
}

TEST_F(FirstLook, SceneNeverAddsLight) {
  LookOptions options;
  options.light = LightChoice::kScene;
  const Look look = settle(ball(), options);
  EXPECT_FALSE(look.has_studio);
  EXPECT_TRUE(look.words.empty());
  EXPECT_EQ(look.background.kind, BackgroundKind::kSky);
}

TEST_F(FirstLook, ALampInFrontOrAtTheSideIsLightEnough) {
  EXPECT_FALSE(settle(lit_from({0, 0, 1}, 1)).has_studio);
  EXPECT_FALSE(settle(lit_from({1, 0, 0}, 1e-3f)).has_studio) << "how bright it is is no matter";
}

TEST_F(FirstLook, ALampBehindWhatIsSeenIsNot) {
  const Look look = settle(lit_from({0.2f, 0, -1}, 1));
  EXPECT_TRUE(look.has_studio);
  EXPECT_TRUE(look.has_lamps) << "it is added to what there is";
}

TEST_F(FirstLook, ExposureBringsAnyLampToMiddleGrey) {
  const Look dim = settle(lit_from({0, 0, 1}, 0.01f)), bright = settle(lit_from({0, 0, 1}, 640));
  EXPECT_NEAR(dim.display.exposure_ev - bright.display.exposure_ev, std::log2(64000), 0.05);
}

TEST_F(FirstLook, AnExposureThatIsGivenStays) {
  LookOptions options;
  options.exposure_ev = -1.5f;
  options.tone = ToneCurve::kAces;
  const Look look = settle(lit_from({0, 0, 1}, 7), options);
  EXPECT_EQ(look.display, (DisplayTransform{-1.5f, ToneCurve::kAces}));
}

TEST_F(FirstLook, StudioTurnsTheLampsOfTheSceneOff) {
  LookOptions options;
  options.light = LightChoice::kStudio;
  Scene scene = lit_from({0, 0, 1}, 1e6f);
  const Look look = settle(scene, options);
  look.apply(scene);
  EXPECT_TRUE(scene.lights.empty());
  EXPECT_TRUE(scene.environment_map);
}

TEST_F(FirstLook, ABackgroundColourIsShownAsItIsGiven) {
  LookOptions options;
  options.background = BackgroundChoice::kColor;
  options.background_color = {0.2f, 0.25f, 0.3f};
  options.tone = ToneCurve::kAgx;
  const Look look = settle(lit_from({0, 0, 1}, 25), options);
  const Vec3f shown = displayed(look.background.high, look.display);
  EXPECT_NEAR(shown.x, 0.2f, 2e-3f);
  EXPECT_NEAR(shown.y, 0.25f, 2e-3f);
  EXPECT_NEAR(shown.z, 0.3f, 2e-3f);
}

TEST_F(FirstLook, DistancesAreNeitherLitNorExposed) {
  settings_.renderer = Renderer::kPrimary;
  const Look look = settle(ball(), {.exposure_ev = 3.0f, .tone = ToneCurve::kFilmic});
  EXPECT_FALSE(look.has_studio);
  EXPECT_TRUE(look.display.is_plain());
}

TEST_F(FirstLook, IsTheSameWithAnyNumberOfSlavesAndThreads) {
  Scene scene = lit_from({0.4f, 0.5f, 1}, 3);
  settings_.renderer = Renderer::kIgi;
  const Look one = settle(scene);
  SessionOptions options;
  options.local_slaves = 3;
  options.local_threads = 3;
  auto other = Session::open(options);
  ASSERT_TRUE(other.is_ok());
  auto look = settle_look(**other, scene, settings_, {}, [] { return false; });
  ASSERT_TRUE(look.is_ok());
  EXPECT_EQ(look->display, one.display);
  EXPECT_EQ(look->has_studio, one.has_studio);
}

TEST(UsualSamples, MoreWhereSurfacesShineOrHaveHoles) {
  Scene scene;
  scene.materials.resize(2);
  EXPECT_EQ(usual_samples(scene, Renderer::kIgi), 4);
  scene.materials[1].alpha.mode = AlphaMode::kMask;
  EXPECT_EQ(usual_samples(scene, Renderer::kIgi), 16);
  scene.materials[1] = {};
  scene.materials[1].bsdf = BsdfKind::kGlossy;
  EXPECT_EQ(usual_samples(scene, Renderer::kIgi), 16);
  EXPECT_EQ(usual_samples(scene, Renderer::kPath), 64);
  EXPECT_EQ(usual_samples(scene, Renderer::kPrimary), 1);
}

}  // namespace
}  // namespace tessera
