// SPDX-License-Identifier: Apache-2.0
#include "common/scene_io/camera_file.h"

#include <algorithm>
#include <charconv>
#include <cmath>

#include "common/base/limits.h"
#include "common/scene/validate.h"
#include "common/scene_io/text_scanner.h"

namespace tessera {
namespace {

constexpr std::uint64_t kCameraFileBytesMax = 16 << 20;

float catmull_rom(float a, float b, float c, float d, float t) {
  return b + 0.5f * t * (c - a + t * (2 * a - 5 * b + 4 * c - d + t * (3 * (b - c) + d - a)));
}

Vec3f catmull_rom(Vec3f a, Vec3f b, Vec3f c, Vec3f d, float t) {
  return {catmull_rom(a.x, b.x, c.x, d.x, t), catmull_rom(a.y, b.y, c.y, d.y, t),
          catmull_rom(a.z, b.z, c.z, d.z, t)};
}

// Reader of one file.
struct CameraReader {
  std::string path;
  TextScanner scanner;
  std::vector<CameraPath::Key> keys;
  Camera common;  // keys before the first "frame"
  bool has_frames = false;
  std::optional<ImageSize> size;

  Status wrong(const std::string& text) const {
    return Status::invalid_argument(path + ":" + std::to_string(scanner.line_number()) + ": " +
                                    text);
  }
  Camera& current() { return has_frames ? keys.back().camera : common; }

  Status read_vector(const std::string& key, Vec3f& value) {
    const auto x = scanner.number<float>(), y = scanner.number<float>(),
               z = scanner.number<float>();
    if (!x || !y || !z || !scanner.word().empty())
      return wrong("'" + key + "' needs three numbers");
    value = {*x, *y, *z};
    return Status::ok();
  }

  Status read_line() {
    const std::string key(scanner.word());
    if (key.empty() || key.front() == '#') return Status::ok();
    Vec3f ignored;
    if (key == "eye") return read_vector(key, current().eye);
    if (key == "target" || key == "at") return read_vector(key, current().target);
    if (key == "up") return read_vector(key, current().up);
    if (key == "light") return read_vector(key, ignored);
    if (key == "vfov" || key == "fov") {
      const auto degrees = scanner.number<float>();
      if (!degrees) return wrong("'" + key + "' needs an angle in degrees");
      current().vfov_degrees = *degrees;
      return Status::ok();
    }
    if (key == "size") {
      const auto w = scanner.number<int>(), h = scanner.number<int>();
      if (!w || !h || *w < 1 || *h < 1 || *w > kImageSideMaxPx || *h > kImageSideMaxPx) {
        return wrong("'size' needs width and height in pixels, each 1 to " +
                     std::to_string(kImageSideMaxPx));
      }
      size = ImageSize{*w, *h};
      return Status::ok();
    }
    if (key == "frame") {
      const auto number = scanner.number<long>();
      if (!number || *number < 0) return wrong("'frame' needs a number from 0");
      if (!keys.empty() && static_cast<double>(*number) <= keys.back().frame)
        return wrong("frames must rise");
      keys.push_back({static_cast<double>(*number), has_frames ? keys.back().camera : common});
      has_frames = true;
      return Status::ok();
    }
    return wrong("unknown key '" + key + "'; known are eye, target, up, vfov, size, light, frame");
  }
};

}  // namespace

Camera CameraPath::at(double frame) const {
  if (frame <= keys_.front().frame) return keys_.front().camera;
  if (frame >= keys_.back().frame) return keys_.back().camera;
  std::size_t i = 0;
  while (keys_[i + 1].frame <= frame) ++i;
  const Camera& a = keys_[i > 0 ? i - 1 : 0].camera;
  const Camera& b = keys_[i].camera;
  const Camera& c = keys_[i + 1].camera;
  const Camera& d = keys_[std::min(i + 2, keys_.size() - 1)].camera;
  const auto t =
      static_cast<float>((frame - keys_[i].frame) / (keys_[i + 1].frame - keys_[i].frame));
  Camera camera;
  camera.eye = catmull_rom(a.eye, b.eye, c.eye, d.eye, t);
  camera.target = catmull_rom(a.target, b.target, c.target, d.target, t);
  camera.up = catmull_rom(a.up, b.up, c.up, d.up, t);
  camera.vfov_degrees =
      catmull_rom(a.vfov_degrees, b.vfov_degrees, c.vfov_degrees, d.vfov_degrees, t);
  return camera;
}

Result<CameraPath> read_camera_file(const std::string& path) {
  auto text = read_whole_file(path, kCameraFileBytesMax);
  if (!text.is_ok()) return Status(text.status().code(), "camera file " + text.status().message());
  CameraReader reader{path, TextScanner(*text), {}, {}, false, {}};
  while (reader.scanner.next_line()) TESSERA_RETURN_IF_ERROR(reader.read_line());
  if (reader.keys.empty()) reader.keys.push_back({0, reader.common});
  for (const CameraPath::Key& key : reader.keys) {
    if (const Status status = validate_camera(key.camera); !status.is_ok()) {
      return Status::invalid_argument(path + ", frame " +
                                      std::to_string(static_cast<long>(key.frame)) + ": " +
                                      status.message());
    }
  }
  return CameraPath(std::move(reader.keys), reader.size);
}

Result<Camera> parse_camera_text(const std::string& text) {
  std::string spaced = text;
  std::replace(spaced.begin(), spaced.end(), ',', ' ');
  TextScanner scanner(spaced);
  scanner.next_line();
  float v[10] = {};
  for (float& value : v) {
    const auto number = scanner.number<float>();
    if (!number)
      return Status::invalid_argument(
          "give \"ex,ey,ez lx,ly,lz ux,uy,uz fov\" or a camera file, not '" + text + "'");
    value = *number;
  }
  if (!scanner.word().empty())
    return Status::invalid_argument("'" + text + "' has more than ten numbers");
  const Camera camera{{v[0], v[1], v[2]}, {v[3], v[4], v[5]}, {v[6], v[7], v[8]}, v[9]};
  TESSERA_RETURN_IF_ERROR(validate_camera(camera));
  return camera;
}

std::string camera_text(const Camera& camera) {
  std::string text;
  // Appends the shortest digits that are read as the same number again.
  const auto add = [&text](float value, const char* behind) {
    char digits[32];
    const auto end = std::to_chars(digits, digits + sizeof(digits), value).ptr;
    text.append(digits, end).append(behind);
  };
  for (const Vec3f& v : {camera.eye, camera.target, camera.up}) {
    add(v.x, ",");
    add(v.y, ",");
    add(v.z, " ");
  }
  add(camera.vfov_degrees, "");
  return text;
}

}  // namespace tessera
