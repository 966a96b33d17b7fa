// SPDX-License-Identifier: Apache-2.0
#include "common/scene_io/confined_path.h"

#include <gtest/gtest.h>

#include <filesystem>

#include "tests/support/temp_folder.h"

namespace tessera {
namespace {

TEST(ConfinedPath, OnlyRegularFilesBelowTheFolderAreFound) {
  const test::TempFolder folder;
  std::filesystem::create_directories(folder / "scene/maps");
  folder.write("secret.png", "x");
  folder.write("scene/maps/a.png", "x");
  std::filesystem::create_symlink(folder / "secret.png", folder / "scene/link.png");
  std::filesystem::create_symlink("maps/a.png", folder / "scene/inside.png");
  std::filesystem::create_symlink("/dev/zero", folder / "scene/device.png");
  const std::string scene = folder / "scene";
  EXPECT_TRUE(confined_path(scene, "maps/a.png").is_ok());
  EXPECT_TRUE(confined_path(scene, "maps/../maps/a.png").is_ok());
  EXPECT_TRUE(confined_path(scene, "inside.png").is_ok());
  for (const std::string& name :
       {std::string("../secret.png"), std::string("maps/../../secret.png"), folder / "secret.png",
        std::string("link.png"), std::string("device.png"), std::string("maps"),
        std::string("file:///etc/passwd"), std::string("gone.png"), std::string()}) {
    EXPECT_FALSE(confined_path(scene, name).is_ok()) << name;
  }
}

}  // namespace
}  // namespace tessera
