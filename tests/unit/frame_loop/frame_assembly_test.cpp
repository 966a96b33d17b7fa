// A frame put together from its tiles: its digest, and what is not a number in it.
#include "master/frame_loop/frame_assembly.h"

#include <gtest/gtest.h>

#include <cstring>

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
std::uint64_t count(PixelFormat format, Bits usual, Bits unusual, std::size_t place) {
  FrameAssembly assembly(1, 1, settings_of(format));
  EXPECT_TRUE(assembly.allocate().is_ok());
  for (TileIndex tile = 0; tile < assembly.grid().tile_count(); ++tile) {
    std::vector<std::byte> pixels(assembly.tile_bytes(tile));
    for (std::size_t i = 0; i + sizeof(Bits) <= pixels.size(); i += sizeof(Bits)) {
      const Bits bits = tile == 0 && i / sizeof(Bits) == place ? unusual : usual;
      std::memcpy(pixels.data() + i, &bits, sizeof(Bits));
    }
    assembly.write_tile(tile, pixels, 0);
  }
  return assembly.nonfinite_count();
}

TEST(FrameAssembly, WhatIsNotFiniteIsCountedWhereverItStands) {
  for (std::size_t place = 0; place < 75; ++place) {
    for (const std::uint16_t bad : {0x7c00, 0xfc00, 0x7e01, 0xffff})
      EXPECT_EQ(count<std::uint16_t>(PixelFormat::kHalf, 0x7bff, bad, place), 1u) << place;
    for (const std::uint32_t bad : {0x7f800000u, 0xff800000u, 0x7fc00001u, 0xffffffffu})
      EXPECT_EQ(count<std::uint32_t>(PixelFormat::kFloat, 0x7f7fffff, bad, place), 1u) << place;
  }
  for (const std::uint16_t good : {0x0000, 0x8000, 0x0001, 0x7bff, 0xfbff, 0x03ff, 0x83ff})
    EXPECT_EQ(count<std::uint16_t>(PixelFormat::kHalf, 0xfbff, good, 3), 0u);
  for (const std::uint32_t good : {0u, 0x80000000u, 1u, 0x7f7fffffu, 0xff7fffffu, 0x007fffffu})
    EXPECT_EQ(count<std::uint32_t>(PixelFormat::kFloat, 0xff7fffff, good, 3), 0u);
}

}  // namespace
}  // namespace tessera::master
