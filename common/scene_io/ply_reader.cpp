// SPDX-License-Identifier: Apache-2.0
#include <bit>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <map>
#include <set>
#include <tuple>

#include "common/base/limits.h"
#include "common/scene_io/ply_header.h"
#include "common/scene_io/polygon.h"
#include "common/scene_io/scene_reader.h"
#include "common/scene_io/text_scanner.h"
#include "common/scene_io/vertex_color.h"
#include "common/scene_io/warning_group.h"

namespace tessera {
namespace {

using ply::Element;
using ply::Format;
using ply::Property;
using ply::Type;

std::string number_text(double value) {
  char text[32];
  std::snprintf(text, sizeof(text), "%.9g", value);
  return text;
}

constexpr std::uint64_t kFileBytesMax = std::uint64_t{8} << 30;
constexpr std::uint64_t kPolygonCornersMax = 65536;

template <typename T>
T from_bytes(const char* bytes, bool is_swapped) {
  char copy[sizeof(T)];
  for (std::size_t i = 0; i < sizeof(T); ++i) copy[i] = bytes[is_swapped ? sizeof(T) - 1 - i : i];
  return std::bit_cast<T>(copy);
}

class PlyReader {
 public:
  PlyReader(std::string path, std::string_view text)
      : path_(std::move(path)), scanner_(text), warnings_(path_) {}

  Result<ReadScene> read(const TextureLoader& load_texture) {
    auto header = ply::read_header(path_, scanner_);
    if (!header.is_ok()) return header.status();
    format_ = header->format;
    body_ = scanner_.rest();
    for (const Element& element : header->elements) TESSERA_RETURN_IF_ERROR(read_element(element));
    if (mesh_.triangles.empty()) return Status::invalid_argument(path_ + ": holds no faces");
    mesh_.materials = {0};
    ReadScene result;
    result.scene.materials.emplace_back();
    result.scene.materials[0].name = "default";
    if (!mesh_.colors.empty()) result.scene.materials[0].albedo = {1, 1, 1};
    if (!header->texture.empty()) add_texture(header->texture, load_texture, result.scene);
    name_left_out();
    result.warnings = warnings_.lines();
    warn_degenerate(count_degenerate(mesh_), result.warnings);
    result.scene.meshes = {std::make_shared<const Mesh>(std::move(mesh_))};
    result.scene.instances.resize(1);
    return result;
  }

 private:
  Status wrong_element(const std::string& name, std::uint64_t index,
                       const std::string& text) const {
    const std::string line =
        format_ == Format::kAscii ? ":" + std::to_string(scanner_.line_number()) : "";
    return Status::invalid_argument(path_ + line + ": " + name + " " + std::to_string(index) + " " +
                                    text);
  }

  // The next number of the body. Returns: nothing at the end or for what is no number.
  std::optional<double> next_number(Type type) {
    if (format_ == Format::kAscii) return scanner_.number<double>();
    const std::size_t size = ply::size_of(type);
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
    prepare(element, is_vertex, is_face);
    for (std::uint64_t i = 0; i < element.count; ++i) {
      if (format_ == Format::kAscii && !scanner_.next_line())
        return wrong_element(element.name, i, "is missing: the file ends");
      corners_.clear();
      wedges_.clear();
      for (std::size_t p = 0; p < element.properties.size(); ++p) {
        const Property& property = element.properties[p];
        TESSERA_RETURN_IF_ERROR(property.is_list ? read_list(element, i, property, lists_[p])
                                                 : read_scalar(element, i, property, slots_[p]));
      }
      if (is_vertex) TESSERA_RETURN_IF_ERROR(add_vertex(i));
      if (is_face) TESSERA_RETURN_IF_ERROR(add_face(i));
    }
    return Status::ok();
  }

  std::vector<double>* list_of(const Property& property) {
    if (!property.is_list) return nullptr;
    if (property.name == "vertex_indices" || property.name == "vertex_index") return &corners_;
    return property.name == "texcoord" ? &wedges_ : nullptr;
  }

  // Decides where the numbers of each property go, and which properties are left out.
  void prepare(const Element& element, bool is_vertex, bool is_face) {
    slots_.assign(element.properties.size(), nullptr);
    lists_.assign(element.properties.size(), nullptr);
    if (is_vertex) prepare_vertices(element);
    if (!is_vertex && !is_face) left_out_[element.name];
    for (std::size_t p = 0; p < element.properties.size(); ++p) {
      if (is_face) lists_[p] = list_of(element.properties[p]);
      if ((is_vertex || is_face) && slots_[p] == nullptr && lists_[p] == nullptr)
        left_out_[element.name].insert(element.properties[p].name);
    }
  }

  void prepare_vertices(const Element& element) {
    static constexpr std::pair<std::string_view, int> kNames[] = {{"x", 0},
                                                                  {"y", 1},
                                                                  {"z", 2},
                                                                  {"nx", 3},
                                                                  {"ny", 4},
                                                                  {"nz", 5},
                                                                  {"s", 6},
                                                                  {"u", 6},
                                                                  {"texture_u", 6},
                                                                  {"t", 7},
                                                                  {"v", 7},
                                                                  {"texture_v", 7},
                                                                  {"red", 8},
                                                                  {"green", 9},
                                                                  {"blue", 10},
                                                                  {"alpha", 11},
                                                                  {"r", 8},
                                                                  {"g", 9},
                                                                  {"b", 10},
                                                                  {"a", 11},
                                                                  {"diffuse_red", 8},
                                                                  {"diffuse_green", 9},
                                                                  {"diffuse_blue", 10},
                                                                  {"diffuse_alpha", 11}};
    for (std::size_t p = 0; p < slots_.size(); ++p) {
      const Property& property = element.properties[p];
      for (const auto& [name, slot] : kNames) {
        if (property.name != name || property.is_list) continue;
        slots_[p] = &vertex_[slot];
        has_normals_ = has_normals_ || slot == 3;
        has_uvs_ = has_uvs_ || slot == 6;
        has_colors_ = has_colors_ || slot == 8;
        if (slot >= 8) color_scale_[slot - 8] = 1 / ply::largest_of(property.type);
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
      mesh_.uvs.push_back(is_finite(uv) ? uv : Vec2f{});
    }
    if (has_colors_) mesh_.colors.push_back(color_of(index));
    return Status::ok();
  }

  Vec4f color_of(std::uint64_t index) {
    float c[4];
    for (std::size_t k = 0; k < 4; ++k) c[k] = static_cast<float>(vertex_[8 + k] * color_scale_[k]);
    if (is_finite(Vec4f{c[0], c[1], c[2], c[3]})) return vertex_color(c[0], c[1], c[2], c[3]);
    warnings_.add("colour",
                  "the colour of vertex " + std::to_string(index) + " is not finite; it is white");
    return {1, 1, 1, 1};
  }

  // `list`: where its numbers go; null: nowhere.
  Status read_list(const Element& element, std::uint64_t index, const Property& property,
                   std::vector<double>* list) {
    const auto count = next_number(property.count_type);
    if (!count || !(*count >= 0 && *count <= static_cast<double>(2 * kPolygonCornersMax)))
      return wrong_element(element.name, index, "has a list of impossible length");
    for (std::uint64_t k = 0; k < static_cast<std::uint64_t>(*count); ++k) {
      const auto value = next_number(property.type);
      if (!value) return wrong_element(element.name, index, "ends in the middle of a list");
      if (list != nullptr) list->push_back(*value);
    }
    return Status::ok();
  }

  Status add_face(std::uint64_t index) {
    if (corners_.size() < 3) return wrong_element("face", index, "has fewer than three corners");
    if (corners_.size() > kPolygonCornersMax)
      return wrong_element("face", index, "has too many corners");
    polygon_.clear();
    for (double& corner : corners_) {
      if (!(corner >= 0 && corner < static_cast<double>(mesh_.positions.size())) ||
          corner != std::floor(corner)) {
        return wrong_element("face", index,
                             "names vertex " + number_text(corner) + ", there are " +
                                 std::to_string(mesh_.positions.size()));
      }
      polygon_.push_back(mesh_.positions[static_cast<std::size_t>(corner)]);
    }
    if (!wedges_.empty()) split_corners(index);
    const auto vertex = [this](std::uint32_t i) { return static_cast<std::uint32_t>(corners_[i]); };
    if (PolygonCutter::is_fan(polygon_)) {
      for (std::uint32_t i = 2; i < corners_.size(); ++i)
        mesh_.triangles.push_back({vertex(0), vertex(i - 1), vertex(i)});
    } else {
      for (const auto& [a, b, c] : cutter_.cut(polygon_))
        mesh_.triangles.push_back({vertex(a), vertex(b), vertex(c)});
      if (cutter_.is_guessed())
        warnings_.add("polygon", "face " + std::to_string(index) +
                                     " crosses itself or has no area; its triangles are a guess");
    }
    if (mesh_.triangles.size() > kTrianglesMax)
      return Status::resource_exhausted(path_ + ": more than 2^30 triangles");
    return Status::ok();
  }

  // Makes corners with texture coordinates vertices of their own; corners of one vertex whose
  // texture coordinates agree share one.
  void split_corners(std::uint64_t index) {
    if (wedges_.size() != 2 * corners_.size()) {
      return warnings_.add("texcoord", "face " + std::to_string(index) + " has " +
                                           std::to_string(wedges_.size()) +
                                           " numbers of 'texcoord' for " +
                                           std::to_string(corners_.size()) + " corners; left out");
    }
    mesh_.uvs.resize(mesh_.positions.size());
    for (std::size_t k = 0; k < corners_.size(); ++k) {
      const Vec2f uv{static_cast<float>(wedges_[2 * k]), static_cast<float>(wedges_[2 * k + 1])};
      const auto from = static_cast<std::uint32_t>(corners_[k]);
      if (!is_finite(uv)) continue;
      const auto [known, is_new] =
          split_.try_emplace({from, uv.x, uv.y}, static_cast<std::uint32_t>(mesh_.uvs.size()));
      if (is_new) {
        mesh_.uvs.push_back(uv);
        mesh_.positions.push_back(Vec3f(mesh_.positions[from]));
        if (has_normals_) mesh_.normals.push_back(Vec3f(mesh_.normals[from]));
        if (has_colors_) mesh_.colors.push_back(Vec4f(mesh_.colors[from]));
      }
      corners_[k] = known->second;
    }
  }

  void add_texture(const std::string& name, const TextureLoader& load, Scene& scene) {
    auto texture =
        load ? load(name)
             : Result<std::shared_ptr<const Texture>>(Status::unimplemented("no textures here"));
    if (mesh_.uvs.empty()) {
      warnings_.add("texture", "picture " + name +
                                   " is not drawn: there are no texture coordinates (s, t of "
                                   "vertices or texcoord of faces)");
    } else if (!texture.is_ok()) {
      warnings_.add("texture", "picture " + name + ": " + texture.status().message() +
                                   "; the plain colour is used");
    } else {
      scene.textures.push_back(*texture);
      scene.materials[0].albedo_texture = 0;
      scene.materials[0].albedo = {1, 1, 1};
    }
  }

  void name_left_out() {
    std::string text;
    for (const auto& [element, properties] : left_out_) {
      text += (text.empty() ? "" : "; ") + element;
      const char* separator = ": ";
      for (const std::string& property : properties) {
        text += separator + property;
        separator = ", ";
      }
    }
    if (!text.empty()) warnings_.add("left out", "not drawn: " + text);
  }

  const std::string path_;
  TextScanner scanner_;
  std::string_view body_;  // binary formats
  Format format_ = Format::kAscii;
  WarningGroup warnings_;
  Mesh mesh_;
  double vertex_[12] = {0, 0, 0, 0, 0, 0, 0, 0, 1, 1, 1, 1};
  double color_scale_[4] = {1, 1, 1, 1};
  std::vector<double*> slots_;               // of the element's properties
  std::vector<std::vector<double>*> lists_;  // likewise
  bool has_normals_ = false, has_uvs_ = false, has_colors_ = false;
  std::map<std::string, std::set<std::string>> left_out_;  // by element

  // State of the face in progress.
  std::vector<double> corners_, wedges_;
  std::vector<Vec3f> polygon_;
  PolygonCutter cutter_;
  std::map<std::tuple<std::uint32_t, float, float>, std::uint32_t> split_;
};

}  // namespace

Result<ReadScene> read_ply(const std::string& path, const TextureLoader& load_texture) {
  auto text = read_whole_file(path, kFileBytesMax);
  if (!text.is_ok()) return text.status();
  return PlyReader(path, *text).read(load_texture);
}

}  // namespace tessera
