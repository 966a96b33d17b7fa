// SPDX-License-Identifier: Apache-2.0
#include "common/scene_io/ply_header.h"

#include <algorithm>

namespace tessera::ply {
namespace {

std::optional<Type> type_of(std::string_view name) {
  static constexpr std::pair<std::string_view, Type> kNames[] = {
      {"char", Type::kInt8},      {"uchar", Type::kUint8},    {"short", Type::kInt16},
      {"ushort", Type::kUint16},  {"int", Type::kInt32},      {"uint", Type::kUint32},
      {"float", Type::kFloat32},  {"double", Type::kFloat64}, {"int8", Type::kInt8},
      {"uint8", Type::kUint8},    {"int16", Type::kInt16},    {"uint16", Type::kUint16},
      {"int32", Type::kInt32},    {"uint32", Type::kUint32},  {"float32", Type::kFloat32},
      {"float64", Type::kFloat64}};
  for (const auto& [known, type] : kNames) {
    if (name == known) return type;
  }
  return std::nullopt;
}

class HeaderReader {
 public:
  HeaderReader(const std::string& path, TextScanner& scanner) : path_(path), scanner_(scanner) {}

  Result<Header> read() {
    if (!scanner_.next_line() || scanner_.line() != "ply")
      return Status::invalid_argument(path_ + ":1: does not begin with 'ply'");
    bool has_format = false;
    while (scanner_.next_line()) {
      const std::string_view key = scanner_.word();
      if (key == "end_header") {
        if (!has_format) return wrong("the header names no format");
        return std::move(header_);
      }
      if (key == "comment" && scanner_.word() == "TextureFile")
        header_.texture = std::string(scanner_.trimmed_rest_of_line());
      if (key == "comment" || key == "obj_info" || key.empty()) continue;
      if (key == "format") {
        const std::string_view name = scanner_.word();
        header_.format = name == "ascii"               ? Format::kAscii
                         : name == "binary_big_endian" ? Format::kBig
                                                       : Format::kLittle;
        if (header_.format == Format::kLittle && name != "binary_little_endian")
          return wrong("unknown format '" + std::string(name) + "'");
        has_format = true;
      } else if (key == "element") {
        const std::string name(scanner_.word());
        const auto count = scanner_.number<std::uint64_t>();
        if (!count || header_.elements.size() >= 64)
          return wrong("an element needs a name and a count");
        header_.elements.push_back({name, *count, {}});
      } else if (key == "property") {
        TESSERA_RETURN_IF_ERROR(read_property());
      } else {
        return wrong("unknown header word '" + std::string(key) + "'");
      }
    }
    return Status::invalid_argument(path_ + ": the header does not end");
  }

 private:
  Status wrong(const std::string& text) const {
    return Status::invalid_argument(path_ + ":" + std::to_string(scanner_.line_number()) + ": " +
                                    text);
  }

  Status read_property() {
    auto& elements = header_.elements;
    if (elements.empty() || elements.back().properties.size() >= 256)
      return wrong("a property without its element");
    Property property;
    std::string_view word = scanner_.word();
    if (word == "list") {
      property.is_list = true;
      const auto count_type = type_of(scanner_.word());
      if (!count_type || *count_type >= Type::kFloat32)
        return wrong("a list needs a whole-number count");
      property.count_type = *count_type;
      word = scanner_.word();
    }
    const auto type = type_of(word);
    property.name = std::string(scanner_.word());
    if (!type || property.name.empty()) return wrong("a property needs a known type and a name");
    property.type = *type;
    elements.back().properties.push_back(std::move(property));
    return Status::ok();
  }

  const std::string& path_;
  TextScanner& scanner_;
  Header header_;
};

}  // namespace

std::size_t size_of(Type type) {
  static constexpr std::size_t kSizes[] = {1, 1, 2, 2, 4, 4, 4, 8};
  return kSizes[static_cast<int>(type)];
}

double largest_of(Type type) {
  static constexpr double kLargest[] = {127, 255, 32767, 65535, 2147483647, 4294967295, 1, 1};
  return kLargest[static_cast<int>(type)];
}

std::uint64_t Element::bytes_min(Format format) const {
  std::uint64_t bytes = 0;
  for (const Property& p : properties)
    bytes += format == Format::kAscii ? 2 : size_of(p.is_list ? p.count_type : p.type);
  return std::max<std::uint64_t>(bytes, 1);
}

Result<Header> read_header(const std::string& path, TextScanner& scanner) {
  return HeaderReader(path, scanner).read();
}

}  // namespace tessera::ply
