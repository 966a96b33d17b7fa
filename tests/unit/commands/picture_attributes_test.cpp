// SPDX-License-Identifier: Apache-2.0
// The attributes of a picture's file suffice to render it again. A picture for a display is
// compared with what the display would show.
#include "master/commands/picture_attributes.h"

#include <gtest/gtest.h>

#include <map>

#include "common/scene_io/camera_file.h"

namespace tessera::master {
namespace {

TEST(PictureAttributes, HoldCameraSettingsSeedSamplesVersionAndTime) {
  FrameSettings settings;
  settings.camera = {{0.1f, 1, 2}, {0, 0.5f, 0}, {0, 1, 0}, 40};
  settings.renderer = Renderer::kPath;
  settings.samples_per_pixel = 4;
  settings.seed = 7;
  settings.display = {-1.5f, ToneCurve::kAces};
  std::map<std::string, std::string> of;
  for (const auto& [name, value] : picture_attributes("a.glb", settings, 3, 0.25)) of[name] = value;
  EXPECT_EQ(of.at("tessera:scene"), "a.glb");
  EXPECT_EQ(of.at("tessera:seed"), "7");
  EXPECT_EQ(of.at("tessera:samples"), "12");
  EXPECT_EQ(of.at("tessera:render_seconds"), "0.25");
  EXPECT_EQ(of.at("tessera:exposure"), "-1.5");
  EXPECT_EQ(of.at("tessera:tone"), "aces");
  EXPECT_EQ(of.at("tessera:settings"),
            "--renderer path --size 640x480 --aa 4 --light-samples 4 --bounces 4");
  EXPECT_EQ(of.count("tessera:patch_error"), 0u);
  settings.patch_method = PatchMethod::kClip;
  for (const auto& [name, value] : picture_attributes("a.glb", settings, 3, 0.25)) of[name] = value;
  EXPECT_TRUE(of.at("tessera:settings").ends_with(" --patch-method clip"));
  EXPECT_EQ(of.at("tessera:patch_error"), patch_method_error(PatchMethod::kClip));
  const auto camera = parse_camera_text(of.at("tessera:camera"));
  ASSERT_TRUE(camera.is_ok());
  EXPECT_EQ(*camera, settings.camera);
  EXPECT_TRUE(of.at("Software").starts_with("Tessera "));
}

TEST(PictureAttributes, APictureIsSeenAsTheFileShowsItsOwn) {
  const std::vector<float> rgb{0.1f, 0.5f, 4, 0, 1, 0.25f};
  FloatImage reference;
  reference.attributes = {{"tessera:exposure", "-1"}, {"tessera:tone", "filmic"}};
  EXPECT_EQ(seen_like(reference, rgb), rgb) << "linear files are compared as they are";
  reference.is_display = true;
  const Vec3f shown = displayed({0.1f, 0.5f, 4}, {-1, ToneCurve::kFilmic});
  const std::vector<float> seen = seen_like(reference, rgb);
  EXPECT_EQ(seen[0], shown.x);
  EXPECT_EQ(seen[2], shown.z);
  for (const char* wrong : {"", "x", "1e9", "nan"}) {
    reference.attributes["tessera:exposure"] = wrong;
    EXPECT_EQ(seen_like(reference, rgb), rgb) << wrong;
  }
}

}  // namespace
}  // namespace tessera::master
