// SPDX-License-Identifier: Apache-2.0
#include "master/image/image_read.h"

#include <cstdlib>
#include <cstring>
#include <memory>

#include "master/image/plugin_loader.h"

namespace tessera::master {
namespace {
struct FreeMalloc {
  void operator()(void* p) const { std::free(p); }
};
}  // namespace

Result<FloatImage> read_image(const std::string& path) {
  auto plugin = image_plugin();
  if (!plugin.is_ok()) return plugin.status();
  FloatImage image;
  float* rgb = nullptr;
  char* attributes = nullptr;
  int is_display = 0;
  char error[512] = {};
  if (plugin->read(path.c_str(), &image.width_px, &image.height_px, &rgb, &is_display, &attributes,
                   error, sizeof(error)) != 0) {
    return Status::data_loss("cannot read " + path + ": " + error);
  }
  const std::unique_ptr<float, FreeMalloc> owner(rgb);
  const std::unique_ptr<char, FreeMalloc> texts(attributes);
  for (const char* text = attributes; text != nullptr && *text != '\0';
       text += std::strlen(text) + 1) {
    const char* const equals = std::strchr(text, '=');
    if (equals != nullptr) image.attributes.emplace(std::string(text, equals), equals + 1);
  }
  image.is_display = is_display != 0;
  image.rgb.resize(3 * static_cast<std::size_t>(image.width_px) *
                   static_cast<std::size_t>(image.height_px));
  std::memcpy(image.rgb.data(), rgb, image.rgb.size() * sizeof(float));
  return image;
}

}  // namespace tessera::master
