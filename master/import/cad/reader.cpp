// SPDX-License-Identifier: Apache-2.0
#include "master/import/cad/reader.h"

#include <Standard_Failure.hxx>
#include <Standard_OutOfMemory.hxx>
#include <TopExp_Explorer.hxx>
#include <TopoDS_Face.hxx>
#include <algorithm>
#include <cctype>
#include <cstdio>
#include <map>
#include <new>

#include "common/scene_io/warning_group.h"
#include "master/import/cad/document.h"
#include "master/import/cad/messages.h"

namespace tessera::import::cad {
namespace {

bool is_step(const std::string& path) {
  std::string suffix = path.substr(std::min(path.rfind('.'), path.size()));
  for (char& c : suffix) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return suffix == ".step" || suffix == ".stp";
}

// Numbers and labels apart, messages of one kind are the same.
std::string kind_of(const std::string& message) {
  std::string kind;
  for (const char c : message)
    if (std::isdigit(static_cast<unsigned char>(c)) == 0) kind.push_back(c);
  return kind;
}

// The map of a file to the scene: +z, which is up in CAD files, becomes +y, and +y becomes -z.
Transform upright(const gp_Trsf& to_file) {
  Transform to_scene;
  for (std::size_t column = 0; column < 4; ++column) {
    const auto value = [&](int row) {
      return static_cast<float>(to_file.Value(row, static_cast<int>(column) + 1));
    };
    to_scene.m[0][column] = value(1);
    to_scene.m[1][column] = value(3);
    to_scene.m[2][column] = 0 - value(2);
  }
  return to_scene;
}

class SceneWriter {
 public:
  SceneWriter(const std::string& path, const Document& document, std::vector<PartReport>* reports)
      : document_(document), reports_(reports), warnings_(path) {}

  // Returns: the number of faces that became patches.
  std::size_t add_parts() {
    std::vector<std::uint32_t> surfaces;
    for (const Part& part : document_.parts) surfaces.push_back(add_part(part));
    for (const Placement& placement : document_.placements) {
      if (surfaces[placement.part] == kNoSurface) continue;
      read_.scene.instances.push_back(
          {surfaces[placement.part], upright(placement.part_to_file), ObjectKind::kPatchSurface});
    }
    return face_count_;
  }

  // Why the first face that was left out was.
  const std::string& first_lost() const { return first_lost_; }

  ReadScene finish(const std::vector<std::string>& messages) {
    char text[256];
    std::snprintf(text, sizeof text,
                  "%zu faces as %zu patches, lengths in %s; faces are apart by %.3g at most where "
                  "they share one of %zu edges; %zu edges are of one face",
                  face_count_, patch_count_, document_.unit.c_str(), gap_, shared_, open_);
    warnings_.add_once("sum", text);
    if (document_.sewing_tolerance > 0) {
      std::snprintf(text, sizeof text,
                    "%zu loose faces were sewn at %zu edges, where they meet within %.3g",
                    document_.sewn_faces, document_.sewn_edges, document_.sewing_tolerance);
      warnings_.add_once("sewn", text);
    }
    for (const std::string& message : messages) warnings_.add(kind_of(message), message);
    read_.warnings = warnings_.lines();
    return std::move(read_);
  }

 private:
  static constexpr std::uint32_t kNoSurface = 0xffffffffu;

  std::uint32_t add_part(const Part& part) {
    // A face's own colour, else its solid's or shell's.
    std::optional<Quantity_Color> whole = document_.color_of(part.shape);
    for (TopExp_Explorer shell(part.shape, TopAbs_SHELL); shell.More() && !whole; shell.Next())
      whole = document_.color_of(shell.Current());
    PartSurface made = part_surface(part.shape, [&](const TopoDS_Face& face) {
      const auto own = document_.color_of(face);
      return material(part.name, own ? own : whole);
    });
    const std::string name = part.name.empty() ? "" : "part '" + part.name + "', ";
    for (const std::string& line : made.report.lost) {
      warnings_.add_once(name + line, name + line);
      if (first_lost_.empty()) first_lost_ = name + line;
    }
    for (const std::string& line : made.report.warnings) warnings_.add(kind_of(line), name + line);
    gap_ = std::max(gap_, made.report.gap_max);
    shared_ += made.report.shared_edges;
    open_ += made.report.open_edges;
    face_count_ += made.report.faces.size() - made.report.lost.size();
    patch_count_ += made.surface.patches.size();
    if (reports_ != nullptr) reports_->push_back(std::move(made.report));
    if (made.surface.patches.empty()) return kNoSurface;
    auto& materials = made.surface.materials;
    if (std::ranges::all_of(materials, [&](std::uint32_t m) { return m == materials[0]; }))
      materials.resize(1);
    read_.scene.surfaces.push_back(std::make_shared<const PatchSurface>(std::move(made.surface)));
    return static_cast<std::uint32_t>(read_.scene.surfaces.size() - 1);
  }

  std::uint32_t material(const std::string& name, const std::optional<Quantity_Color>& color) {
    Material made;
    made.name = name;
    if (color) {
      double r, g, b;
      color->Values(r, g, b, Quantity_TOC_RGB);
      made.albedo = {static_cast<float>(r), static_cast<float>(g), static_cast<float>(b)};
    }
    auto& all = read_.scene.materials;
    const auto known = std::ranges::find(all, made);
    if (known != all.end()) return static_cast<std::uint32_t>(known - all.begin());
    all.push_back(std::move(made));
    return static_cast<std::uint32_t>(all.size() - 1);
  }

  const Document& document_;
  std::vector<PartReport>* reports_;
  WarningGroup warnings_;
  std::string first_lost_;
  ReadScene read_;
  double gap_ = 0;
  std::size_t shared_ = 0, open_ = 0, face_count_ = 0, patch_count_ = 0;
};

Result<ReadScene> read_quietly(const std::string& path, std::vector<PartReport>* reports,
                               Messages& messages) {
  const auto document = is_step(path) ? read_step(path) : read_iges(path);
  if (!document.is_ok()) return document.status();
  SceneWriter writer(path, *document, reports);
  if (writer.add_parts() == 0)
    return Status::invalid_argument(path + ": no face is left: " + writer.first_lost());
  return writer.finish(messages.take());
}

}  // namespace

Result<ReadScene> read_cad(const std::string& path, std::vector<PartReport>* reports) {
  Messages messages;
  try {
    return read_quietly(path, reports, messages);
  } catch (const Standard_OutOfMemory&) {
    throw std::bad_alloc();
  } catch (const Standard_Failure& failure) {
    return Status::invalid_argument(path + ": Open CASCADE gave up: " + failure.GetMessageString());
  }
}

}  // namespace tessera::import::cad
