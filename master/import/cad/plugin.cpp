// SPDX-License-Identifier: Apache-2.0
#include "master/import/cad/plugin.h"

#include <exception>
#include <new>

#include "common/base/api.h"
#include "master/import/cad/reader.h"
#include "master/import/crash_line.h"

namespace tessera::import::cad {

extern "C" TESSERA_API PluginAnswer tessera_read_cad_1(const std::string& path, ReadScene& scene,
                                                       std::string& error) {
  const CrashLine crash_line(path, "Open CASCADE");
  try {
    auto read = read_cad(path);
    if (!read.is_ok()) {
      error = read.status().message();
      return PluginAnswer::kRefused;
    }
    scene = std::move(*read);
    return PluginAnswer::kRead;
  } catch (const std::bad_alloc&) {
    return PluginAnswer::kNoMemory;
  } catch (const std::exception& failure) {
    error = path + ": " + failure.what();
    return PluginAnswer::kRefused;
  }
}

}  // namespace tessera::import::cad
