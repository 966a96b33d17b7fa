// SPDX-License-Identifier: Apache-2.0
#include "master/image/plugin_loader.h"

#include <iterator>

#include "common/base/plugin_library.h"

namespace tessera::master {
namespace {

Result<ImagePlugin> load() {
  constexpr const char* kNames[] = {kEncodeImageName, kReadImageName, kOpenPictureName,
                                    kReadPictureName, kClosePictureName};
  void* functions[std::size(kNames)] = {};
  const Status status = load_plugin("tessera_image_oiio.so", kNames, functions);
  if (!status.is_ok())
    return Status::not_found("cannot load tessera_image_oiio.so: " + status.message() +
                             "; install tessera completely");
  ImagePlugin plugin;
  plugin.encode = reinterpret_cast<EncodeImageFunction>(functions[0]);
  plugin.read = reinterpret_cast<ReadImageFunction>(functions[1]);
  plugin.open_picture = reinterpret_cast<OpenPictureFunction>(functions[2]);
  plugin.read_picture = reinterpret_cast<ReadPictureFunction>(functions[3]);
  plugin.close_picture = reinterpret_cast<ClosePictureFunction>(functions[4]);
  return plugin;
}

}  // namespace

Result<ImagePlugin> image_plugin() {
  static const Result<ImagePlugin> plugin = load();
  return plugin;
}

}  // namespace tessera::master
