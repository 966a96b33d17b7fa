// SPDX-License-Identifier: Apache-2.0
// A new plane of a picture is a row, a value, a test and the line that builds it: nothing between
// the command line and the file knows it by name. It travels from slaves over the real protocol,
// coded or not, and is averaged and written like any other.
#include <gtest/gtest.h>

#include <cstring>

#include "common/frame/pixel_layout.h"
#include "common/wire/pixel_coding.h"
#include "master/image/file_channels.h"
#include "master/image/pass_mean.h"
#include "master/session/session.h"
#include "tests/support/patience.h"
#include "tests/support/test_meshes.h"

namespace tessera {
namespace {

std::shared_ptr<const FrameImage> picture(int slaves, PlaneSet planes) {
  SessionOptions options;
  options.local_slaves = slaves;
  options.local_threads = slaves;
  auto session = Session::open(options);
  EXPECT_TRUE(session.is_ok());
  Scene scene = test::make_scene(test::make_icosphere(4));
  scene.environment = {1, 1, 1};
  EXPECT_TRUE((*session)->commit_scene(scene).is_ok());
  FrameSettings settings;
  settings.width_px = settings.height_px = 65;
  settings.camera = {{0, 0, 4}, {0, 0, 0}, {0, 1, 0}, 40};
  settings.tile_edge_px = 16;
  settings.planes = planes;
  EXPECT_TRUE((*session)->submit(settings).is_ok());
  auto result = (*session)->next_frame(test::kPatience);
  EXPECT_TRUE(result.is_ok() && result->status.is_ok());
  EXPECT_EQ(result->image->digest(), result->stats.digest);
  return result->image;
}

TEST(ExamplePlane, IsAskedForByNameAndComesFromTheSlaves) {
  const auto asked = parse_planes("facing,samples");
  ASSERT_TRUE(asked.is_ok());
  const Plane facing = static_cast<Plane>(kPlaneRows.size());
  ASSERT_TRUE(asked->has(facing));
  const auto one = picture(1, *asked), three = picture(3, *asked);
  EXPECT_EQ(one->digest(), three->digest());
  const std::vector<float> values = one->plane_values(facing);
  EXPECT_NEAR(values[65 * 32 + 32], 1, 0.01f) << "the middle of the sphere faces the camera";
  EXPECT_EQ(values[0], 0) << "nothing is met in the corner";
  EXPECT_EQ(one->plane_values(Plane::kSamples), std::vector<float>(65 * 65, 1.0f));
}

TEST(ExamplePlane, IsCodedAveragedAndWrittenLikeAnyOther) {
  const Plane facing = static_cast<Plane>(kPlaneRows.size());
  const auto image = picture(2, {facing});
  std::vector<std::byte> coded, again(image->bytes.size());
  ASSERT_TRUE(wire::code_pixels(wire::ByteCoding::kZstd, image->layout(), image->bytes, coded));
  ASSERT_TRUE(wire::restore_pixels(wire::ByteCoding::kZstd, image->layout(), coded, again).is_ok());
  EXPECT_TRUE(std::equal(again.begin(), again.end(), image->bytes.begin(), image->bytes.end()));
  master::PassMean mean;
  mean.add(*image);
  mean.add(*image);
  EXPECT_EQ(mean.image().plane_values(facing), image->plane_values(facing));
  auto file = master::file_channels(*image, ".exr", false, {});
  ASSERT_TRUE(file.is_ok());
  ASSERT_EQ(file->channels().size(), 4u);
  EXPECT_STREQ(file->channels()[3].name, "facing");
  float middle = 0;
  std::memcpy(&middle, file->rows(32, 1).data() + 32 * 16 + 12, sizeof(middle));
  EXPECT_EQ(middle, image->plane_values(facing)[65 * 32 + 32]);
  EXPECT_FALSE(master::file_channels(*image, ".png", false, {}).is_ok());
}

}  // namespace
}  // namespace tessera
