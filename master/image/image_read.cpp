#include "master/image/image_read.h"

#include <cstdlib>
#include <cstring>
#include <memory>

#include "master/image/plugin_loader.h"

namespace tessera::master {
namespace {
struct FreeMalloc {
  void operator()(float* p) const { std::free(p); }
};
}  // namespace

Result<FloatImage> read_image(const std::string& path) {
  auto plugin = image_plugin();
  if (!plugin.is_ok()) return plugin.status();
  FloatImage image;
  float* rgb = nullptr;
  char error[512] = {};
  if (plugin->read(path.c_str(), &image.width_px, &image.height_px, &rgb, error, sizeof(error)) !=
      0) {
    return Status::data_loss("cannot read " + path + ": " + error);
  }
  const std::unique_ptr<float, FreeMalloc> owner(rgb);
  image.rgb.resize(3 * static_cast<std::size_t>(image.width_px) *
                   static_cast<std::size_t>(image.height_px));
  std::memcpy(image.rgb.data(), rgb, image.rgb.size() * sizeof(float));
  return image;
}

}  // namespace tessera::master
