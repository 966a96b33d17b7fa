// SPDX-License-Identifier: Apache-2.0
#include <cmath>
#include <filesystem>
#include <unordered_map>

#include "common/base/limits.h"
#include "common/scene_io/confined_path.h"
#include "common/scene_io/mtl_reader.h"
#include "common/scene_io/polygon.h"
#include "common/scene_io/scene_reader.h"
#include "common/scene_io/smooth_normals.h"
#include "common/scene_io/text_scanner.h"
#include "common/scene_io/vertex_color.h"
#include "common/scene_io/warning_group.h"

namespace tessera {
namespace {

constexpr std::uint64_t kFileBytesMax = std::uint64_t{4} << 30;
constexpr std::size_t kPolygonCornersMax = 65536;

// Marks a Corner::normal that is the smoothing group from which the corner takes its normal.
constexpr std::uint32_t kGroupBit = 0x80000000u;

struct Corner {
  std::uint32_t position = 0, uv = 0, normal = 0;  // uv and normal: 0 none, else index + 1
  bool operator==(const Corner&) const = default;
};

struct CornerHash {
  std::size_t operator()(const Corner& c) const {
    std::uint64_t h = c.position * 0x9e3779b97f4a7c15u;
    h = (h ^ c.uv) * 0xbf58476d1ce4e5b9u;
    h = (h ^ c.normal) * 0x94d049bb133111ebu;
    return static_cast<std::size_t>(h ^ h >> 31);
  }
};

class ObjReader {
 public:
  ObjReader(std::string path, std::string_view text, const TextureLoader& load_texture)
      : path_(std::move(path)), scanner_(text), warnings_(path_), mtl_(result_, load_texture) {}

  Result<ReadScene> read() {
    result_.scene.materials.emplace_back();
    result_.scene.materials[0].name = "default";
    while (scanner_.next_logical_line()) TESSERA_RETURN_IF_ERROR(read_line());
    if (mesh_.triangles.empty()) return Status::invalid_argument(path_ + ": holds no faces");
    if (!has_normals_) mesh_.normals.clear();
    if (!has_uvs_) mesh_.uvs.clear();
    if (has_groups_) smooth();
    if (!colors_.empty()) color_vertices();
    for (std::string& line : warnings_.lines()) result_.warnings.push_back(std::move(line));
    warn_degenerate(count_degenerate(mesh_), result_.warnings);
    result_.scene.meshes = {std::make_shared<const Mesh>(std::move(mesh_))};
    result_.scene.instances.resize(1);
    return std::move(result_);
  }

 private:
  Status wrong(const std::string& text) const {
    return Status::invalid_argument(path_ + ":" + std::to_string(scanner_.line_number()) + ": " +
                                    text);
  }

  Status read_line() {
    const std::string_view key = scanner_.word();
    if (key.empty() || key.front() == '#') return Status::ok();
    if (key == "v") return read_position();
    if (key == "vt") return read_uv();
    if (key == "vn") return read_normal();
    if (key == "f") return read_face();
    if (key == "usemtl") {
      use_material(std::string(scanner_.trimmed_rest_of_line()));
      return Status::ok();
    }
    if (key == "mtllib") {
      read_materials(std::string(scanner_.trimmed_rest_of_line()));
      return Status::ok();
    }
    if (key == "s") read_group();
    if (key == "o" || key == "g" || key == "s") return Status::ok();
    const std::string word(key);
    warn("unknown " + word, key == "l" || key == "p"
                                ? "'" + word + "': lines and points have no surface; left out"
                                : "'" + word + "' is not understood and left out");
    return Status::ok();
  }

  void warn(const std::string& kind, const std::string& text) {
    warnings_.add(kind, "line " + std::to_string(scanner_.line_number()) + ": " + text);
  }

  Status read_position() {
    const auto x = scanner_.number<float>(), y = scanner_.number<float>(),
               z = scanner_.number<float>();
    if (!x || !y || !z)
      return wrong("vertex " + std::to_string(positions_.size() + 1) + " needs three numbers");
    const Vec3f p{*x, *y, *z};
    if (!is_finite(p))
      return wrong("vertex " + std::to_string(positions_.size() + 1) + " is not finite");
    positions_.push_back(p);
    if (!scanner_.trimmed_rest_of_line().empty() || !colors_.empty()) read_color();
    return Status::ok();
  }

  // Reads the colour of "x y z r g b" or "x y z w r g b". A fourth number alone is a weight, which
  // polygons do not have.
  void read_color() {
    std::optional<float> numbers[4];
    std::size_t count = 0;
    for (std::string_view word = scanner_.word(); !word.empty() && count < 4; ++count) {
      if (word.front() == '#') break;
      numbers[count] = TextScanner::number_of<float>(word);
      word = scanner_.word();
    }
    const std::size_t first = count == 4 ? 1 : 0;
    if (count >= 3) colors_.resize(positions_.size() - 1, kWhite);
    if (colors_.empty()) return;
    colors_.push_back(kWhite);
    if (count < 3) return;
    const Vec3f c{numbers[first].value_or(NAN), numbers[first + 1].value_or(NAN),
                  numbers[first + 2].value_or(NAN)};
    if (is_finite(c)) {
      colors_.back() = vertex_color(c.x, c.y, c.z, 1);
    } else {
      warn("vertex colour", "the colour of vertex " + std::to_string(positions_.size()) +
                                " needs finite numbers; it is white");
    }
  }

  void read_group() {
    const std::string_view word = scanner_.word();
    const auto group = TextScanner::number_of<std::uint32_t>(word);
    group_ = group && *group < kGroupBit ? *group : 0;
    if (!group && word != "off")
      warn("group", "smoothing group '" + std::string(word) + "' is not a number; taken for 'off'");
  }

  Status read_uv() {
    const auto u = scanner_.number<float>();
    const auto v = scanner_.number<float>();
    const Vec2f uv{u.value_or(0), v.value_or(0)};
    if (!u || !std::isfinite(uv.x) || !std::isfinite(uv.y))
      return wrong("a texture coordinate needs finite numbers");
    uvs_.push_back(uv);
    return Status::ok();
  }

  Status read_normal() {
    const auto x = scanner_.number<float>(), y = scanner_.number<float>(),
               z = scanner_.number<float>();
    const Vec3f n{x.value_or(0), y.value_or(0), z.value_or(0)};
    if (!x || !y || !z || !is_finite(n)) return wrong("a normal needs three finite numbers");
    normals_.push_back(n);
    return Status::ok();
  }

  // Reads an index such as "7" or "-1". Returns: the index from 0. `what` is for the message.
  Result<std::uint32_t> read_index(std::string_view text, std::size_t count, const char* what) {
    const auto number = TextScanner::number_of<std::int64_t>(text);
    if (!number) return wrong("'" + std::string(text) + "' is not an index");
    const std::int64_t index =
        *number > 0 ? *number - 1 : *number + static_cast<std::int64_t>(count);
    if (*number == 0 || index < 0 || index >= static_cast<std::int64_t>(count)) {
      return wrong(std::string(what) + " " + std::string(text) + " is out of range, there are " +
                   std::to_string(count));
    }
    return static_cast<std::uint32_t>(index);
  }

  Result<Corner> read_corner(std::string_view word) {
    Corner corner;
    const auto first = word.find('/');
    auto position = read_index(word.substr(0, first), positions_.size(), "vertex");
    if (!position.is_ok()) return position.status();
    corner.position = *position;
    if (group_ != 0) corner.normal = kGroupBit | group_;
    if (first == std::string_view::npos) return corner;
    const auto second = word.find('/', first + 1);
    const std::string_view uv =
        word.substr(first + 1, second == std::string_view::npos ? second : second - first - 1);
    if (!uv.empty()) {
      auto index = read_index(uv, uvs_.size(), "texture coordinate");
      if (!index.is_ok()) return index.status();
      corner.uv = *index + 1;
    }
    if (second != std::string_view::npos && second + 1 < word.size()) {
      auto index = read_index(word.substr(second + 1), normals_.size(), "normal");
      if (!index.is_ok()) return index.status();
      corner.normal = *index + 1;
    }
    return corner;
  }

  std::uint32_t vertex_of(const Corner& corner) {
    const auto [entry, is_new] =
        vertices_.try_emplace(corner, static_cast<std::uint32_t>(mesh_.positions.size()));
    if (is_new) {
      mesh_.positions.push_back(positions_[corner.position]);
      mesh_.uvs.push_back(corner.uv > 0 ? uvs_[corner.uv - 1] : Vec2f{});
      const bool has_normal = corner.normal > 0 && corner.normal < kGroupBit;
      mesh_.normals.push_back(has_normal ? normals_[corner.normal - 1] : Vec3f{});
      has_uvs_ = has_uvs_ || corner.uv > 0;
      has_normals_ = has_normals_ || corner.normal > 0;
      has_groups_ = has_groups_ || corner.normal >= kGroupBit;
    }
    return entry->second;
  }

  Status read_face() {
    corners_.clear();
    for (std::string_view word = scanner_.word(); !word.empty(); word = scanner_.word()) {
      if (corners_.size() >= kPolygonCornersMax) return wrong("a face has too many corners");
      auto corner = read_corner(word);
      if (!corner.is_ok()) return corner.status();
      corners_.push_back(vertex_of(*corner));
    }
    if (corners_.size() < 3) return wrong("a face needs at least three corners");
    if (corners_.size() > 3 && is_concave()) {
      cut_face();
    } else {
      for (std::size_t i = 2; i < corners_.size(); ++i)
        mesh_.triangles.push_back({corners_[0], corners_[i - 1], corners_[i]});
    }
    mesh_.materials.resize(mesh_.triangles.size(), material_);
    if (mesh_.triangles.size() > kTrianglesMax)
      return Status::resource_exhausted(path_ + ": more than 2^30 triangles");
    return Status::ok();
  }

  bool is_concave() {
    polygon_.clear();
    for (const std::uint32_t corner : corners_) polygon_.push_back(mesh_.positions[corner]);
    return !PolygonCutter::is_fan(polygon_);
  }
  void cut_face() {
    for (const auto& [a, b, c] : cutter_.cut(polygon_))
      mesh_.triangles.push_back({corners_[a], corners_[b], corners_[c]});
    if (cutter_.is_guessed())
      warn("polygon", "a face crosses itself or has no area; its triangles are a guess");
  }

  // Corners of one position and one group share a normal.
  void smooth() {
    std::vector<std::uint32_t> shared(mesh_.positions.size(), kNotSmoothed);
    std::unordered_map<std::uint64_t, std::uint32_t> numbers;
    for (const auto& [corner, vertex] : vertices_) {
      if (corner.normal < kGroupBit) continue;
      const std::uint64_t key = std::uint64_t{corner.normal} << 32 | corner.position;
      shared[vertex] = numbers.try_emplace(key, numbers.size()).first->second;
    }
    smooth_normals(mesh_, shared, static_cast<std::uint32_t>(numbers.size()));
  }
  // A face without a material shows the colours of its vertices as they are.
  void color_vertices() {
    result_.scene.materials[0].albedo = {1, 1, 1};
    colors_.resize(positions_.size(), kWhite);
    mesh_.colors.resize(mesh_.positions.size());
    for (const auto& [corner, vertex] : vertices_) mesh_.colors[vertex] = colors_[corner.position];
  }

  void use_material(const std::string& name) {
    if (const auto known = mtl_.find(name)) {
      material_ = *known;
      return;
    }
    warn("material " + name, "material '" + name + "' is not defined; grey is used");
    material_ = 0;
  }

  void read_materials(const std::string& names);
  void read_material_file(const std::string& name, const Result<std::string>& file);

  static constexpr Vec4f kWhite{1, 1, 1, 1};

  const std::string path_;
  TextScanner scanner_;
  WarningGroup warnings_;
  ReadScene result_;
  MtlReader mtl_;
  Mesh mesh_;
  std::vector<Vec3f> positions_, normals_;
  std::vector<Vec2f> uvs_;
  std::vector<Vec4f> colors_;  // [positions_] up to the last one that has a colour
  std::vector<std::uint32_t> corners_;
  std::vector<Vec3f> polygon_;  // positions of the corners
  PolygonCutter cutter_;
  std::unordered_map<Corner, std::uint32_t, CornerHash> vertices_;
  bool has_uvs_ = false, has_normals_ = false, has_groups_ = false;
  std::uint32_t material_ = 0;
  std::uint32_t group_ = 0;  // of smoothing; 0: none
};

// `names` is one name, which may hold spaces, or several.
void ObjReader::read_materials(const std::string& names) {
  const std::string folder = std::filesystem::path(path_).parent_path().string();
  auto whole = confined_path(folder, names);
  if (whole.is_ok() || names.find(' ') == std::string::npos)
    return read_material_file(names, whole);
  TextScanner words(names);
  (void)words.next_line();
  for (std::string name(words.word()); !name.empty(); name = words.word())
    read_material_file(name, confined_path(folder, name));
}

void ObjReader::read_material_file(const std::string& name, const Result<std::string>& file) {
  if (!file.is_ok())
    return warn("mtllib " + name,
                "material file '" + name + "': " + file.status().message() + "; grey is used");
  auto text = read_whole_file(*file, kFileBytesMax);
  if (!text.is_ok())
    return warn("mtllib " + name, "material file " + text.status().message() + "; grey is used");
  mtl_.read(*file, *text);
}

}  // namespace

std::uint64_t count_degenerate(const Mesh& mesh) {
  std::uint64_t count = 0;
  for (const auto& [a, b, c] : mesh.triangles) {
    const Vec3f n =
        cross(mesh.positions[b] - mesh.positions[a], mesh.positions[c] - mesh.positions[a]);
    if (n == Vec3f{}) ++count;
  }
  return count;
}

void warn_degenerate(std::uint64_t count, std::vector<std::string>& warnings) {
  if (count > 0)
    warnings.push_back(std::to_string(count) +
                       " degenerate triangles have no area and are never hit");
}

Result<ReadScene> read_obj(const std::string& path, const TextureLoader& load_texture) {
  auto text = read_whole_file(path, kFileBytesMax);
  if (!text.is_ok()) return text.status();
  return ObjReader(path, *text, load_texture).read();
}

}  // namespace tessera
