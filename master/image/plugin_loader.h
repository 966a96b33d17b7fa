// SPDX-License-Identifier: Apache-2.0
// Finds and loads tessera_image_oiio.so when it is first asked for.
// Threads. Any; the library is loaded once, under the lock of a static, and stays.
#pragma once

#include "common/base/status.h"
#include "master/image/oiio_plugin.h"

namespace tessera::master {

inline constexpr const char* kImagePluginFile = "tessera_image_oiio.so";

struct ImagePlugin {
  BeginImageFunction begin_image = nullptr;
  WriteRowsFunction write_rows = nullptr;
  EndImageFunction end_image = nullptr;
  OpenPictureFunction open_picture = nullptr;
  ReadPictureFunction read_picture = nullptr;
  MakeLinearFunction make_linear = nullptr;
  AttributesFunction attributes = nullptr;
  ClosePictureFunction close_picture = nullptr;
};

// The plug-in, which is looked for beside the executable and in ../lib/tessera. Any thread.
// Returns: kNotFound saying where the plug-in was looked for.
Result<ImagePlugin> image_plugin();

}  // namespace tessera::master
