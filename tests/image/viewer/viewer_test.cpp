// SPDX-License-Identifier: Apache-2.0
// The window on a virtual display: what is drawn is read back and compared with the frame that was
// published. run.sh runs this under xvfb-run with software rendering; with a folder as argument,
// the pictures are left there (PPM).
#include "master/display/viewer.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <thread>

#include "common/frame/tile_grid.h"
#include "master/display/picture_layout.h"

namespace tessera::master {
namespace {

constexpr int kWidthPx = 320, kHeightPx = 240, kTilePx = 32;

// Linear gradient: red to the right, green downwards, blue a coarse grid, so that mirrored or
// swapped pictures differ.
std::vector<float> gradient(int width_px, int height_px) {
  std::vector<float> rgb;
  for (int y = 0; y < height_px; ++y) {
    for (int x = 0; x < width_px; ++x) {
      rgb.push_back((static_cast<float>(x) + 0.5f) / static_cast<float>(width_px));
      rgb.push_back((static_cast<float>(y) + 0.5f) / static_cast<float>(height_px));
      rgb.push_back((x / 16 + y / 16) % 2 == 0 ? 0.05f : 0.6f);
    }
  }
  return rgb;
}

std::shared_ptr<const FrameImage> frame_image(PixelFormat format, int width_px = kWidthPx,
                                              int height_px = kHeightPx) {
  auto image = std::make_shared<FrameImage>();
  image->width_px = width_px;
  image->height_px = height_px;
  image->format = format;
  image->tile_edge_px = kTilePx;
  const std::vector<float> rgb = gradient(width_px, height_px);
  image->bytes.resize(rgb.size() / 3 * static_cast<std::size_t>(bytes_per_pixel(format)));
  encode_pixels(rgb, format, image->bytes);
  const TileGrid grid(width_px, height_px, kTilePx);
  for (TileIndex i = 0; i < grid.tile_count(); ++i) {
    image->tile_slave.push_back(static_cast<std::uint16_t>(i % 3));
  }
  return image;
}

ViewerFrame viewer_frame(std::shared_ptr<const FrameImage> image) {
  ViewerFrame frame;
  frame.image = std::move(image);
  frame.stats.frame = 42;
  frame.stats.seconds = 0.02;
  frame.stats.rays.primary = 76800;
  frame.stats.rays.shadow = 307200;
  frame.latency_seconds = 0.034;
  return frame;
}

ClusterStatus three_slaves() {
  ClusterStatus cluster;
  for (const char* name : {"anna", "berta", "clara"}) {
    SlaveStatus slave;
    slave.name = name;
    slave.threads = 8;
    slave.isa = Isa::kAvx2;
    slave.utilisation = 0.97;
    slave.tiles_done = 1234;
    slave.rtt_seconds = 0.0004;
    cluster.slaves.push_back(slave);
  }
  return cluster;
}

ViewerOptions options(int width_px = kWidthPx, int height_px = kHeightPx) {
  ViewerOptions o;
  o.title = "viewer test";
  o.width_px = width_px;
  o.height_px = height_px;
  o.screenshot_path = "shot";
  o.screenshot_after = 1;
  o.shows_overlay = false;
  return o;
}

void keep(const FrameImage& shot) {
  const char* folder = std::getenv("VIEWER_TEST_PICTURES");
  if (folder == nullptr) return;
  const std::string name = testing::UnitTest::GetInstance()->current_test_info()->name();
  std::ofstream file(std::string(folder) + "/" + name + ".ppm", std::ios::binary);
  file << "P6\n" << shot.width_px << " " << shot.height_px << "\n255\n";
  file.write(reinterpret_cast<const char*>(shot.bytes.data()),
             static_cast<std::streamsize>(shot.bytes.size()));
}

// Shows one frame and returns the window as drawn.
FrameImage shot_of(ViewerOptions o, const ViewerFrame& frame,
                   const ClusterStatus& cluster = three_slaves()) {
  FrameImage shot;
  o.save = [&shot](const FrameImage& image, const std::string&) {
    shot = image;
    return Status::ok();
  };
  Result<std::unique_ptr<Viewer>> viewer = Viewer::open(o);
  EXPECT_TRUE(viewer.is_ok()) << viewer.status().message();
  if (!viewer.is_ok()) return shot;
  (*viewer)->publish_status(cluster);
  (*viewer)->publish(frame);
  (*viewer)->run(nullptr);
  EXPECT_TRUE((*viewer)->screenshot_status().is_ok()) << (*viewer)->screenshot_status().message();
  keep(shot);
  return shot;
}

int greatest_difference(const FrameImage& a, const FrameImage& b) {
  EXPECT_EQ(a.bytes.size(), b.bytes.size());
  if (a.bytes.size() != b.bytes.size()) return 255;
  int greatest = 0;
  for (std::size_t i = 0; i < a.bytes.size(); ++i) {
    greatest = std::max(
        greatest, std::abs(std::to_integer<int>(a.bytes[i]) - std::to_integer<int>(b.bytes[i])));
  }
  return greatest;
}

int at(const FrameImage& image, int x, int y, int channel) {
  return std::to_integer<int>(
      image.bytes[static_cast<std::size_t>((y * image.width_px + x) * 3 + channel)]);
}

TEST(ViewerPicture, Display8IsShownToTheBit) {
  const auto image = frame_image(PixelFormat::kDisplay8);
  EXPECT_EQ(greatest_difference(shot_of(options(), viewer_frame(image)), *image), 0);
}

TEST(ViewerPicture, FloatIsEncodedWithinOneStep) {
  const FrameImage shot = shot_of(options(), viewer_frame(frame_image(PixelFormat::kFloat)));
  EXPECT_LE(greatest_difference(shot, *frame_image(PixelFormat::kDisplay8)), 1);
}

TEST(ViewerPicture, HalfIsEncodedWithinOneStep) {
  const FrameImage shot = shot_of(options(), viewer_frame(frame_image(PixelFormat::kHalf)));
  EXPECT_LE(greatest_difference(shot, *frame_image(PixelFormat::kDisplay8)), 1);
}

TEST(ViewerPicture, OddWidthsArePackedRight) {
  const auto image = frame_image(PixelFormat::kDisplay8, 317, 203);
  EXPECT_EQ(greatest_difference(shot_of(options(317, 203), viewer_frame(image)), *image), 0);
}

TEST(ViewerPicture, TintMixesEachTileWithItsSlavesColour) {
  ViewerOptions o = options();
  o.tints_tiles = true;
  const auto image = frame_image(PixelFormat::kDisplay8);
  const FrameImage shot = shot_of(o, viewer_frame(image));
  ASSERT_EQ(shot.bytes.size(), image->bytes.size());
  const int columns = kWidthPx / kTilePx;
  for (int y = 0; y < kHeightPx; ++y) {
    for (int x = 0; x < kWidthPx; ++x) {
      const auto colour =
          slave_colour(static_cast<std::uint16_t>((y / kTilePx * columns + x / kTilePx) % 3));
      for (int c = 0; c < 3; ++c) {
        const float wanted = static_cast<float>(at(*image, x, y, c)) * (1 - kTintWeight) +
                             colour[static_cast<std::size_t>(c)] * 255 * kTintWeight;
        // Three roundings to 8 bits: colour in its texture (weighted), the picture's value, the
        // window's.
        ASSERT_NEAR(static_cast<float>(at(shot, x, y, c)), wanted, 1.5f)
            << x << " " << y << " " << c;
      }
    }
  }
}

// The sRGB-encoded value in [0, 255] of the picture `rgb` (linear), interpolated between the
// middles of its pixels at (x, y), which are counted in its pixels.
double between(const std::vector<float>& rgb, PixelSize size, double x, double y, int channel) {
  const auto pixel = [&](int column, int row) {
    column = std::clamp(column, 0, size.width_px - 1);
    row = std::clamp(row, 0, size.height_px - 1);
    const float linear =
        rgb[static_cast<std::size_t>((row * size.width_px + column) * 3 + channel)];
    return 255.0 * static_cast<double>(srgb_encode(linear));
  };
  const double left = std::floor(x - 0.5), top = std::floor(y - 0.5);
  const double across = x - 0.5 - left, down = y - 0.5 - top;
  const int column = static_cast<int>(left), row = static_cast<int>(top);
  return (1 - down) * ((1 - across) * pixel(column, row) + across * pixel(column + 1, row)) +
         down * ((1 - across) * pixel(column, row + 1) + across * pixel(column + 1, row + 1));
}

TEST(ViewerPicture, LetterboxedAndMagnifiedWithoutBlocks) {
  for (const PixelFormat format : {PixelFormat::kDisplay8, PixelFormat::kFloat}) {
    const auto image = frame_image(format, 100, 80);
    const std::vector<float> rgb = gradient(100, 80);
    const FrameImage shot = shot_of(options(340, 240), viewer_frame(image));
    const PixelRect r = letterbox({100, 80}, {340, 240});
    ASSERT_EQ(r, (PixelRect{20, 0, 300, 240}));
    // Tolerance: half a step of the window's rounding; where the picture has 8 bits, half a step of
    // its own, too.
    const double near = format == PixelFormat::kDisplay8 ? 1.01 : 0.51;
    for (int y = 0; y < 240; ++y) {
      for (int x = 0; x < 340; ++x) {
        const bool is_inside = x >= r.x_px && x < r.x_px + r.width_px;
        for (int c = 0; c < 3; ++c) {
          const double wanted =
              is_inside ? between(rgb, {100, 80}, (x - r.x_px + 0.5) / 3, (y + 0.5) / 3, c) : 26;
          ASSERT_NEAR(at(shot, x, y, c), wanted, near) << x << " " << y << " " << c;
        }
      }
    }
  }
}

// A lamp beside a wall: the light of a pixel that is far beyond white must not be mixed in before
// it is cut off, or lamps would grow by half a pixel of the smaller picture.
TEST(ViewerPicture, LampsDoNotGrowWhenMagnified) {
  FrameImage lamp;
  lamp.width_px = 4;
  lamp.height_px = 1;
  lamp.format = PixelFormat::kFloat;
  const std::vector<float> rgb = {0, 0, 0, 0, 0, 0, 1000, 1000, 1000, 1000, 1000, 1000};
  lamp.bytes.resize(rgb.size() * sizeof(float));
  encode_pixels(rgb, lamp.format, lamp.bytes);
  ViewerFrame frame = viewer_frame(std::make_shared<const FrameImage>(lamp));
  frame.stands_for = {320, 240};
  const FrameImage shot = shot_of(options(), frame);
  // Between the middles of the two pixels in question, at 120 and 200, the value rises evenly.
  for (int x = 120; x < 200; ++x)
    ASSERT_NEAR(at(shot, x, 120, 0), (x + 0.5 - 120) / 80 * 255, 0.51);
}

TEST(ViewerPicture, AReducedFrameFillsThePlaceOfTheWholeOne) {
  ViewerFrame frame = viewer_frame(frame_image(PixelFormat::kDisplay8, 107, 80));
  frame.stands_for = {kWidthPx, kHeightPx};
  const FrameImage shot = shot_of(options(), frame);
  for (int x = 0; x < kWidthPx; ++x) {
    ASSERT_NE(at(shot, x, 0, 2), 26) << x << ": the grey beside a picture";
    ASSERT_NE(at(shot, x, kHeightPx - 1, 2), 26) << x;
  }
}

TEST(ViewerPicture, TheScreenshotWaitsForAWholeFrame) {
  ViewerFrame reduced = viewer_frame(frame_image(PixelFormat::kDisplay8, 80, 60));
  reduced.stands_for = {kWidthPx, kHeightPx};
  reduced.is_full = false;
  const auto whole = frame_image(PixelFormat::kDisplay8);
  FrameImage shot;
  ViewerOptions o = options();
  o.save = [&shot](const FrameImage& image, const std::string&) {
    shot = image;
    return Status::ok();
  };
  auto viewer = Viewer::open(o);
  ASSERT_TRUE(viewer.is_ok()) << viewer.status().message();
  (*viewer)->publish(reduced);
  int asked = 0;
  (*viewer)->run([&] { return ++asked > 20; });  // each turn draws what there is
  EXPECT_FALSE((*viewer)->screenshot_status().is_ok());
  (*viewer)->publish(viewer_frame(whole));
  (*viewer)->run(nullptr);
  EXPECT_EQ(greatest_difference(shot, *whole), 0);
}

TEST(ViewerPicture, OverlayDrawsSomethingAndLeavesTheRest) {
  ViewerOptions o = options(640, 480);
  o.shows_overlay = true;
  const auto image = frame_image(PixelFormat::kDisplay8, 640, 480);
  const FrameImage shot = shot_of(o, viewer_frame(image));
  ASSERT_EQ(shot.bytes.size(), image->bytes.size());
  std::size_t changed = 0;
  for (std::size_t i = 0; i < shot.bytes.size(); ++i) changed += shot.bytes[i] != image->bytes[i];
  EXPECT_GT(changed, 10000u);
  for (int c = 0; c < 3; ++c) EXPECT_EQ(at(shot, 639, 479, c), at(*image, 639, 479, c));
}

TEST(ViewerPicture, ManySlavesAreSummedUpWithinTheWindow) {
  ViewerOptions o = options(640, 480);
  o.shows_overlay = true;
  const auto image = frame_image(PixelFormat::kDisplay8, 640, 480);
  const ViewerFrame frame = viewer_frame(image);
  ClusterStatus cluster = three_slaves();
  const FrameImage few = shot_of(o, frame, cluster);
  for (int i = 0; i < 300; ++i) {
    SlaveStatus slave;
    slave.name = "a-slave-with-a-long-name-" + std::to_string(i);
    slave.threads = 8;
    slave.utilisation = (i % 11) / 10.0;
    slave.prefetch_depth = 24;
    if (i % 7 == 3) slave.state = SlaveState::kWaiting;
    cluster.slaves.push_back(slave);
  }
  const FrameImage many = shot_of(o, frame, cluster);
  EXPECT_GT(greatest_difference(few, many), 50);
  for (int x = 0; x < 640; ++x) {
    for (int c = 0; c < 3; ++c) ASSERT_EQ(at(many, x, 479, c), at(*image, x, 479, c)) << x;
  }
}

TEST(ViewerPicture, AClusterWithoutSlavesIsSeenInTheOverlay) {
  ViewerOptions o = options(640, 480);
  o.shows_overlay = true;
  const ViewerFrame frame = viewer_frame(frame_image(PixelFormat::kDisplay8, 640, 480));
  EXPECT_GT(greatest_difference(shot_of(o, frame), shot_of(o, frame, ClusterStatus{})), 50);
}

TEST(ViewerPicture, ANoticeIsSeenWithoutTheOverlay) {
  const auto image = frame_image(PixelFormat::kDisplay8);
  FrameImage shot;
  ViewerOptions o = options();
  o.save = [&shot](const FrameImage& drawn, const std::string&) {
    shot = drawn;
    return Status::ok();
  };
  auto viewer = Viewer::open(o);
  ASSERT_TRUE(viewer.is_ok()) << viewer.status().message();
  (*viewer)->notify("saved picture-0001.exr and picture-0001.png");
  (*viewer)->publish(viewer_frame(image));
  (*viewer)->run(nullptr);
  EXPECT_GT(greatest_difference(shot, *image), 50);
  for (int c = 0; c < 3; ++c) EXPECT_EQ(at(shot, 300, 20, c), at(*image, 300, 20, c));
  keep(shot);
}

TEST(ViewerPicture, OverlayWithHelpAndLegend) {
  ViewerOptions o = options(640, 480);
  o.shows_overlay = o.tints_tiles = true;
  const ViewerFrame frame = viewer_frame(frame_image(PixelFormat::kHalf, 640, 480));
  const FrameImage without_help = shot_of(o, frame);
  o.shows_help = true;
  EXPECT_GT(greatest_difference(without_help, shot_of(o, frame)), 50);
}

TEST(ViewerLoop, SkipsFramesStopsWhenAskedAndSaysTheView) {
  ViewerOptions o = options();
  o.screenshot_path.clear();
  Result<std::unique_ptr<Viewer>> opened = Viewer::open(o);
  ASSERT_TRUE(opened.is_ok()) << opened.status().message();
  Viewer& viewer = **opened;
  EXPECT_EQ(viewer.view().width_px, kWidthPx);
  EXPECT_EQ(viewer.view().height_px, kHeightPx);
  EXPECT_EQ(viewer.view().camera, o.camera);
  std::atomic<bool> is_done{false};
  std::thread cluster([&] {  // publishes far faster than any window draws; never waits for it
    const auto image = frame_image(PixelFormat::kDisplay8);
    for (int i = 0; i < 2000; ++i) viewer.publish(viewer_frame(image));
    is_done = true;
  });
  viewer.run([&] { return is_done.load(); });
  cluster.join();
  EXPECT_TRUE(is_done);
  EXPECT_TRUE(viewer.screenshot_status().is_ok());
}

TEST(ViewerLoop, AnUnsaveableScreenshotIsReported) {
  ViewerOptions o = options();
  o.save = [](const FrameImage&, const std::string& path) {
    return Status::unavailable(path + ": disk full");
  };
  Result<std::unique_ptr<Viewer>> viewer = Viewer::open(o);
  ASSERT_TRUE(viewer.is_ok()) << viewer.status().message();
  (*viewer)->publish(viewer_frame(frame_image(PixelFormat::kFloat)));
  (*viewer)->run(nullptr);
  EXPECT_EQ((*viewer)->screenshot_status().message(), "shot: disk full");
}

TEST(ViewerLoop, AScreenshotWithoutAWriterIsRefused) {
  EXPECT_EQ(Viewer::open(options()).status().code(), StatusCode::kInvalidArgument);
}

}  // namespace
}  // namespace tessera::master
