// SPDX-License-Identifier: Apache-2.0
#include "master/commands/snapshot_writer.h"

#include <gtest/gtest.h>
#include <sys/stat.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <iterator>
#include <vector>

#include "common/base/mutex.h"
#include "master/image/image_read.h"
#include "tests/support/temp_folder.h"

namespace tessera::master {
namespace {

std::shared_ptr<const FrameImage> picture() {
  auto image = std::make_shared<FrameImage>();
  image->width_px = 2;
  image->height_px = 1;
  image->format = PixelFormat::kHalf;
  const std::vector<float> rgb{0.25f, 0.5f, 1, 2, 4, 1000};
  image->bytes.resize(6 * 2);
  encode_pixels(rgb, image->format, image->bytes);
  return image;
}

// Saves `count` pictures, one after the other. Returns: the lines that were reported.
std::vector<std::string> saved(const std::string& stem, std::size_t count) {
  std::vector<std::string> lines;
  Mutex mutex;
  CondVar changed;
  {
    SnapshotWriter writer(stem, [&](const std::string& line) {
      MutexLock lock(mutex);
      lines.push_back(line);
      changed.notify_all();
    });
    for (std::size_t i = 0; i < count; ++i) {
      EXPECT_TRUE(writer.save(picture(), "2x1"));
      MutexLock lock(mutex);
      while (lines.size() <= i) changed.wait(mutex);
    }
  }
  return lines;
}

std::string text_of(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

std::size_t files_in(const std::string& folder) {
  return static_cast<std::size_t>(std::distance(std::filesystem::directory_iterator(folder), {}));
}

TEST(SnapshotWriter, PicturesAreNumberedAndHoldThePixels) {
  const test::TempFolder folder;
  const std::vector<std::string> lines = saved(folder / "room", 2);
  ASSERT_EQ(lines.size(), 2u);
  EXPECT_EQ(lines[0],
            "saved " + folder / "room-0001.exr" + " and " + folder / "room-0001.png" + " (2x1)");
  EXPECT_EQ(files_in(folder.path()), 4u);
  const auto image = read_image(folder / "room-0002.exr");
  ASSERT_TRUE(image.is_ok()) << image.status().message();
  EXPECT_EQ(image->rgb, (std::vector<float>{0.25f, 0.5f, 1, 2, 4, 1000}));
}

TEST(SnapshotWriter, NothingIsEverOverwritten) {
  const test::TempFolder folder;
  folder.write("room-0001.png", "mine");
  folder.write("room-0003.exr", "mine, too");
  ASSERT_EQ(::symlink("nowhere", (folder / "room-0004.png").c_str()), 0);
  const std::vector<std::string> lines = saved(folder / "room", 2);
  ASSERT_EQ(lines.size(), 2u);
  EXPECT_NE(lines[0].find("room-0002.exr"), std::string::npos) << lines[0];
  EXPECT_NE(lines[1].find("room-0005.exr"), std::string::npos) << lines[1];
  EXPECT_EQ(text_of(folder / "room-0001.png"), "mine");
  EXPECT_EQ(text_of(folder / "room-0003.exr"), "mine, too");
  EXPECT_FALSE(std::filesystem::exists(folder / "room-0001.exr")) << "pairs stay together";
  EXPECT_FALSE(std::filesystem::exists(folder / "nowhere"));
}

TEST(SnapshotWriter, AFolderThatCannotBeWrittenIsSaidAndTriedAgain) {
  const test::TempFolder folder;
  const std::vector<std::string> lines = saved(folder / "gone/room", 1);
  ASSERT_EQ(lines.size(), 1u);
  EXPECT_EQ(lines[0], "the picture was not saved: cannot write " + folder / "gone/room-0001.exr" +
                          ": No such file or directory");
  EXPECT_EQ(files_in(folder.path()), 0u);
}

TEST(SnapshotWriter, TheNameIsThatOfTheScene) {
  EXPECT_EQ(snapshot_stem("builtin:room"), "room");
  EXPECT_EQ(snapshot_stem("some where/flight.helmet.glb"), "flight.helmet");
  EXPECT_EQ(snapshot_stem("/"), "picture");
  EXPECT_EQ(snapshot_stem(".."), "picture") << "no hidden file";
}

}  // namespace
}  // namespace tessera::master
