// SPDX-License-Identifier: Apache-2.0
// How much a scene's pictures may decode to, all together: a count of texels, and bytes in
// proportion to those of their files. So a few kilobytes of zeros do not become gigabytes.
// Threads. One at a time.
#pragma once

#include <cstdint>
#include <string>

#include "common/base/status.h"

namespace tessera::master {

// 8 GiB of 8-bit RGBA, as much as one block of a scene may have: 128 pictures of 4096 x 4096.
inline constexpr std::uint64_t kTexelsMax = std::uint64_t{1} << 31;
// Deflate gains up to 1032 on constant bytes, photographs decode to 5 to 30 times their files; a
// mask in few colours to 200. Beside that so many bytes are free: one constant picture of 8192 x
// 8192 is not worth a word.
inline constexpr std::uint64_t kDecodedRatioMax = 200;
inline constexpr std::uint64_t kDecodedBytesFree = std::uint64_t{256} << 20;

class PictureBudget {
 public:
  // Books a picture before it is decoded. Returns: kResourceExhausted, worded to follow the
  // picture's name; then nothing is booked.
  Status book(std::uint64_t file_bytes, std::uint64_t texels, std::uint64_t decoded_bytes);

 private:
  std::uint64_t file_bytes_ = 0, texels_ = 0, decoded_bytes_ = 0;
};

}  // namespace tessera::master
