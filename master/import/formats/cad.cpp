// SPDX-License-Identifier: Apache-2.0
// STEP and IGES files, by tessera_import_cad.so, which is loaded for them alone.
#include <dlfcn.h>

#include <filesystem>
#include <new>

#include "master/import/cad/plugin.h"
#include "master/import/read_file.h"

namespace tessera::import {
namespace {

constexpr const char* kFileName = "tessera_import_cad.so";

Result<cad::ReadCadFunction> load() {
  std::error_code error;
  const std::filesystem::path bin =
      std::filesystem::read_symlink("/proc/self/exe", error).parent_path();
  std::string reason = "it is built where Open CASCADE is (libocct-data-exchange-dev)";
  for (const auto& folder : {bin, bin / "../lib/tessera"}) {
    const std::filesystem::path path = folder / kFileName;
    if (!std::filesystem::exists(path, error)) continue;
    void* const library = dlopen(path.c_str(), RTLD_NOW | RTLD_LOCAL);
    if (library == nullptr) {
      const char* text = dlerror();
      reason = std::string(text != nullptr ? text : "unknown") +
               "; install Open CASCADE (libocct-data-exchange-7.6)";
      continue;
    }
    const auto read = reinterpret_cast<cad::ReadCadFunction>(dlsym(library, cad::kReadCadName));
    if (read != nullptr) return read;
    reason = "it is of another build";
  }
  return Status::not_found(std::string("CAD files need ") + kFileName + ": " + reason);
}

Result<ReadScene> read_cad_file(const std::string& path) {
  const auto read = load();
  if (!read.is_ok()) return Status::not_found(path + ": " + read.status().message());
  ReadScene scene;
  std::string error;
  switch ((*read)(path, scene, error)) {
    case cad::PluginAnswer::kRead:
      return scene;
    case cad::PluginAnswer::kNoMemory:
      throw std::bad_alloc();  // main() names the limit
    case cad::PluginAnswer::kRefused:
      break;
  }
  return Status::invalid_argument(error);
}

}  // namespace

Result<ReadScene> read_step_file(const std::string& path) { return read_cad_file(path); }
Result<ReadScene> read_iges_file(const std::string& path) { return read_cad_file(path); }

}  // namespace tessera::import
