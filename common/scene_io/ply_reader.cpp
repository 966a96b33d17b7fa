#include <bit>
#include <cmath>
#include <cstdio>
#include <cstring>

#include "common/base/limits.h"
#include "common/scene_io/scene_reader.h"
#include "common/scene_io/text_scanner.h"

namespace tessera {
namespace {

std::string number_text(double value) {
  char text[32];
  std::snprintf(text, sizeof(text), "%.9g", value);
  return text;
}

constexpr std::uint64_t kFileBytesMax = std::uint64_t{8} << 30;
constexpr std::uint64_t kPolygonCornersMax = 65536;

enum class Format { kAscii, kLittle, kBig };
enum class Type { kInt8, kUint8, kInt16, kUint16, kInt32, kUint32, kFloat32, kFloat64 };

std::size_t size_of(Type type) {
  static constexpr std::size_t kSizes[] = {1, 1, 2, 2, 4, 4, 4, 8};
  return kSizes[static_cast<int>(type)];
}

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

struct Property {
  std::string name;
  bool is_list = false;
  Type count_type = Type::kUint8, type = Type::kFloat32;
};

struct Element {
  std::string name;
  std::uint64_t count = 0;
  std::vector<Property> properties;

  // Fewest bytes that one of it takes: for checking counts against the bytes present.
  std::uint64_t bytes_min(Format format) const {
    std::uint64_t bytes = 0;
    for (const Property& p : properties)
      bytes += format == Format::kAscii ? 2 : size_of(p.is_list ? p.count_type : p.type);
    return std::max<std::uint64_t>(bytes, 1);
  }
};

template <typename T>
T from_bytes(const char* bytes, bool is_swapped) {
  char copy[sizeof(T)];
  for (std::size_t i = 0; i < sizeof(T); ++i) copy[i] = bytes[is_swapped ? sizeof(T) - 1 - i : i];
  return std::bit_cast<T>(copy);
}

class PlyReader {
 public:
  PlyReader(std::string path, std::string_view text) : path_(std::move(path)), scanner_(text) {}

  Result<ReadScene> read() {
    TESSERA_RETURN_IF_ERROR(read_header());
    body_ = scanner_.rest();
    for (const Element& element : elements_) TESSERA_RETURN_IF_ERROR(read_element(element));
    if (mesh_.triangles.empty()) return Status::invalid_argument(path_ + ": holds no faces");
    mesh_.materials = {0};
    ReadScene result;
    warn_degenerate(count_degenerate(mesh_), result.warnings);
    result.scene.materials.emplace_back();
    result.scene.materials[0].name = "default";
    result.scene.meshes = {std::make_shared<const Mesh>(std::move(mesh_))};
    result.scene.instances.resize(1);
    return result;
  }

 private:
  Status wrong(const std::string& text) const {
    return Status::invalid_argument(path_ + ":" + std::to_string(scanner_.line_number()) + ": " +
                                    text);
  }
  Status wrong_element(const std::string& name, std::uint64_t index,
                       const std::string& text) const {
    const std::string line =
        format_ == Format::kAscii ? ":" + std::to_string(scanner_.line_number()) : "";
    return Status::invalid_argument(path_ + line + ": " + name + " " + std::to_string(index) + " " +
                                    text);
  }

  Status read_header() {
    if (!scanner_.next_line() || scanner_.line() != "ply")
      return Status::invalid_argument(path_ + ":1: does not begin with 'ply'");
    bool has_format = false;
    while (scanner_.next_line()) {
      const std::string_view key = scanner_.word();
      if (key == "end_header")
        return has_format ? Status::ok() : wrong("the header names no format");
      if (key == "comment" || key == "obj_info" || key.empty()) continue;
      if (key == "format") {
        const std::string_view name = scanner_.word();
        format_ = name == "ascii"               ? Format::kAscii
                  : name == "binary_big_endian" ? Format::kBig
                                                : Format::kLittle;
        if (format_ == Format::kLittle && name != "binary_little_endian")
          return wrong("unknown format '" + std::string(name) + "'");
        has_format = true;
      } else if (key == "element") {
        const std::string name(scanner_.word());
        const auto count = scanner_.number<std::uint64_t>();
        if (!count || elements_.size() >= 64) return wrong("an element needs a name and a count");
        elements_.push_back({name, *count, {}});
      } else if (key == "property") {
        TESSERA_RETURN_IF_ERROR(read_property());
      } else {
        return wrong("unknown header word '" + std::string(key) + "'");
      }
    }
    return Status::invalid_argument(path_ + ": the header does not end");
  }

  Status read_property() {
    if (elements_.empty() || elements_.back().properties.size() >= 256)
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
    elements_.back().properties.push_back(std::move(property));
    return Status::ok();
  }

  // The next number of the body. Returns: nothing at the end or for what is no number.
  std::optional<double> next_number(Type type) {
    if (format_ == Format::kAscii) return scanner_.number<double>();
    const std::size_t size = size_of(type);
    if (body_.size() < size) return std::nullopt;
    const char* const at = body_.data();
    body_.remove_prefix(size);
    const bool is_swapped = format_ == Format::kBig;
    switch (type) {
      case Type::kInt8:
        return from_bytes<std::int8_t>(at, is_swapped);
      case Type::kUint8:
        return from_bytes<std::uint8_t>(at, is_swapped);
      case Type::kInt16:
        return from_bytes<std::int16_t>(at, is_swapped);
      case Type::kUint16:
        return from_bytes<std::uint16_t>(at, is_swapped);
      case Type::kInt32:
        return from_bytes<std::int32_t>(at, is_swapped);
      case Type::kUint32:
        return from_bytes<std::uint32_t>(at, is_swapped);
      case Type::kFloat32:
        return from_bytes<float>(at, is_swapped);
      case Type::kFloat64:
        return from_bytes<double>(at, is_swapped);
    }
    return std::nullopt;
  }

  Status read_element(const Element& element) {
    const std::uint64_t present = format_ == Format::kAscii ? scanner_.rest().size() : body_.size();
    if (element.count > present / element.bytes_min(format_) + 1) {
      return Status::invalid_argument(path_ + ": announces " + std::to_string(element.count) +
                                      " of element " + element.name + ", but only " +
                                      std::to_string(present) + " bytes follow");
    }
    const bool is_vertex = element.name == "vertex", is_face = element.name == "face";
    if (is_vertex) prepare_vertices(element);
    for (std::uint64_t i = 0; i < element.count; ++i) {
      if (format_ == Format::kAscii && !scanner_.next_line())
        return wrong_element(element.name, i, "is missing: the file ends");
      for (std::size_t p = 0; p < element.properties.size(); ++p) {
        const Property& property = element.properties[p];
        const bool is_corners =
            is_face && (property.name == "vertex_indices" || property.name == "vertex_index");
        TESSERA_RETURN_IF_ERROR(
            property.is_list ? read_list(element, i, property, is_corners)
                             : read_scalar(element, i, property, is_vertex ? slots_[p] : nullptr));
      }
      if (is_vertex) TESSERA_RETURN_IF_ERROR(add_vertex(i));
    }
    return Status::ok();
  }

  // Where each property of a vertex goes.
  void prepare_vertices(const Element& element) {
    static constexpr std::pair<std::string_view, int> kNames[] = {
        {"x", 0}, {"y", 1}, {"z", 2},         {"nx", 3}, {"ny", 4}, {"nz", 5},
        {"s", 6}, {"u", 6}, {"texture_u", 6}, {"t", 7},  {"v", 7},  {"texture_v", 7}};
    slots_.assign(element.properties.size(), nullptr);
    for (std::size_t p = 0; p < slots_.size(); ++p) {
      for (const auto& [name, slot] : kNames) {
        if (element.properties[p].name != name) continue;
        slots_[p] = &vertex_[slot];
        has_normals_ = has_normals_ || slot == 3;
        has_uvs_ = has_uvs_ || slot == 6;
      }
    }
  }

  Status read_scalar(const Element& element, std::uint64_t index, const Property& property,
                     double* slot) {
    const auto value = next_number(property.type);
    if (!value)
      return wrong_element(element.name, index, "lacks a number for '" + property.name + "'");
    if (slot != nullptr) *slot = *value;
    return Status::ok();
  }

  Status add_vertex(std::uint64_t index) {
    const Vec3f p{static_cast<float>(vertex_[0]), static_cast<float>(vertex_[1]),
                  static_cast<float>(vertex_[2])};
    if (!is_finite(p)) return wrong_element("vertex", index, "is not finite");
    mesh_.positions.push_back(p);
    if (has_normals_) {
      const Vec3f n{static_cast<float>(vertex_[3]), static_cast<float>(vertex_[4]),
                    static_cast<float>(vertex_[5])};
      mesh_.normals.push_back(is_finite(n) ? n : Vec3f{});
    }
    if (has_uvs_) {
      const Vec2f uv{static_cast<float>(vertex_[6]), static_cast<float>(vertex_[7])};
      mesh_.uvs.push_back(std::isfinite(uv.x) && std::isfinite(uv.y) ? uv : Vec2f{});
    }
    return Status::ok();
  }

  Status read_list(const Element& element, std::uint64_t index, const Property& property,
                   bool is_corners) {
    const auto count = next_number(property.count_type);
    if (!count || !(*count >= 0 && *count <= static_cast<double>(kPolygonCornersMax))) {
      return wrong_element(element.name, index, "has a list of impossible length");
    }
    if (is_corners && *count < 3)
      return wrong_element(element.name, index, "has fewer than three corners");
    std::uint32_t first = 0, previous = 0;
    for (std::uint64_t k = 0; k < static_cast<std::uint64_t>(*count); ++k) {
      const auto value = next_number(property.type);
      if (!value) return wrong_element(element.name, index, "ends in the middle of a list");
      if (!is_corners) continue;
      if (!(*value >= 0 && *value < static_cast<double>(mesh_.positions.size())) ||
          *value != std::floor(*value)) {
        return wrong_element(element.name, index,
                             "names vertex " + number_text(*value) + ", there are " +
                                 std::to_string(mesh_.positions.size()));
      }
      const auto vertex = static_cast<std::uint32_t>(*value);
      if (k == 0) first = vertex;
      if (k >= 2) mesh_.triangles.push_back({first, previous, vertex});
      previous = vertex;
    }
    if (mesh_.triangles.size() > kTrianglesMax)
      return Status::resource_exhausted(path_ + ": more than 2^30 triangles");
    return Status::ok();
  }

  const std::string path_;
  TextScanner scanner_;
  std::string_view body_;  // binary formats
  Format format_ = Format::kAscii;
  std::vector<Element> elements_;
  Mesh mesh_;
  double vertex_[8] = {};
  std::vector<double*> slots_;
  bool has_normals_ = false, has_uvs_ = false;
};

}  // namespace

Result<ReadScene> read_ply(const std::string& path) {
  auto text = read_whole_file(path, kFileBytesMax);
  if (!text.is_ok()) return text.status();
  return PlyReader(path, *text).read();
}

}  // namespace tessera
