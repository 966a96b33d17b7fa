// SPDX-License-Identifier: Apache-2.0
#include "master/image/plugin_loader.h"

#include <iterator>

#include "common/base/plugin_library.h"

namespace tessera::master {
namespace {

Result<ImagePlugin> load() {
  constexpr const char* kNames[] = {kBeginImageName,  kWriteRowsName,   kEndImageName,
                                    kOpenPictureName, kReadPictureName, kMakeLinearName,
                                    kAttributesName,  kClosePictureName};
  void* functions[std::size(kNames)] = {};
  const Status status = load_plugin(kImagePluginFile, kNames, functions);
  if (!status.is_ok())
    return Status::not_found("cannot load tessera_image_oiio.so: " + status.message() +
                             "; install tessera completely");
  ImagePlugin plugin;
  plugin.begin_image = reinterpret_cast<BeginImageFunction>(functions[0]);
  plugin.write_rows = reinterpret_cast<WriteRowsFunction>(functions[1]);
  plugin.end_image = reinterpret_cast<EndImageFunction>(functions[2]);
  plugin.open_picture = reinterpret_cast<OpenPictureFunction>(functions[3]);
  plugin.read_picture = reinterpret_cast<ReadPictureFunction>(functions[4]);
  plugin.make_linear = reinterpret_cast<MakeLinearFunction>(functions[5]);
  plugin.attributes = reinterpret_cast<AttributesFunction>(functions[6]);
  plugin.close_picture = reinterpret_cast<ClosePictureFunction>(functions[7]);
  return plugin;
}

}  // namespace

Result<ImagePlugin> image_plugin() {
  static const Result<ImagePlugin> plugin = load();
  return plugin;
}

}  // namespace tessera::master
