// SPDX-License-Identifier: Apache-2.0
#include "master/image/plugin_loader.h"

#include <iterator>

#include "common/base/plugin_library.h"

namespace tessera::master {
namespace {

Result<ImagePlugin> load() {
  constexpr const char* kNames[] = {kBeginImageName,  kWriteRowsName,   kEndImageName,
                                    kReadImageName,   kOpenPictureName, kReadPictureName,
                                    kClosePictureName};
  void* functions[std::size(kNames)] = {};
  const Status status = load_plugin(kImagePluginFile, kNames, functions);
  if (!status.is_ok())
    return Status::not_found("cannot load tessera_image_oiio.so: " + status.message() +
                             "; install tessera completely");
  ImagePlugin plugin;
  plugin.begin_image = reinterpret_cast<BeginImageFunction>(functions[0]);
  plugin.write_rows = reinterpret_cast<WriteRowsFunction>(functions[1]);
  plugin.end_image = reinterpret_cast<EndImageFunction>(functions[2]);
  plugin.read = reinterpret_cast<ReadImageFunction>(functions[3]);
  plugin.open_picture = reinterpret_cast<OpenPictureFunction>(functions[4]);
  plugin.read_picture = reinterpret_cast<ReadPictureFunction>(functions[5]);
  plugin.close_picture = reinterpret_cast<ClosePictureFunction>(functions[6]);
  return plugin;
}

}  // namespace

Result<ImagePlugin> image_plugin() {
  static const Result<ImagePlugin> plugin = load();
  return plugin;
}

}  // namespace tessera::master
