// SPDX-License-Identifier: Apache-2.0
// Prints the table of common/wire/README.md: how much each coding leaves of a frame's tiles and how
// fast it is on one thread. The frames are files of `tessera-master render -o FRAME.pfm --pixels
// float`.
//
// Usage: coding_table FRAME.pfm...
#include <algorithm>
#include <cstdio>
#include <memory>
#include <string>
#include <vector>

#include "common/base/clock.h"
#include "common/frame/frame_image.h"
#include "common/wire/pixel_coding.h"

namespace tessera {
namespace {

constexpr int kEdgePx = 32;
constexpr int kRepeats = 5;  // the fastest counts

struct Picture {
  int width_px = 0, height_px = 0;
  std::vector<float> rgb;
};

bool read_pfm(const char* path, Picture& picture) {
  const std::unique_ptr<std::FILE, int (*)(std::FILE*)> file(std::fopen(path, "rb"), &std::fclose);
  float scale = 0;
  if (!file ||
      std::fscanf(file.get(), "PF %d %d %f", &picture.width_px, &picture.height_px, &scale) != 3) {
    return false;
  }
  std::fgetc(file.get());
  picture.rgb.resize(std::size_t{3} * static_cast<std::size_t>(picture.width_px) *
                     static_cast<std::size_t>(picture.height_px));
  return std::fread(picture.rgb.data(), sizeof(float), picture.rgb.size(), file.get()) ==
         picture.rgb.size();
}

using Tiles = std::vector<std::vector<std::byte>>;

Tiles tiles_of(const Picture& picture, PixelFormat format) {
  const auto pixel_bytes = static_cast<std::size_t>(bytes_per_pixel(format));
  const auto width = static_cast<std::size_t>(picture.width_px);
  Tiles tiles;
  for (int y = 0; y < picture.height_px; y += kEdgePx) {
    for (int x = 0; x < picture.width_px; x += kEdgePx) {
      std::vector<std::byte>& tile = tiles.emplace_back();
      const auto across = static_cast<std::size_t>(std::min(kEdgePx, picture.width_px - x));
      for (int row = y; row < std::min(y + kEdgePx, picture.height_px); ++row) {
        const std::size_t at = static_cast<std::size_t>(row) * width + static_cast<std::size_t>(x);
        const std::span<const float> rgb(picture.rgb.data() + 3 * at, 3 * across);
        tile.resize(tile.size() + across * pixel_bytes);
        encode_pixels(rgb, format, std::span(tile).last(across * pixel_bytes));
      }
    }
  }
  return tiles;
}

void print_row(const Tiles& tiles, PixelFormat format, wire::ByteCoding coding, bool is_arranged) {
  std::size_t plain_bytes = 0, coded_bytes = 0;
  double code_seconds = 1e9, restore_seconds = 1e9;
  std::vector<std::byte> out, back;
  for (int repeat = 0; repeat < kRepeats; ++repeat) {
    plain_bytes = coded_bytes = 0;
    double coding_took = 0, restoring_took = 0;
    for (const std::vector<std::byte>& tile : tiles) {
      const TimePoint began = Clock::now();
      const bool is_smaller = is_arranged ? wire::code_pixels(coding, format, tile, out)
                                          : wire::code_bytes(coding, tile, out);
      const TimePoint coded = Clock::now();
      back.resize(tile.size());
      if (is_smaller) {
        const Status status = is_arranged ? wire::restore_pixels(coding, format, out, back)
                                          : wire::decode_bytes(coding, out, back);
        if (!status.is_ok() || back != tile) std::puts("WRONG");
      }
      restoring_took += seconds(Clock::now() - coded);
      coding_took += seconds(coded - began);
      plain_bytes += tile.size();
      coded_bytes += is_smaller ? out.size() : tile.size();
    }
    code_seconds = std::min(code_seconds, coding_took);
    restore_seconds = std::min(restore_seconds, restoring_took);
  }
  const double plain = static_cast<double>(plain_bytes);
  std::printf(" %.3f, %.0f, %.0f |", static_cast<double>(coded_bytes) / plain,
              1e-6 * plain / code_seconds, 1e-6 * plain / restore_seconds);
}

int run(int argc, char** argv) {
  std::vector<Picture> pictures(static_cast<std::size_t>(std::max(argc - 1, 0)));
  std::printf("| format | coding: share left, MB/s coded, MB/s restored |");
  for (int i = 1; i < argc; ++i) {
    if (!read_pfm(argv[i], pictures[static_cast<std::size_t>(i - 1)])) {
      std::fprintf(stderr, "coding_table: %s is not a colour PFM\n", argv[i]);
      return 1;
    }
    std::printf(" %s |", argv[i]);
  }
  std::puts("");
  for (const PixelFormat format :
       {PixelFormat::kFloat, PixelFormat::kHalf, PixelFormat::kDisplay8}) {
    for (const bool is_arranged : {false, true}) {
      for (const wire::ByteCoding coding : {wire::ByteCoding::kLz4, wire::ByteCoding::kZstd}) {
        std::printf("| %d bytes a pixel | %s%s |", bytes_per_pixel(format),
                    is_arranged ? "arranged, " : "", wire::coding_name(coding));
        for (const Picture& picture : pictures) {
          print_row(tiles_of(picture, format), format, coding, is_arranged);
        }
        std::puts("");
      }
    }
  }
  return 0;
}

}  // namespace
}  // namespace tessera

int main(int argc, char** argv) { return tessera::run(argc, argv); }
