// SPDX-License-Identifier: Apache-2.0
// The header of a PLY file: which elements it has, in which order, and what each consists of (G.
// Turk, "The PLY polygon file format", 1994).
// Threads. Plain values.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "common/base/status.h"
#include "common/scene_io/text_scanner.h"

namespace tessera::ply {

enum class Format { kAscii, kLittle, kBig };
enum class Type { kInt8, kUint8, kInt16, kUint16, kInt32, kUint32, kFloat32, kFloat64 };

std::size_t size_of(Type type);
// The largest number of an integer type, of which colours are shares; 1 for the other types.
double largest_of(Type type);

struct Property {
  std::string name;
  bool is_list = false;
  Type count_type = Type::kUint8, type = Type::kFloat32;
};

struct Element {
  std::string name;
  std::uint64_t count = 0;
  std::vector<Property> properties;

  // Fewest bytes that one such element takes, for checking counts against the bytes present.
  std::uint64_t bytes_min(Format format) const;
};

struct Header {
  Format format = Format::kAscii;
  std::vector<Element> elements;
  std::string texture;  // of a comment "TextureFile NAME"; empty: none
};

// Reads up to the line "end_header". Returns: one line naming `path` and line.
Result<Header> read_header(const std::string& path, TextScanner& scanner);

}  // namespace tessera::ply
