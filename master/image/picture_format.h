// SPDX-License-Identifier: Apache-2.0
// The formats of pictures that are read, each by its own reader of OpenImageIO and by no other: a
// file must have a suffix of the table and begin as its format does.
//
// Threads. Pure functions but for picture_format_of(), which reads the beginning of a file.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#include "common/base/status.h"

namespace tessera::master {

struct PictureFormat {
  const char* reader;         // OpenImageIO's name
  std::string_view name;      // "a PNG picture", to follow "is"
  std::string_view suffixes;  // each with its dot, commas between
  std::string_view begins;    // the first bytes; empty: `look` decides
  bool (*look)(std::string_view head) = nullptr;

  bool matches(std::string_view head) const {
    return look != nullptr ? look(head) : head.starts_with(begins);
  }
};

// Bytes of a beginning that matches() sees.
inline constexpr std::size_t kPictureHeadBytes = 32;
// Most bytes of a picture file: 16384 x 16384 pixels of 32 bits, hardly compressed.
inline constexpr std::uint64_t kPictureFileBytesMax = std::uint64_t{1} << 30;

// Returns: null where `head` begins no format of the table that can be told by its first bytes.
const PictureFormat* picture_format_of_head(std::string_view head);

// The format of the file `path`, whose suffix and content agree, and its size. Returns: why it is
// refused, worded to follow the file's name.
struct PictureFile {
  const PictureFormat* format = nullptr;
  std::uint64_t file_bytes = 0;
};
Result<PictureFile> picture_format_of(const std::string& path);

}  // namespace tessera::master
