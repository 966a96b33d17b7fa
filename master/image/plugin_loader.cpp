// SPDX-License-Identifier: Apache-2.0
#include "master/image/plugin_loader.h"

#include <dlfcn.h>

#include <filesystem>
#include <string>

namespace tessera::master {
namespace {

constexpr const char* kFileName = "tessera_image_oiio.so";

Result<ImagePlugin> load() {
  std::error_code error;
  const std::filesystem::path bin =
      std::filesystem::read_symlink("/proc/self/exe", error).parent_path();
  std::string reason;
  for (const auto& folder : {bin, bin / "../lib/tessera"}) {
    const std::filesystem::path path = folder / kFileName;
    if (!std::filesystem::exists(path, error)) continue;
    void* const library = dlopen(path.c_str(), RTLD_NOW | RTLD_LOCAL);
    if (library == nullptr) {
      const char* text = dlerror();
      reason = text != nullptr ? text : "unknown";
      continue;
    }
    ImagePlugin plugin;
    plugin.encode = reinterpret_cast<EncodeImageFunction>(dlsym(library, kEncodeImageName));
    plugin.read = reinterpret_cast<ReadImageFunction>(dlsym(library, kReadImageName));
    plugin.open_picture = reinterpret_cast<OpenPictureFunction>(dlsym(library, kOpenPictureName));
    plugin.read_picture = reinterpret_cast<ReadPictureFunction>(dlsym(library, kReadPictureName));
    plugin.close_picture =
        reinterpret_cast<ClosePictureFunction>(dlsym(library, kClosePictureName));
    if (plugin.encode != nullptr && plugin.read != nullptr && plugin.open_picture != nullptr &&
        plugin.read_picture != nullptr && plugin.close_picture != nullptr) {
      return plugin;
    }
    reason = path.string() + " is of another build";
  }
  return Status::not_found(std::string("cannot load ") + kFileName + " from " + bin.string() +
                           " or ../lib/tessera" + (reason.empty() ? "" : ": " + reason) +
                           "; install tessera completely");
}

}  // namespace

Result<ImagePlugin> image_plugin() {
  static const Result<ImagePlugin> plugin = load();
  return plugin;
}

}  // namespace tessera::master
