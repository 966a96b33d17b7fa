// SPDX-License-Identifier: Apache-2.0
#include "common/scene/scene_stream.h"

#include <gtest/gtest.h>

#include "tests/support/small_scene.h"

namespace tessera {
namespace {

std::vector<std::byte> sample() {
  SceneEncoder encoder;
  return encode_scene_stream(
      {encoder.encode(test::make_small_scene()), {"texture x.png: no such file", "second"}});
}

TEST(SceneStream, RoundTripKeepsBlocksAndWarnings) {
  auto stream = decode_scene_stream(sample());
  ASSERT_TRUE(stream.is_ok()) << stream.status().message();
  EXPECT_EQ(stream->warnings, (std::vector<std::string>{"texture x.png: no such file", "second"}));
  SceneDecoder decoder;
  auto scene = decoder.decode(stream->scene);
  ASSERT_TRUE(scene.is_ok());
  EXPECT_EQ(scene->triangle_count(), test::make_small_scene().triangle_count());
}

TEST(SceneStream, EveryTruncationIsRefused) {
  const std::vector<std::byte> whole = sample();
  for (std::size_t length = 0; length < whole.size(); ++length) {
    EXPECT_FALSE(decode_scene_stream(std::span(whole).first(length)).is_ok()) << length;
  }
}

TEST(SceneStream, BytesBehindTheEndAreRefused) {
  std::vector<std::byte> longer = sample();
  longer.push_back(std::byte{0});
  EXPECT_FALSE(decode_scene_stream(longer).is_ok());
}

TEST(SceneStream, ADamagedBlockDoesNotHaveItsDigest) {
  std::vector<std::byte> damaged = sample();
  damaged.back() ^= std::byte{1};
  EXPECT_FALSE(decode_scene_stream(damaged).is_ok());
}

}  // namespace
}  // namespace tessera
