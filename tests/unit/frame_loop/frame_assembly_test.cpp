// A frame put together from its tiles: its digest, and what is not a number in it.
#include "master/frame_loop/frame_assembly.h"

#include <gtest/gtest.h>

#include <cstring>
#include <future>

#include "common/net/io_thread.h"
#include "master/frame_loop/outcome_line.h"

namespace tessera::master {
namespace {

FrameSettings settings_of(PixelFormat format) {
  FrameSettings settings;
  settings.width_px = 13;  // odd sizes: components that straddle words
  settings.height_px = 7;
  settings.tile_edge_px = 5;
  settings.pixel_format = format;
  settings.camera = {{0, 0, 5}, {0, 0, 0}, {0, 1, 0}, 45};
  return settings;
}

// How many components of a frame full of `usual`, with `unusual` at one place, are not finite.
template <typename Bits>
std::uint64_t count(PixelFormat format, Bits usual, unsigned unusual, std::size_t place) {
  net::IoThread loop("test-loop");
  FrameAssembly assembly(1, 1, settings_of(format), FrameDigest(loop, nullptr));
  EXPECT_TRUE(assembly.allocate().is_ok());
  for (TileIndex tile = 0; tile < assembly.grid().tile_count(); ++tile) {
    std::vector<std::byte> pixels(assembly.tile_bytes(tile));
    for (std::size_t i = 0; i + sizeof(Bits) <= pixels.size(); i += sizeof(Bits)) {
      const Bits bits = tile == 0 && i / sizeof(Bits) == place ? static_cast<Bits>(unusual) : usual;
      std::memcpy(pixels.data() + i, &bits, sizeof(Bits));
    }
    assembly.write_tile(tile, pixels, 0);
  }
  return assembly.nonfinite_count();
}

TEST(FrameAssembly, WhatIsNotFiniteIsCountedWhereverItStands) {
  for (std::size_t place = 0; place < 75; ++place) {
    for (const unsigned bad : {0x7c00u, 0xfc00u, 0x7e01u, 0xffffu})
      EXPECT_EQ(count<std::uint16_t>(PixelFormat::kHalf, 0x7bff, bad, place), 1u) << place;
    for (const std::uint32_t bad : {0x7f800000u, 0xff800000u, 0x7fc00001u, 0xffffffffu})
      EXPECT_EQ(count<std::uint32_t>(PixelFormat::kFloat, 0x7f7fffff, bad, place), 1u) << place;
  }
  for (const unsigned good : {0x0000u, 0x8000u, 0x0001u, 0x7bffu, 0xfbffu, 0x03ffu, 0x83ffu})
    EXPECT_EQ(count<std::uint16_t>(PixelFormat::kHalf, 0xfbff, good, 3), 0u);
  for (const std::uint32_t good : {0u, 0x80000000u, 1u, 0x7f7fffffu, 0xff7fffffu, 0x007fffffu})
    EXPECT_EQ(count<std::uint32_t>(PixelFormat::kFloat, 0xff7fffff, good, 3), 0u);
}

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
  net::IoThread loop("test-loop"), hasher("test-hash");
  auto image = std::make_shared<FrameImage>();
  for (int i = 0; i < 10'000; ++i) image->bytes.push_back(static_cast<std::byte>(i * 7));
  for (net::EventLoop* at :
       {static_cast<net::EventLoop*>(nullptr), static_cast<net::EventLoop*>(&hasher)}) {
    FrameDigest digest(loop, at);
    for (std::size_t begin = 0; begin < image->bytes.size(); begin += 2500)
      digest.update(image, begin, 2500);
    std::promise<Digest> sum;
    digest.finish([&](const Digest& d) { sum.set_value(d); });
    EXPECT_EQ(sum.get_future().get().hex(), sha256(image->bytes).hex());
  }
}

}  // namespace
}  // namespace tessera::master
