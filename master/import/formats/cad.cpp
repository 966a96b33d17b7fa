// SPDX-License-Identifier: Apache-2.0
// STEP and IGES files, by tessera_import_cad.so, which is loaded for them alone.
#include "master/import/formats/cad.h"

#include <new>
#include <string>

#include "common/base/plugin_library.h"
#include "master/import/read_file.h"

namespace tessera::import {
namespace {

Result<cad::ReadCadFunction> load() {
  constexpr const char* kNames[] = {cad::kReadCadName};
  void* functions[] = {nullptr};
  const Status status = load_plugin(kCadPluginFile, kNames, functions);
  if (status.is_ok()) return reinterpret_cast<cad::ReadCadFunction>(functions[0]);
  const std::string hint =
      status.code() == StatusCode::kNotFound
          ? "it is built where Open CASCADE is (libocct-data-exchange-dev)"
          : status.message() + "; install Open CASCADE (libocct-data-exchange-7.6)";
  return Status::not_found("CAD files need tessera_import_cad.so: " + hint);
}

Result<ReadScene> read_cad_file(const std::string& path) {
  const auto read = cad_plugin();
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

Result<cad::ReadCadFunction> cad_plugin() {
  static const Result<cad::ReadCadFunction> plugin = load();
  return plugin;
}

Result<ReadScene> read_step_file(const std::string& path) { return read_cad_file(path); }
Result<ReadScene> read_iges_file(const std::string& path) { return read_cad_file(path); }

}  // namespace tessera::import
