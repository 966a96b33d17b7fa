// SPDX-License-Identifier: Apache-2.0
#include "tests/bench/cad_field/field.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdlib>
#include <fstream>
#include <limits>
#include <memory>
#include <utility>

#include "common/scene/validate.h"
#include "master/import/cad/reader.h"

namespace tessera::bench {
namespace {

constexpr std::uint64_t kCopiesMax = 10'000;

// The map that makes the diagonal of a scene's control points 1 and puts it on the ground.
Transform to_cell(const Scene& scene) {
  constexpr float kFar = std::numeric_limits<float>::infinity();
  Vec3f low{kFar, kFar, kFar}, high{-kFar, -kFar, -kFar};
  for (const Instance& instance : scene.instances) {
    for (PatchCursor at(*scene.surfaces[instance.mesh]); at.is_any(); at.advance()) {
      for (std::size_t i = 0; i < at.form().point_count(); ++i) {
        const Vec3f p = instance.object_to_world.point(at.point(i));
        low = {std::min(low.x, p.x), std::min(low.y, p.y), std::min(low.z, p.z)};
        high = {std::max(high.x, p.x), std::max(high.y, p.y), std::max(high.z, p.z)};
      }
    }
  }
  const float scale = 1 / length(high - low);
  const Vec3f middle = (low + high) * 0.5f;
  Transform made;
  for (std::size_t i = 0; i < 3; ++i) made.m[i][i] = scale;
  made.m[0][3] = -scale * middle.x;
  made.m[1][3] = -scale * low.y;
  made.m[2][3] = -scale * middle.z;
  return made;
}

Transform cell_to_field(std::size_t number, std::size_t side) {
  constexpr float kCosine[4] = {1, 0, -1, 0}, kSine[4] = {0, 1, 0, -1};
  const std::size_t x = number % side, z = number / side, turn = (x + 2 * z) % 4;
  Transform made;
  made.m[0] = {kCosine[turn], 0, kSine[turn], static_cast<float>(x)};
  made.m[2] = {-kSine[turn], 0, kCosine[turn], static_cast<float>(z)};
  return made;
}

// Adds what an instance shows to a surface in the field's coordinates.
void add_flattened(const PatchSurface& given, const Transform& to_field, PatchSurface& flat) {
  const auto add = [](auto& to, const auto& from) {
    to.insert(to.end(), from.begin(), from.end());
  };
  for (PatchCursor at(given); at.is_any(); at.advance()) {
    for (std::size_t i = 0; i < at.form().point_count(); ++i) {
      const Vec3f p = to_field.point(at.point(i));
      add(flat.numbers, std::vector<float>{p.x, p.y, p.z});
      if (at.form().is_rational != 0) flat.numbers.push_back(at.weight(i));
    }
    flat.materials.push_back(at.material());
    flat.loop_counts.push_back(static_cast<std::uint32_t>(at.loop_count()));
  }
  add(flat.patches, given.patches);
  add(flat.segment_counts, given.segment_counts);
  add(flat.degrees, given.degrees);
  add(flat.trim_points, given.trim_points);
  const float scale = length(to_field.direction({1, 0, 0}));
  for (std::size_t i = 0; i < given.degrees.size(); ++i)
    flat.trim_widths.push_back(given.trim_widths.empty() ? 0 : scale * given.trim_widths[i]);
}

void count(const PatchSurface& surface, std::uint64_t times, FieldCounts& counts) {
  for (PatchCursor at(surface); at.is_any(); at.advance())
    counts.patches_with_loops += at.loop_count() > 0 ? times : 0;
  counts.patches += times * surface.patches.size();
  counts.segments += times * surface.degrees.size();
  counts.loops += times * surface.segment_counts.size();
}

// Adds all copies of one file; `index` of `files`.
void add_copies(Scene file, const FieldPlan& plan, std::size_t index, Scene& field) {
  const std::size_t side = static_cast<std::size_t>(
      std::ceil(std::sqrt(static_cast<double>(plan.copies * plan.files.size()))));
  const Transform scaled = to_cell(file);
  const auto first_material = static_cast<std::uint32_t>(field.materials.size());
  const auto first_surface = static_cast<std::uint32_t>(field.surfaces.size());
  field.materials.insert(field.materials.end(), file.materials.begin(), file.materials.end());
  for (auto& surface : file.surfaces) {
    PatchSurface moved = *surface;
    for (std::uint32_t& material : moved.materials) material += first_material;
    surface = std::make_shared<const PatchSurface>(std::move(moved));
    if (!plan.is_flat) field.surfaces.push_back(surface);
  }
  for (std::uint64_t copy = 0; copy < plan.copies; ++copy) {
    // Neighbours are of different files.
    const Transform to_field = cell_to_field(copy * plan.files.size() + index, side) * scaled;
    PatchSurface flat;
    for (const Instance& instance : file.instances) {
      const Transform all = to_field * instance.object_to_world;
      if (plan.is_flat) {
        add_flattened(*file.surfaces[instance.mesh], all, flat);
      } else {
        field.instances.push_back({first_surface + instance.mesh, all, ObjectKind::kPatchSurface});
      }
    }
    if (!plan.is_flat) continue;
    const auto number = static_cast<std::uint32_t>(field.surfaces.size());
    field.surfaces.push_back(std::make_shared<const PatchSurface>(std::move(flat)));
    field.instances.push_back({number, Transform{}, ObjectKind::kPatchSurface});
  }
}

}  // namespace

Result<FieldPlan> read_plan(const std::string& path) {
  std::ifstream file(path);
  FieldPlan plan;
  std::string word, value;
  while (file >> word && std::getline(file >> std::ws, value)) {
    if (word == "copies") {
      plan.copies = std::strtoull(value.c_str(), nullptr, 10);
    } else if (word == "arrange" && (value == "flat" || value == "instances")) {
      plan.is_flat = value == "flat";
    } else if (word == "file") {
      plan.files.push_back(value);
    } else {
      return Status::invalid_argument(path + ": '" + word + " " + value +
                                      "' is no line of a field");
    }
  }
  if (plan.copies < 1 || plan.copies > kCopiesMax || plan.files.empty())
    return Status::invalid_argument(path + ": needs copies (1 to 10000) and files");
  return plan;
}

Result<Scene> make_field(const FieldPlan& plan) {
  Scene field;
  for (std::size_t i = 0; i < plan.files.size(); ++i) {
    auto read = import::cad::read_cad(plan.files[i]);
    if (!read.is_ok()) return read.status();
    add_copies(std::move(read->scene), plan, i, field);
  }
  TESSERA_RETURN_IF_ERROR(validate_scene(field));
  return field;
}

FieldCounts counts_of(const Scene& field) {
  FieldCounts counts;
  std::vector<std::uint64_t> uses(field.surfaces.size());
  for (const Instance& instance : field.instances) ++uses[instance.mesh];
  for (std::size_t i = 0; i < uses.size(); ++i) count(*field.surfaces[i], uses[i], counts);
  return counts;
}

}  // namespace tessera::bench
