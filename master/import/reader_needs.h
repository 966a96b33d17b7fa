// SPDX-License-Identifier: Apache-2.0
// What the reader of a format needs besides the file itself: the file's folder, and a plug-in. The
// sandbox lets it have that and no more.
//
// Threads. One.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "common/scene_io/file_format.h"

namespace tessera::import {

struct ReaderNeeds {
  // Files and folders that the reader opens: formats that name no other file have the file alone;
  // the others its folder, and where the picture plug-in and its libraries lie, since these are
  // loaded for the first picture that there is.
  std::vector<std::string> files;
  // Loads the plug-in that the reader is sure to need: for pictures of a sky, for CAD files. A
  // failure is kept, and told by the reader. Empty where there is none.
  std::function<void()> load;
  std::vector<std::string> files_for_load;
};

ReaderNeeds needs_of_reader(FileFormat format, const std::string& path);
// The same for a picture of any format: the file alone, and the plug-in.
ReaderNeeds needs_of_picture(const std::string& path);

}  // namespace tessera::import
