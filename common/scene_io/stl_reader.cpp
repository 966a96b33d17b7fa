// SPDX-License-Identifier: Apache-2.0
// STL, binary and text (3D Systems, "StereoLithography interface specification", 1988).
//
// A file is binary where its size is that of the triangles it announces, whatever its first word
// is: many binary files begin with "solid" all the same.
#include <bit>
#include <cmath>
#include <cstring>
#include <unordered_map>

#include "common/base/limits.h"
#include "common/scene_io/scene_reader.h"
#include "common/scene_io/text_scanner.h"
#include "common/scene_io/warning_group.h"

namespace tessera {
namespace {

constexpr std::uint64_t kFileBytesMax = std::uint64_t{8} << 30;
constexpr std::size_t kHeaderBytes = 84, kFacetBytes = 50;

template <typename T>
T little(const char* bytes) {
  char copy[sizeof(T)];
  for (std::size_t i = 0; i < sizeof(T); ++i)
    copy[i] = bytes[std::endian::native == std::endian::little ? i : sizeof(T) - 1 - i];
  return std::bit_cast<T>(copy);
}

Vec3f little_vector(const char* bytes) {
  return {little<float>(bytes), little<float>(bytes + 4), little<float>(bytes + 8)};
}

// Hash of the bits, where -0 counts as 0.
struct PositionHash {
  std::size_t operator()(const Vec3f& p) const {
    std::uint64_t h = 0;
    for (const float x : {p.x, p.y, p.z})
      h = (h ^ std::bit_cast<std::uint32_t>(x + 0.0f)) * 0x9e3779b97f4a7c15u;
    return static_cast<std::size_t>(h ^ h >> 29);
  }
};

class StlReader {
 public:
  StlReader(std::string path, std::string_view bytes)
      : path_(std::move(path)), bytes_(bytes), warnings_(path_) {}

  Result<ReadScene> read() {
    TESSERA_RETURN_IF_ERROR(is_binary() ? read_binary() : read_text());
    if (mesh_.triangles.empty()) return Status::invalid_argument(path_ + ": holds no facets");
    mesh_.materials = {0};
    if (turned_ > 0) {
      warnings_.add("turned", std::to_string(turned_) +
                                  " facets have a normal against the order of their corners; the "
                                  "corners count");
    }
    ReadScene result;
    result.warnings = warnings_.lines();
    warn_degenerate(count_degenerate(mesh_), result.warnings);
    result.scene.materials.emplace_back();
    result.scene.materials[0].name = "default";
    result.scene.meshes = {std::make_shared<const Mesh>(std::move(mesh_))};
    result.scene.instances.resize(1);
    return result;
  }

 private:
  bool is_binary() const {
    if (bytes_.size() < kHeaderBytes) return false;
    if (bytes_.size() == kHeaderBytes + kFacetBytes * std::uint64_t{count()}) return true;
    return bytes_.substr(0, kHeaderBytes).find('\0') != std::string_view::npos;
  }
  std::uint32_t count() const { return little<std::uint32_t>(bytes_.data() + 80); }

  Status read_binary() {
    const std::uint64_t present = (bytes_.size() - kHeaderBytes) / kFacetBytes;
    if (count() > present) {
      return Status::invalid_argument(path_ + ": announces " + std::to_string(count()) +
                                      " facets, but only " + std::to_string(present) + " follow");
    }
    if (count() > kTrianglesMax)
      return Status::resource_exhausted(path_ + ": more than 2^30 triangles");
    if (bytes_.size() != kHeaderBytes + kFacetBytes * std::uint64_t{count()})
      warnings_.add("bytes", "bytes behind the last facet are left out");
    const bool has_color = bytes_.substr(0, 80).find("COLOR=") != std::string_view::npos;
    mesh_.triangles.reserve(count());
    for (std::uint32_t i = 0; i < count(); ++i) {
      const char* at = bytes_.data() + kHeaderBytes + kFacetBytes * i;
      const Vec3f corners[3] = {little_vector(at + 12), little_vector(at + 24),
                                little_vector(at + 36)};
      for (const Vec3f& c : corners) {
        if (!is_finite(c))
          return Status::invalid_argument(path_ + ": facet " + std::to_string(i) +
                                          " is not finite");
      }
      add_facet(little_vector(at), corners);
      if (has_color || little<std::uint16_t>(at + 48) != 0)
        warnings_.add_once("colour", "facet " + std::to_string(i) +
                                         ": colours of facets (attribute bytes) are not drawn");
    }
    return Status::ok();
  }

  // Reads words in capitals, too; several solids become one mesh.
  Status read_text() {
    TextScanner scanner(bytes_);
    Vec3f normal, corners[3];
    std::size_t corner_count = 0;
    bool is_open = false;
    const auto wrong = [&](const std::string& text) {
      return Status::invalid_argument(path_ + ":" + std::to_string(scanner.line_number()) + ": " +
                                      text);
    };
    while (scanner.next_line()) {
      const std::string word = lower(scanner.word());
      if (word == "facet") {
        if (is_open) return wrong("a facet begins within another one");
        is_open = true;
        corner_count = 0;
        (void)scanner.word();  // "normal"
        normal = numbers(scanner);
      } else if (word == "vertex") {
        if (!is_open || corner_count == 3)
          return wrong(is_open ? "a facet has more than three corners"
                               : "a corner without a facet");
        corners[corner_count] = numbers(scanner);
        if (!is_finite(corners[corner_count++]))
          return wrong("a corner needs three finite numbers");
      } else if (word == "endfacet") {
        if (!is_open || corner_count != 3) return wrong("a facet needs three corners");
        is_open = false;
        add_facet(normal, corners);
        if (mesh_.triangles.size() > kTrianglesMax)
          return Status::resource_exhausted(path_ + ": more than 2^30 triangles");
      } else if (!word.empty() && word != "solid" && word != "endsolid" && word != "outer" &&
                 word != "endloop") {
        return wrong("unknown word '" + word.substr(0, 40) + "'");
      }
    }
    return is_open ? wrong("the file ends within a facet") : Status::ok();
  }

  static std::string lower(std::string_view word) {
    std::string text(word);
    for (char& c : text) c = c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c;
    return text;
  }

  // Reads three numbers, with NaN in place of what is none.
  static Vec3f numbers(TextScanner& scanner) {
    const auto x = scanner.number<float>(), y = scanner.number<float>(),
               z = scanner.number<float>();
    return {x.value_or(NAN), y.value_or(NAN), z.value_or(NAN)};
  }

  void add_facet(Vec3f normal, const Vec3f (&corners)[3]) {
    std::array<std::uint32_t, 3> triangle;
    for (std::size_t k = 0; k < 3; ++k) {
      const auto [known, is_new] =
          vertices_.try_emplace(corners[k], static_cast<std::uint32_t>(mesh_.positions.size()));
      if (is_new) mesh_.positions.push_back(corners[k]);
      triangle[k] = known->second;
    }
    mesh_.triangles.push_back(triangle);
    if (dot(normal, cross(corners[1] - corners[0], corners[2] - corners[0])) < 0) ++turned_;
  }

  const std::string path_;
  const std::string_view bytes_;
  WarningGroup warnings_;
  Mesh mesh_;
  std::unordered_map<Vec3f, std::uint32_t, PositionHash> vertices_;
  std::uint64_t turned_ = 0;
};

}  // namespace

Result<ReadScene> read_stl(const std::string& path) {
  auto bytes = read_whole_file(path, kFileBytesMax);
  if (!bytes.is_ok()) return bytes.status();
  return StlReader(path, *bytes).read();
}

}  // namespace tessera
