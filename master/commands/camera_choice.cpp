// SPDX-License-Identifier: Apache-2.0
#include "master/commands/camera_choice.h"

#include <sys/stat.h>

#include <algorithm>
#include <charconv>
#include <memory>

#include "common/scene/validate.h"
#include "common/viewpoint/scene_overview.h"

namespace tessera::master {
namespace {

constexpr std::size_t kListedMax = 12;

bool is_file(const std::string& path) {
  struct stat info {};
  return stat(path.c_str(), &info) == 0 && !S_ISDIR(info.st_mode);
}

// Names come from files and are printed in one line.
std::string printable(std::string name) {
  std::replace_if(
      name.begin(), name.end(), [](unsigned char c) { return c < 0x20 || c == 0x7f; }, '?');
  return name;
}

// A scene may have a camera and no list of them.
std::vector<NamedCamera> cameras_of(const Scene& scene) {
  if (!scene.cameras.empty() || !scene.camera) return scene.cameras;
  return {{"", *scene.camera}};
}

std::string list_of(const std::vector<NamedCamera>& cameras) {
  if (cameras.empty()) return "the scene has no cameras";
  std::string list = "the scene has ";
  for (std::size_t i = 0; i < std::min(cameras.size(), kListedMax); ++i) {
    list += (i > 0 ? ", " : "") + std::to_string(i + 1);
    if (!cameras[i].name.empty()) list += " '" + printable(cameras[i].name) + "'";
  }
  if (cameras.size() > kListedMax)
    list += " and " + std::to_string(cameras.size() - kListedMax) + " more";
  return list;
}

Result<Camera> find_camera(const std::vector<NamedCamera>& cameras, const std::string& text) {
  std::size_t number = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
  const bool is_number = error == std::errc() && end == text.data() + text.size();
  if (is_number && number >= 1 && number <= cameras.size()) return cameras[number - 1].camera;
  const auto named = std::find_if(cameras.begin(), cameras.end(),
                                  [&](const NamedCamera& c) { return c.name == text; });
  if (named != cameras.end()) return named->camera;
  return Status::not_found(
      "--camera " + printable(text) +
      ": there is no such camera file, and no camera of that number or name: " + list_of(cameras));
}

}  // namespace

Result<CameraChoice> CameraChoice::read(const MasterOptions& options) {
  CameraChoice choice;
  choice.text_ = options.camera;
  choice.inline_camera_ = options.inline_camera;
  if (options.camera.empty() || options.inline_camera || !is_file(options.camera)) return choice;
  auto path = read_camera_file(options.camera);
  if (!path.is_ok()) return path.status();
  choice.path_ = std::move(*path);
  return choice;
}

Status CameraChoice::settle(const Scene& scene, int width_px, int height_px) {
  if (path_) {
    camera_ = path_->at(0);
  } else if (inline_camera_) {
    camera_ = *inline_camera_;
  } else if (!text_.empty()) {
    const auto found = find_camera(cameras_of(scene), text_);
    if (!found.is_ok()) return found.status();
    camera_ = *found;
  } else if (scene.camera) {
    camera_ = *scene.camera;
  } else {
    const SceneOverview overview(scene);
    is_from_viewpoint_ = true;
    camera_ = overview.default_camera(double(width_px) / height_px);
    is_inside_ = overview.is_inside();
  }
  return Status::ok();
}

std::optional<std::size_t> CameraChoice::number_in(const Scene& scene) const {
  if (path_ || inline_camera_) return std::nullopt;
  for (std::size_t i = 0; i < scene.cameras.size(); ++i) {
    if (scene.cameras[i].camera == camera_) return i;
  }
  return std::nullopt;
}

Vec3f CameraChoice::orbit_centre(const Scene& scene) const {
  if (is_inside_) return camera_.eye;
  const Bounds3f bounds = scene_bounds(scene);
  const Vec3f sight = camera_.target - camera_.eye;
  const Vec3f middle = 0.5f * (bounds.lower + bounds.upper) - camera_.eye;
  const float ahead = dot(middle, sight) / dot(sight, sight);
  return ahead > 1 ? camera_.eye + ahead * sight : camera_.target;
}

std::function<Camera(const Camera& seen, double aspect)> camera_of_all(const Scene& scene) {
  return [scene, overview = std::shared_ptr<const SceneOverview>()](const Camera& seen,
                                                                    double aspect) mutable {
    if (!overview) overview = std::make_shared<const SceneOverview>(scene);
    return overview->camera_of_all(seen, aspect);
  };
}

}  // namespace tessera::master
