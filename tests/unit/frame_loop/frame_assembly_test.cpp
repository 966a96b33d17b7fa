// SPDX-License-Identifier: Apache-2.0
// Frames leave in order, each when its digest is known.
#include <gtest/gtest.h>

#include <optional>

#include "master/frame_loop/frame_assembly.h"
#include "master/frame_loop/outcome_line.h"
#include "tests/support/task_loop.h"

namespace tessera::master {
namespace {

FrameOutcome outcome_of(FrameId frame) {
  FrameOutcome outcome;
  outcome.frame = frame;
  return outcome;
}

TEST(OutcomeLine, OneThatWaitsForItsDigestHoldsUpThoseBehindIt) {
  OutcomeLine line;
  std::vector<FrameId> out;
  line.set_exit([&](const FrameOutcome& outcome) { out.push_back(outcome.frame); });
  const auto first = line.add_waiting(outcome_of(1));
  const auto second = line.add_waiting(outcome_of(2));
  line.add(outcome_of(3));
  line.digest_done(second, Digest());
  EXPECT_TRUE(out.empty());
  line.digest_done(first, Digest());
  EXPECT_EQ(out, (std::vector<FrameId>{1, 2, 3}));
  line.add(outcome_of(4));
  EXPECT_EQ(out.size(), 4u);
}

TEST(OutcomeLine, WhatWaitsAtTheEndLeavesAsFailedAndOnce) {
  OutcomeLine line;
  std::vector<StatusCode> out;
  line.set_exit([&](const FrameOutcome& outcome) { out.push_back(outcome.status.code()); });
  const auto ticket = line.add_waiting(outcome_of(1));
  line.add(outcome_of(2));
  line.end(Status::closed("over"));
  line.digest_done(ticket, Digest());
  EXPECT_EQ(out, (std::vector<StatusCode>{StatusCode::kClosed, StatusCode::kOk}));
}

TEST(FrameDigest, IsTheSameAtOnceAndBesideTheLoop) {
  test::TaskLoop loop, hasher;
  auto image = std::make_shared<FrameImage>();
  for (int i = 0; i < 10'000; ++i) image->bytes.push_back(static_cast<std::byte>(i * 7));
  for (net::EventLoop* at :
       {static_cast<net::EventLoop*>(nullptr), static_cast<net::EventLoop*>(&hasher)}) {
    FrameDigest digest(loop, at);
    for (std::size_t begin = 0; begin < image->bytes.size(); begin += 2500)
      digest.update(image, begin, 2500);
    std::optional<Digest> sum;
    digest.finish([&](const Digest& d) { sum = d; });
    test::run_until_idle({&loop, &hasher});
    ASSERT_TRUE(sum);
    EXPECT_EQ(sum->hex(), sha256(image->bytes).hex());
  }
}

// A tile may be written again after its band was whole, when a third slave outvotes the first. The
// audit of the last one here is waived.
TEST(FrameAssembly, TheDigestIsThatOfThePixelsWrittenLast) {
  test::TaskLoop loop, hasher;
  FrameSettings settings;
  settings.width_px = 32;
  settings.height_px = 24;
  settings.tile_edge_px = 16;
  settings.pixel_format = PixelFormat::kFloat;
  FrameAssembly assembly(1, 1, settings, FrameDigest(loop, &hasher));
  ASSERT_TRUE(assembly.allocate().is_ok());
  const auto write = [&](TileIndex tile, int value) {
    assembly.write_tile(tile, std::vector(assembly.tile_bytes(tile), static_cast<std::byte>(value)),
                        0);
  };
  for (TileIndex tile = 0; tile < assembly.grid().tile_count(); ++tile) write(tile, 1);
  for (const TileIndex tile : {1, 2}) assembly.settle_tile(tile);
  test::run_until_idle({&loop, &hasher});  // what is settled is hashed
  write(0, 2);
  assembly.settle_tile(0);
  test::run_until_idle({&loop, &hasher});
  write(3, 3);  // and nobody compares it any more
  FrameDigest digest = assembly.take_digest();
  const auto image = assembly.finish();
  std::optional<Digest> sum;
  digest.finish([&](const Digest& d) { sum = d; });
  test::run_until_idle({&loop, &hasher});
  ASSERT_TRUE(sum);
  EXPECT_EQ(sum->hex(), sha256(image->bytes).hex());
  EXPECT_EQ(image->bytes.front(), std::byte{2});
  EXPECT_EQ(image->bytes.back(), std::byte{3});
}

// Tiles of a frame with planes hold them one behind the other, and so does the frame.
TEST(FrameAssembly, PlanesOfTilesBecomePlanesOfTheFrame) {
  test::TaskLoop loop, hasher;
  FrameSettings settings;
  settings.width_px = 37;
  settings.height_px = 21;
  settings.tile_edge_px = 16;
  settings.pixel_format = PixelFormat::kHalf;
  settings.planes = {Plane::kNormal, Plane::kDepth};
  FrameAssembly assembly(1, 1, settings, FrameDigest(loop, &hasher));
  ASSERT_TRUE(assembly.allocate().is_ok());
  const auto value = [](int x, int y, int channel) {
    return static_cast<float>((y * 37 + x) * 4 + channel);
  };
  for (TileIndex tile = 0; tile < assembly.grid().tile_count(); ++tile) {
    const TileRect rect = assembly.grid().rect(tile);
    std::vector<float> normal, depth;
    for (int i = 0; i < rect.pixel_count(); ++i) {
      const int x = rect.x_px + i % rect.width_px, y = rect.y_px + i / rect.width_px;
      for (int c = 0; c < 3; ++c) normal.push_back(value(x, y, c));
      depth.push_back(value(x, y, 3));
    }
    std::vector<std::byte> pixels(static_cast<std::size_t>(rect.pixel_count()) * 6,
                                  static_cast<std::byte>(tile));
    for (const std::vector<float>& plane : {normal, depth}) {
      const auto bytes = std::as_bytes(std::span(plane));
      pixels.insert(pixels.end(), bytes.begin(), bytes.end());
    }
    ASSERT_EQ(pixels.size(), assembly.tile_bytes(tile));
    assembly.write_tile(tile, pixels, 0);
    assembly.settle_tile(tile);
  }
  FrameDigest digest = assembly.take_digest();
  const auto image = assembly.finish();
  const std::vector<float> normal = image->plane_values(Plane::kNormal);
  const std::vector<float> depth = image->plane_values(Plane::kDepth);
  for (int y = 0; y < 21; ++y) {
    for (int x = 0; x < 37; ++x) {
      const auto at = static_cast<std::size_t>(y * 37 + x);
      for (int c = 0; c < 3; ++c)
        ASSERT_EQ(normal[3 * at + static_cast<std::size_t>(c)], value(x, y, c));
      ASSERT_EQ(depth[at], value(x, y, 3));
      ASSERT_EQ(image->colour()[6 * at], static_cast<std::byte>(y / 16 * 3 + x / 16));
    }
  }
  std::optional<Digest> sum;
  digest.finish([&](const Digest& d) { sum = d; });
  test::run_until_idle({&loop, &hasher});
  ASSERT_TRUE(sum);
  EXPECT_EQ(sum->hex(), sha256(image->bytes).hex());
}

}  // namespace
}  // namespace tessera::master
