// SPDX-License-Identifier: Apache-2.0
#include "master/import/gltf/primitive.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "master/import/gltf/accessor.h"
#include "master/import/gltf/draco_mesh.h"
#include "master/import/gltf/tangent_space.h"

namespace tessera::import {
namespace {

constexpr std::uint64_t kModeTriangles = 4, kModeStrip = 5, kModeFan = 6;
constexpr const char* kModeNames[] = {"points", "lines", "line loops", "line strips"};

// A unit vector of 8 bits is off by up to 1/127 in each part.
constexpr float kUnitSlack = 0.02f;

class PrimitiveReader {
 public:
  PrimitiveReader(GltfDocument& document, const GltfObject& primitive, GltfMaterials& materials)
      : document_(document),
        primitive_(primitive),
        attributes_(primitive.object("attributes")),
        materials_(materials) {}

  Result<GltfPrimitive> read() {
    primitive_.check_keys({"attributes", "indices", "material", "mode", "targets"},
                          {"KHR_draco_mesh_compression", "KHR_materials_variants"});
    const auto mode = primitive_.refused_whole("mode", kModeTriangles, 0, kModeFan);
    if (!mode.is_ok()) return mode.status();
    if (*mode < kModeTriangles) {
      primitive_.warn("mode", std::string("is ") + kModeNames[*mode] +
                                  ", which have no surface and are left out");
      return GltfPrimitive();
    }
    TESSERA_RETURN_IF_ERROR(unpack());
    const auto positions = find("POSITION", 3, 3);
    if (!positions.is_ok()) return positions.status();
    if (!*positions) {
      primitive_.warn("attributes.POSITION", "is missing, and the primitive is left out");
      return GltfPrimitive();
    }
    vertex_count_ = (*positions)->count();
    TESSERA_RETURN_IF_ERROR(read_indices());
    form_triangles(*mode);
    choose_vertices();
    TESSERA_RETURN_IF_ERROR(read_positions(**positions));
    TESSERA_RETURN_IF_ERROR(read_looks());
    auto deformation = read_deformation(
        document_, primitive_,
        {[this](const auto& name, auto low, auto high) { return find(name, low, high); },
         [this](std::size_t vertex) { return source_of(vertex); }, chosen_count_, vertex_count_});
    if (!deformation.is_ok()) return deformation.status();
    return GltfPrimitive{mesh_, *std::move(deformation)};
  }

 private:
  Status unpack() {
    const GltfObject packed = primitive_.extension("KHR_draco_mesh_compression");
    if (!packed.is_there()) return Status::ok();
    auto unpacked = unpack_draco(document_, packed, attributes_);
    if (!unpacked.is_ok()) return unpacked.status();
    draco_ = std::move(*unpacked);
    return Status::ok();
  }

  // An attribute of `low` to `high` components. Returns: nothing when it is absent.
  Result<std::optional<GltfAccessor>> find(const std::string& name, std::size_t low,
                                           std::size_t high) {
    std::optional<GltfAccessor> found;
    if (const auto packed = draco_.attributes.find(name); packed != draco_.attributes.end()) {
      found = packed->second;
    } else {
      const auto index = attributes_.refused_index(name, document_.count("accessors"));
      if (!index.is_ok()) return index.status();
      if (!*index) return found;
      auto accessor = GltfAccessor::open(document_, **index);
      if (!accessor.is_ok()) return accessor.status();
      found = std::move(*accessor);
    }
    const bool is_whole_index = found->type() == ComponentType::kUint32;
    if (found->components() >= low && found->components() <= high && !is_whole_index) {
      if (name == "POSITION" || found->count() >= vertex_count_) return found;
      return attributes_.refuse(name, "has " + std::to_string(found->count()) +
                                          " elements, but POSITION has " +
                                          std::to_string(vertex_count_));
    }
    return attributes_.refuse(name, "is " + found->name() + ", whose type it cannot have");
  }

  Status read_indices() {
    if (!draco_.indices.empty()) {
      indices_ = std::move(draco_.indices);
    } else {
      const auto index = primitive_.refused_index("indices", document_.count("accessors"));
      if (!index.is_ok()) return index.status();
      if (!*index) {
        indices_.resize(vertex_count_);
        for (std::size_t i = 0; i < vertex_count_; ++i) indices_[i] = static_cast<std::uint32_t>(i);
        return Status::ok();
      }
      const auto source = GltfAccessor::open(document_, **index);
      if (!source.is_ok()) return source.status();
      const ComponentType type = source->type();
      const bool is_unsigned = type == ComponentType::kUint8 || type == ComponentType::kUint16 ||
                               type == ComponentType::kUint32;
      if (source->components() != 1 || !is_unsigned)
        return primitive_.refuse("indices", "are no unsigned scalars");
      indices_.resize(source->count());
      for (std::size_t i = 0; i < indices_.size(); ++i) indices_[i] = source->read_index(i);
    }
    for (std::size_t i = 0; i < indices_.size(); ++i) {
      if (indices_[i] < vertex_count_) continue;
      return primitive_.refuse("indices", "hold " + std::to_string(indices_[i]) + " at " +
                                              std::to_string(i) + ", but there are " +
                                              std::to_string(vertex_count_) + " vertices");
    }
    return Status::ok();
  }

  // Forms triangles with the corners in the specification's order, so that all turn the same way.
  void form_triangles(std::uint64_t mode) {
    const std::size_t count = indices_.size();
    auto& triangles = mesh_->triangles;
    if (mode == kModeTriangles || !draco_.attributes.empty()) {
      if (count % 3 != 0) {
        primitive_.warn("indices", "end in the middle of a triangle, which is left out");
      }
      triangles.reserve(count / 3);
      for (std::size_t i = 0; i + 2 < count; i += 3)
        triangles.push_back({indices_[i], indices_[i + 1], indices_[i + 2]});
      return;
    }
    if (count < 3) primitive_.warn("indices", "are fewer than a triangle has");
    for (std::size_t i = 0; i + 2 < count; ++i) {
      const std::array<std::uint32_t, 3> t =
          mode == kModeStrip
              ? std::array{indices_[i], indices_[i + 1 + i % 2], indices_[i + 2 - i % 2]}
              : std::array{indices_[i + 1], indices_[i + 2], indices_[0]};
      // Triangles that join strips have a vertex twice.
      if (t[0] != t[1] && t[1] != t[2] && t[2] != t[0]) triangles.push_back(t);
    }
  }

  // Primitives often share the vertices of a whole model: only vertices that are used are kept, in
  // their order.
  void choose_vertices() {
    std::vector<std::uint32_t>().swap(indices_);
    auto& triangles = mesh_->triangles;
    if (3 * triangles.size() >= vertex_count_) {
      chosen_count_ = vertex_count_;
      return;
    }
    for (const auto& triangle : triangles)
      chosen_.insert(chosen_.end(), triangle.begin(), triangle.end());
    std::sort(chosen_.begin(), chosen_.end());
    chosen_.erase(std::unique(chosen_.begin(), chosen_.end()), chosen_.end());
    for (auto& triangle : triangles) {
      for (std::uint32_t& vertex : triangle) {
        vertex = static_cast<std::uint32_t>(
            std::lower_bound(chosen_.begin(), chosen_.end(), vertex) - chosen_.begin());
      }
    }
    chosen_count_ = chosen_.size();
  }
  std::size_t source_of(std::size_t vertex) const {
    return chosen_.empty() ? vertex : chosen_[vertex];
  }

  Status read_positions(const GltfAccessor& source) {
    mesh_->positions.resize(chosen_count_);
    for (std::size_t i = 0; i < chosen_count_; ++i) {
      const auto p = source.read(source_of(i));
      mesh_->positions[i] = {p[0], p[1], p[2]};
      if (!is_finite(mesh_->positions[i])) {
        return attributes_.refuse("POSITION",
                                  "of vertex " + std::to_string(source_of(i)) + " is not finite");
      }
    }
    return Status::ok();
  }

  Status read_looks() {
    const auto index =
        primitive_.index("material", document_.count("materials"), "the default material is used");
    const GltfMaterial& material = materials_.read(index);
    mesh_->materials = {material.index};
    TESSERA_RETURN_IF_ERROR(read_normals());
    TESSERA_RETURN_IF_ERROR(read_coordinates(material.uv_sets[0], mesh_->uvs));
    if (material.uses_second_set)
      TESSERA_RETURN_IF_ERROR(read_coordinates(material.uv_sets[1], mesh_->uvs1));
    TESSERA_RETURN_IF_ERROR(read_colors());
    TESSERA_RETURN_IF_ERROR(read_tangents(material));
    name_other_attributes();
    return Status::ok();
  }

  // A normal that is not finite becomes zero, which the renderer takes for the flat normal.
  Status read_normals() {
    const auto source = find("NORMAL", 3, 3);
    if (!source.is_ok()) return source.status();
    if (!*source) return Status::ok();
    std::size_t bad_count = 0;
    mesh_->normals.resize(chosen_count_);
    for (std::size_t i = 0; i < chosen_count_; ++i) {
      const auto n = (*source)->read(source_of(i));
      mesh_->normals[i] = {n[0], n[1], n[2]};
      if (is_finite(mesh_->normals[i])) continue;
      mesh_->normals[i] = {};
      ++bad_count;
    }
    if (bad_count > 0) attributes_.warn("NORMAL", counted(bad_count) + "; they are flat there");
    return Status::ok();
  }

  Status read_coordinates(std::uint32_t set, std::vector<Vec2f>& uvs) {
    const std::string name = "TEXCOORD_" + std::to_string(set);
    const auto source = find(name, 2, 2);
    if (!source.is_ok()) return source.status();
    if (!*source) return Status::ok();
    std::size_t bad_count = 0;
    uvs.resize(chosen_count_);
    for (std::size_t i = 0; i < chosen_count_; ++i) {
      const auto uv = (*source)->read(source_of(i));
      uvs[i] = {uv[0], 1 - uv[1]};  // the file's v points down
      if (is_finite(uvs[i])) continue;
      uvs[i] = {};
      ++bad_count;
    }
    if (bad_count > 0) attributes_.warn(name, counted(bad_count) + "; 0 is used");
    return Status::ok();
  }

  Status read_colors() {
    const auto source = find("COLOR_0", 3, 4);
    if (!source.is_ok()) return source.status();
    if (!*source) return Status::ok();
    std::size_t bad_count = 0;
    mesh_->colors.resize(chosen_count_);
    for (std::size_t i = 0; i < chosen_count_; ++i) {
      auto c = (*source)->read(source_of(i));
      if ((*source)->components() == 3) c[3] = 1;
      bool is_good = true;
      for (float& x : c) {
        is_good = is_good && x >= 0 && x <= 1;
        x = std::isnan(x) ? 1 : std::clamp(x, 0.0f, 1.0f);
      }
      mesh_->colors[i] = {c[0], c[1], c[2], c[3]};
      bad_count += is_good ? 0 : 1;
    }
    if (bad_count > 0)
      attributes_.warn("COLOR_0", "must be from 0 to 1; what is not is brought there");
    return Status::ok();
  }

  // The specification asks for computed tangents where normals are missing, too. There the
  // renderer's own tangents, of flat triangles, are the same.
  Status read_tangents(const GltfMaterial& material) {
    if (!material.tangent_set || mesh_->normals.empty()) return Status::ok();
    const auto source = find("TANGENT", 4, 4);
    if (!source.is_ok()) return source.status();
    if (*source) {
      std::size_t bad_count = 0;
      mesh_->tangents.resize(chosen_count_);
      for (std::size_t i = 0; i < chosen_count_; ++i) {
        const auto t = (*source)->read(source_of(i));
        const float size = std::sqrt(t[0] * t[0] + t[1] * t[1] + t[2] * t[2]);
        bad_count += std::fabs(size - 1) < kUnitSlack ? 0 : 1;
        mesh_->tangents[i] = {t[0], t[1], t[2], t[3] < 0 ? -1.0f : 1.0f};
        if (!is_finite(mesh_->tangents[i]) || !(size > 0)) mesh_->tangents[i] = {0, 0, 0, 1};
      }
      if (bad_count == 0) return Status::ok();
      attributes_.warn("TANGENT", "of " + std::to_string(bad_count) +
                                      " vertices are no unit vectors; tangents are computed");
      mesh_->tangents.clear();
    }
    const auto& uvs = *material.tangent_set == 0 ? mesh_->uvs : mesh_->uvs1;
    if (!uvs.empty()) make_tangents(*mesh_, uvs);
    return Status::ok();
  }

  // Coordinates that no texture uses, and tangents without a normal map, have no effect. Names that
  // begin with "_" are an application's.
  void name_other_attributes() const {
    for (const std::string& name : attributes_.keys()) {
      const bool is_known =
          name == "POSITION" || name == "NORMAL" || name == "TANGENT" || name == "COLOR_0";
      const bool is_silent = name.starts_with("TEXCOORD_") || name.starts_with("JOINTS_") ||
                             name.starts_with("WEIGHTS_") || name.starts_with("_");
      if (!is_known && !is_silent) attributes_.warn(printable(name), "is not read");
    }
  }

  static std::string counted(std::size_t bad_count) {
    return "of " + std::to_string(bad_count) + " vertices are not finite";
  }

  GltfDocument& document_;
  const GltfObject& primitive_;
  const GltfObject attributes_;
  GltfMaterials& materials_;
  DracoMesh draco_;
  std::size_t vertex_count_ = 0;        // of the file's accessors
  std::vector<std::uint32_t> indices_;  // each below vertex_count_
  std::vector<std::uint32_t> chosen_;   // vertices that are kept; empty: all
  std::size_t chosen_count_ = 0;
  const std::shared_ptr<Mesh> mesh_ = std::make_shared<Mesh>();
};

}  // namespace

Result<GltfPrimitive> read_primitive(GltfDocument& document, const GltfObject& primitive,
                                     GltfMaterials& materials) {
  return PrimitiveReader(document, primitive, materials).read();
}

}  // namespace tessera::import
