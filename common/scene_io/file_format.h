// SPDX-License-Identifier: Apache-2.0
// The registry of files that scenes and skies come in (file_formats.inc): their suffixes, how they
// are recognised by their first bytes, and what they are called. Everything that opens such a file,
// or tells a person which there are, asks here.
//
// Invariant. A reader gets a file only where suffix and content agree: check_content(). So whatever
// bytes a file has, they meet the one reader that they are meant for.
// Threads. Pure functions but for check_content(), which reads the beginning of a file.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>

#include "common/base/status.h"

namespace tessera {

#define TESSERA_FORMAT(enumerator, ...) enumerator,
enum class FileFormat {
#include "common/scene_io/file_formats.inc"
};

struct FormatEntry {
  FileFormat format;
  std::string_view suffix;  // ".obj", lower case
  std::string_view name;    // "an OBJ file", to follow "is"
  bool is_sky = false;      // a picture of what surrounds a scene, and no scene
  int place = 0;            // in lists that a person reads
  std::string_view begins;  // the first bytes; empty: `look` decides
  // Whether a file of `file_bytes` bytes that begins with `head` has this format.
  bool (*look)(std::string_view head, std::uint64_t file_bytes) = nullptr;

  bool matches(std::string_view head, std::uint64_t file_bytes) const {
    return look != nullptr ? look(head, file_bytes) : head.starts_with(begins);
  }
};

// Bytes of a file's beginning that matches() sees.
inline constexpr std::size_t kHeadBytes = 64 * 1024;

std::span<const FormatEntry> file_formats();

// Finds a format by the suffix of a path, in capitals or not. Returns: null for an unknown one.
const FormatEntry* format_of_suffix(const std::string& path);
// Finds a format by content. Returns: null where it is none of the registry's.
const FormatEntry* format_of_content(std::string_view head, std::uint64_t file_bytes);

// Suffixes of the formats of scenes, or of skies: ".obj, .ply, ...".
std::string suffix_list(bool is_sky);

// Finds the format of `path`, where suffix and content agree. Returns: one line naming the file
// when the suffix is unknown, the content has another format ("a.gltf is an OBJ file by its
// content; rename it"), or the content has no known format.
Result<FileFormat> check_content(const std::string& path);

}  // namespace tessera
