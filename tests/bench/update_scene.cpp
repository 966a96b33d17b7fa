// SPDX-License-Identifier: Apache-2.0
#include "tests/bench/update_scene.h"

#include <algorithm>
#include <cmath>
#include <memory>
#include <utility>

#include "common/base/check.h"

namespace tessera::bench {
namespace {

constexpr std::size_t kMaterials = 4;

std::vector<Vec3f> positions_of(int segments, float phase) {
  std::vector<Vec3f> positions;
  const auto count = static_cast<float>(segments);
  for (int y = 0; y <= segments; ++y) {
    for (int x = 0; x <= segments; ++x) {
      const float u = static_cast<float>(x) / count, v = static_cast<float>(y) / count;
      positions.push_back({0.9f * u, 0.9f * v, 0.1f * std::sin(9 * u + phase) * std::cos(7 * v)});
    }
  }
  return positions;
}

// Sheets differ, since a slave keeps meshes that are alike as one.
float phase_of(std::size_t object, float share) {
  return 6 * share + 0.1f * static_cast<float>(object);
}

std::shared_ptr<const Mesh> make_sheet(int segments, std::size_t object) {
  auto sheet = std::make_shared<Mesh>();
  sheet->positions = positions_of(segments, phase_of(object, 0));
  const auto row = static_cast<std::uint32_t>(segments) + 1;
  for (std::uint32_t y = 0; y + 1 < row; ++y) {
    for (std::uint32_t x = 0; x + 1 < row; ++x) {
      const std::uint32_t at = y * row + x;
      sheet->triangles.push_back({at, at + 1, at + row + 1});
      sheet->triangles.push_back({at, at + row + 1, at + row});
    }
  }
  sheet->materials = {static_cast<std::uint32_t>(object % kMaterials)};
  return sheet;
}

Material material_of(std::size_t index, float shade) {
  Material material;
  material.albedo = {shade, 0.2f + 0.2f * static_cast<float>(index), 0.5f};
  return material;
}

Light light_at(float x) {
  Light light;
  light.position = {x, 2, 5};
  light.intensity = {60, 60, 50};
  return light;
}

// In [0, 1), and another one for each step.
float share_of(int step) {
  const double turned = 0.618033988749895 * step;
  return static_cast<float>(turned - std::floor(turned));
}

}  // namespace

std::string_view edit_name(EditKind kind) {
  switch (kind) {
    case EditKind::kCamera:
      return "camera";
    case EditKind::kLight:
      return "light";
    case EditKind::kMaterial:
      return "material";
    case EditKind::kOneRigid:
      return "one object moved";
    case EditKind::kAllRigid:
      return "all objects moved";
    case EditKind::kSomeVertices:
      return "1 % of the vertices";
    case EditKind::kAllVertices:
      return "all vertices";
  }
  return "";
}

EditedScene::EditedScene(std::uint64_t triangles, std::size_t objects)
    : side_(static_cast<std::size_t>(std::ceil(std::sqrt(static_cast<double>(objects))))),
      segments_(std::max(
          1, static_cast<int>(std::lround(std::sqrt(static_cast<double>(triangles) /
                                                    (2 * static_cast<double>(objects))))))) {
  const float half = 0.5f * static_cast<float>(side_);
  camera_ = {{half, -half, 1.5f * half}, {half, half, 0}, {0, 0, 1}, 55};
  const auto check = [](const Status& status) { TESSERA_CHECK(status.is_ok()); };
  check(edits_.set_material(0, material_of(0, 0.5f)));
  for (std::size_t i = 1; i < kMaterials; ++i)
    check(edits_.add_material(material_of(i, 0.5f)).status());
  check(edits_.set_environment({0.3f, 0.3f, 0.4f}));
  check(edits_.add_light(light_at(4)).status());
  for (std::size_t i = 0; i < objects; ++i) {
    auto name = edits_.add_object(make_sheet(segments_, i), place_of(i, 0));
    check(name.status());
    names_.push_back(*name);
  }
}

Transform EditedScene::place_of(std::size_t object, float height) const {
  Transform place;
  place.m[0][3] = static_cast<float>(object % side_);
  place.m[1][3] = static_cast<float>(object / side_);
  place.m[2][3] = height;
  return place;
}

std::uint64_t EditedScene::triangles() const {
  const auto segments = static_cast<std::uint64_t>(segments_);
  return names_.size() * 2 * segments * segments;
}

Status EditedScene::change(EditKind kind) {
  const float share = share_of(++step_);
  switch (kind) {
    case EditKind::kCamera:
      camera_.eye.x = (0.4f + 0.2f * share) * static_cast<float>(side_);
      return Status::ok();
    case EditKind::kLight:
      return edits_.set_light(0, light_at(8 * share));
    case EditKind::kMaterial:
      return edits_.set_material(1, material_of(1, share));
    case EditKind::kOneRigid:
      return move(names_.size() / 2);
    case EditKind::kAllRigid:
      for (std::size_t i = 0; i < names_.size(); ++i) TESSERA_RETURN_IF_ERROR(move(i));
      return Status::ok();
    case EditKind::kSomeVertices:
    case EditKind::kAllVertices: {
      const auto row = static_cast<std::size_t>(segments_) + 1;
      const std::size_t all = names_.size() * row * row;
      return deform(kind == EditKind::kAllVertices ? all : std::max<std::size_t>(1, all / 100));
    }
  }
  return Status::ok();
}

Status EditedScene::move(std::size_t object) {
  const float height = 0.5f * share_of(step_ + static_cast<int>(object));
  return edits_.set_transform(names_[object], place_of(object, height));
}

// Moves the first vertices of the scene, so many.
Status EditedScene::deform(std::size_t vertices) {
  for (std::size_t object = 0; vertices > 0; ++object) {
    std::vector<Vec3f> moved = positions_of(segments_, phase_of(object, share_of(step_)));
    moved.resize(std::min(moved.size(), vertices));
    TESSERA_RETURN_IF_ERROR(edits_.set_positions(names_[object], 0, moved));
    vertices -= moved.size();
  }
  return Status::ok();
}

Scene EditedScene::apart() {
  Scene scene = edits_.scene();
  for (auto& mesh : scene.meshes) mesh = std::make_shared<const Mesh>(*mesh);
  return scene;
}

}  // namespace tessera::bench
