// SPDX-License-Identifier: Apache-2.0
#include "common/frame/frame_settings.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <limits>

#include "common/base/limits.h"

namespace tessera {
namespace {

TEST(FrameSettings, DefaultsAreValid) {
  EXPECT_TRUE(validate_frame_settings(FrameSettings{}).is_ok());
}

TEST(FrameSettings, WhatIsOutOfRangeIsNamed) {
  const struct {
    const char* word;
    std::function<void(FrameSettings&)> spoil;
  } cases[] = {
      {"width", [](FrameSettings& s) { s.width_px = 0; }},
      {"width", [](FrameSettings& s) { s.width_px = kImageSideMaxPx + 1; }},
      {"height", [](FrameSettings& s) { s.height_px = -1; }},
      {"tile", [](FrameSettings& s) { s.tile_edge_px = kTileEdgeMinPx - 1; }},
      {"exposure", [](FrameSettings& s) { s.display.exposure_ev = 65; }},
      {"exposure", [](FrameSettings& s) { s.display.exposure_ev = std::nanf(""); }},
      {"tone", [](FrameSettings& s) { s.display.tone = static_cast<ToneCurve>(4); }},
      {"method", [](FrameSettings& s) { s.patch_method = static_cast<PatchMethod>(5); }},
      {"tile", [](FrameSettings& s) { s.tile_edge_px = kTileEdgeMaxPx + 1; }},
      {"samples", [](FrameSettings& s) { s.samples_per_pixel = 0; }},
      {"light", [](FrameSettings& s) { s.light_samples = kLightSamplesMax + 1; }},
      {"bounces", [](FrameSettings& s) { s.bounces = -1; }},
      {"bounces", [](FrameSettings& s) { s.bounces = kBouncesMax + 1; }},
      {"vpls", [](FrameSettings& s) { s.vpls = 0; }},
      {"vpls", [](FrameSettings& s) { s.vpls = kVplsMax + 1; }},
      {"interleave", [](FrameSettings& s) { s.interleave = 2; }},
      {"clamp", [](FrameSettings& s) { s.clamp = -2; }},
      {"clamp", [](FrameSettings& s) { s.clamp = std::numeric_limits<float>::quiet_NaN(); }},
      {"pass", [](FrameSettings& s) { s.pass = kPassesMax; }},
      {"camera", [](FrameSettings& s) { s.camera.target = s.camera.eye; }},
      {"camera", [](FrameSettings& s) { s.camera.up = s.camera.target - s.camera.eye; }},
      {"camera", [](FrameSettings& s) { s.camera.vfov_degrees = 180; }},
      {"camera",
       [](FrameSettings& s) { s.camera.vfov_degrees = std::numeric_limits<float>::quiet_NaN(); }},
      {"camera", [](FrameSettings& s) { s.camera.eye.y = std::numeric_limits<float>::infinity(); }},
  };
  for (const auto& c : cases) {
    FrameSettings settings;
    c.spoil(settings);
    const Status status = validate_frame_settings(settings);
    EXPECT_EQ(status.code(), StatusCode::kInvalidArgument) << c.word;
    EXPECT_NE(status.message().find(c.word), std::string::npos) << status.message();
  }
}

TEST(FrameSettings, NamesParseBack) {
  for (const Renderer r : {Renderer::kPrimary, Renderer::kDirect, Renderer::kPath}) {
    auto parsed = parse_renderer(renderer_name(r));
    ASSERT_TRUE(parsed.is_ok());
    EXPECT_EQ(*parsed, r);
  }
  for (const PixelFormat f : {PixelFormat::kFloat, PixelFormat::kHalf, PixelFormat::kDisplay8}) {
    auto parsed = parse_pixel_format(pixel_format_name(f));
    ASSERT_TRUE(parsed.is_ok());
    EXPECT_EQ(*parsed, f);
  }
  for (const PatchMethod m : kPatchMethods) {
    auto parsed = parse_patch_method(patch_method_name(m));
    ASSERT_TRUE(parsed.is_ok());
    EXPECT_EQ(*parsed, m);
    EXPECT_EQ(patch_method_error(m) == "none", m == PatchMethod::kAuto);
    const bool is_told = patch_method_help().find(patch_method_error(m)) != std::string::npos;
    EXPECT_TRUE(is_told || m == PatchMethod::kAuto) << patch_method_name(m);
  }
  const Status unknown = parse_patch_method("newtn").status();
  EXPECT_EQ(unknown.message(),
            "--patch-method newtn: give auto, refine, newton, krawczyk or clip; did you mean "
            "'newton'?");
  EXPECT_FALSE(parse_patch_method("").is_ok());
  EXPECT_FALSE(parse_renderer("radiosity").is_ok());
  EXPECT_FALSE(parse_pixel_format("").is_ok());
}

}  // namespace
}  // namespace tessera
