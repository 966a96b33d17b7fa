// SPDX-License-Identifier: Apache-2.0
#include "master/import/reader_needs.h"

#include <filesystem>

#include "common/base/plugin_library.h"
#include "master/image/plugin_loader.h"
#include "master/import/formats/cad.h"

namespace tessera::import {
namespace {

// Where a system has its libraries, and the loader's list of them. Every person may read these.
constexpr const char* kLibraries[] = {"/lib",       "/lib64",         "/usr/lib",
                                      "/usr/lib64", "/usr/local/lib", "/etc/ld.so.cache"};

void add_library_files(std::vector<std::string>& files, const char* plugin) {
  for (const std::string& place : plugin_places(plugin)) files.push_back(place);
  files.insert(files.end(), std::begin(kLibraries), std::end(kLibraries));
}

}  // namespace

ReaderNeeds needs_of_picture(const std::string& path) {
  ReaderNeeds needs;
  needs.files.push_back(path);
  needs.load = [] { (void)master::image_plugin(); };
  add_library_files(needs.files_for_load, master::kImagePluginFile);
  return needs;
}

ReaderNeeds needs_of_reader(FileFormat format, const std::string& path) {
  ReaderNeeds needs;
  needs.files.push_back(path);
  switch (format) {
    case FileFormat::kStl:
    case FileFormat::kBpt:
      break;
    case FileFormat::kStep:
    case FileFormat::kStp:
    case FileFormat::kIges:
    case FileFormat::kIgs:
      needs.load = [] { (void)cad_plugin(); };
      add_library_files(needs.files_for_load, kCadPluginFile);
      break;
    case FileFormat::kExr:
    case FileFormat::kHdr:
      return needs_of_picture(path);
    default: {
      const std::string folder = std::filesystem::path(path).parent_path().string();
      needs.files.push_back(folder.empty() ? "." : folder);
      add_library_files(needs.files, master::kImagePluginFile);
    }
  }
  return needs;
}

}  // namespace tessera::import
