// SPDX-License-Identifier: Apache-2.0
// A file's faults are reported by kind, each kind once with the number of those like it.
#include "common/scene_io/warning_group.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace tessera {
namespace {

using ::testing::ElementsAre;

TEST(WarningGroup, EachKindIsOneLineWithItsCountInTheOrderOfTheFirst) {
  WarningGroup warnings("a.gltf");
  EXPECT_TRUE(warnings.lines().empty());
  warnings.add("roughness", "material 1: roughness is 2");
  warnings.add("texture", "image 0: no such file");
  warnings.add("roughness", "material 2: roughness is 3");
  warnings.add("roughness", "material 3: roughness is 4");
  warnings.add_once("animation", "holds animations");
  warnings.add_once("animation", "holds animations");
  EXPECT_THAT(warnings.lines(),
              ElementsAre("a.gltf: material 1: roughness is 2 (and 2 more like it)",
                          "a.gltf: image 0: no such file", "a.gltf: holds animations"));
}

TEST(WarningGroup, AFileMadeOfNewKindsEndsInOneCount) {
  WarningGroup warnings("a.gltf");
  for (std::size_t i = 0; i < kWarningKindsMax + 5; ++i) warnings.add(std::to_string(i), "text");
  ASSERT_EQ(warnings.lines().size(), kWarningKindsMax + 1);
  EXPECT_EQ(warnings.lines().back(), "a.gltf: and 5 warnings of other kinds");
}

}  // namespace
}  // namespace tessera
