// SPDX-License-Identifier: Apache-2.0
// The table of planes, sets of them, and where their values lie.
#include "common/frame/picture_plane.h"

#include <gtest/gtest.h>

#include <cstring>
#include <set>

#include "common/base/limits.h"
#include "common/frame/frame_image.h"

namespace tessera {
namespace {

TEST(PicturePlane, NamesAndChannelsAreUniqueAndNoneIsColour) {
  std::set<std::string_view> names, channels{"R", "G", "B"};
  PlaneSet::all().for_each([&](Plane plane) {
    const PlaneRow& row = plane_row(plane);
    EXPECT_TRUE(names.insert(row.name).second) << row.name;
    for (std::size_t c = 0; c < row.channels.size(); ++c) {
      EXPECT_EQ(row.channels[c].empty(), c >= row.channel_count()) << row.name;
      if (c < row.channel_count()) {
        EXPECT_TRUE(channels.insert(row.channels[c]).second) << row.name;
      }
    }
  });
  EXPECT_EQ(names.size(), plane_count());
  EXPECT_EQ(channel_count(PlaneSet::all()), channels.size() - 3);
}

TEST(PicturePlane, AreAskedForByName) {
  const auto some = parse_planes("depth,albedo");
  ASSERT_TRUE(some.is_ok());
  EXPECT_EQ(*some, (PlaneSet{Plane::kAlbedo, Plane::kDepth}));
  const auto all = parse_planes("albedo,normal,depth,position,object,material,samples");
  ASSERT_TRUE(all.is_ok());
  EXPECT_EQ(all->bits(), PlaneSet::all().bits() & ~PlaneSet{Plane::kAlpha}.bits());
  EXPECT_EQ(aov_names(), "albedo, normal, depth, position, object, material, samples");
  for (const char* wrong : {"", "depth,", "Depth", "alpha", "depth,depth", "depht", ",", " depth"})
    EXPECT_EQ(parse_planes(wrong).status().code(), StatusCode::kInvalidArgument) << wrong;
  EXPECT_NE(parse_planes("depth,alpha").status().message().find("--background transparent"),
            std::string::npos);
  EXPECT_NE(parse_planes("depht").status().message().find("did you mean 'depth'"),
            std::string::npos);
}

FrameSettings settings_with(PlaneSet planes) {
  FrameSettings settings;
  settings.planes = planes;
  return settings;
}

TEST(PicturePlane, AFrameHasRoomForThemOrIsRefused) {
  FrameSettings settings = settings_with(PlaneSet::all());
  EXPECT_TRUE(validate_frame_settings(settings).is_ok());
  EXPECT_EQ(tile_edge_max_px(settings_with({})), kTileEdgeMaxPx);
  const int most = tile_edge_max_px(settings);
  const auto bytes = [&](int edge) {
    return static_cast<std::size_t>(edge * edge) * PixelLayout(settings).pixel_bytes();
  };
  EXPECT_LE(bytes(most), kTilePayloadBytesMax);
  EXPECT_GT(bytes(most + 8), kTilePayloadBytesMax);
  settings.tile_edge_px = most;
  EXPECT_TRUE(validate_frame_settings(settings).is_ok());
  settings.tile_edge_px = most + 1;
  EXPECT_NE(validate_frame_settings(settings).message().find("tile edge"), std::string::npos);
  settings.tile_edge_px = kTileEdgeAuto;
  EXPECT_TRUE(validate_frame_settings(settings).is_ok());
  settings.width_px = settings.height_px = 7000;
  EXPECT_NE(validate_frame_settings(settings).message().find("MiB"), std::string::npos);
  settings.planes = {};
  settings.width_px = settings.height_px = kImageSideMaxPx;
  EXPECT_TRUE(validate_frame_settings(settings).is_ok());
  settings.planes = PlaneSet::of_bits(PlaneSet::all().bits() + 1);
  EXPECT_FALSE(validate_frame_settings(settings).is_ok());
}

TEST(PicturePlane, LieBehindTheColourOneBehindTheOther) {
  FrameImage image;
  image.width_px = 5;
  image.height_px = 3;
  image.format = PixelFormat::kDisplay8;  // leaves the floats unaligned
  image.planes = {Plane::kNormal, Plane::kAlpha, Plane::kSamples};
  EXPECT_EQ(image.layout().pixel_bytes(), 3u + 4 * (1 + 3 + 1));
  image.bytes.resize(image.pixel_count() * image.layout().pixel_bytes());
  std::vector<float> written;
  for (int i = 0; i < 15 * 5; ++i) written.push_back(static_cast<float>(i));
  std::memcpy(image.bytes.data() + image.colour().size(), written.data(), 4 * written.size());
  EXPECT_EQ(image.colour().size(), 45u);
  const auto expected = [&](int first, int count) {
    return std::vector<float>(written.begin() + first, written.begin() + first + count);
  };
  EXPECT_EQ(image.plane_values(Plane::kAlpha), expected(0, 15));
  EXPECT_EQ(image.plane_values(Plane::kNormal), expected(15, 45));
  EXPECT_EQ(image.plane_values(Plane::kSamples), expected(60, 15));
}

}  // namespace
}  // namespace tessera
