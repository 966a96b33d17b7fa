// SPDX-License-Identifier: Apache-2.0
// Any bytes as the coded pixels of a tile are refused, or fill it; any pixels come back from each
// coding as they went in.
#include <cstdlib>
#include <vector>

#include "common/wire/pixel_coding.h"
#include "tests/fuzz/fuzz_input.h"

namespace {

using namespace tessera;

constexpr wire::ByteCoding kCodings[] = {wire::ByteCoding::kNone, wire::ByteCoding::kLz4,
                                         wire::ByteCoding::kZstd};

void go_and_return(const PixelLayout& layout, const std::vector<std::byte>& pixels) {
  std::vector<std::byte> coded, back(pixels.size());
  for (const wire::ByteCoding coding : {wire::ByteCoding::kLz4, wire::ByteCoding::kZstd}) {
    if (!wire::code_pixels(coding, layout, pixels, coded)) continue;
    if (coded.size() >= pixels.size()) std::abort();
    if (!wire::restore_pixels(coding, layout, coded, back).is_ok()) std::abort();
    if (back != pixels) std::abort();
  }
}

}  // namespace

// The input: coding, format, planes, a count of pixels (two bytes), the coded bytes.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  test::FuzzInput input(data, size);
  const wire::ByteCoding coding = kCodings[input.below(3)];
  const auto format = static_cast<PixelFormat>(input.below(3));
  const PixelLayout layout(format, PlaneSet::of_bits(input.byte() & PlaneSet::all().bits()));
  const std::size_t count = 1 + input.two_bytes() % 4096u;
  wire::TileResult result;
  result.coding = coding;
  result.pixels = input.bytes(size);
  std::vector<std::byte> pixels = result.pixels;
  pixels.resize(pixels.size() / layout.pixel_bytes() * layout.pixel_bytes());
  if (!pixels.empty()) go_and_return(layout, pixels);

  const std::size_t plain_bytes = count * layout.pixel_bytes();
  if (!wire::make_plain(layout, plain_bytes, result).is_ok()) return 0;
  if (result.pixels.size() != plain_bytes) std::abort();
  go_and_return(layout, result.pixels);
  return 0;
}
