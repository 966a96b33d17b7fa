// SPDX-License-Identifier: Apache-2.0
#include "common/base/plugin_library.h"

#include <dlfcn.h>

#include <filesystem>

#include "common/base/check.h"

namespace tessera {
namespace {

Status load_from(const std::string& path, std::span<const char* const> names,
                 std::span<void*> functions) {
  void* const library = dlopen(path.c_str(), RTLD_NOW | RTLD_LOCAL);
  if (library == nullptr) {
    const char* const text = dlerror();
    return Status::unavailable(text != nullptr ? text : "unknown");
  }
  for (std::size_t i = 0; i < names.size(); ++i) {
    functions[i] = dlsym(library, names[i]);
    if (functions[i] == nullptr) return Status::unavailable(path + " is of another build");
  }
  return Status::ok();
}

}  // namespace

std::vector<std::string> plugin_places(const std::string& file_name) {
  std::error_code error;
  const std::filesystem::path bin =
      std::filesystem::read_symlink("/proc/self/exe", error).parent_path();
  return {(bin / file_name).string(), (bin / "../lib/tessera" / file_name).string()};
}

Status load_plugin(const std::string& file_name, std::span<const char* const> names,
                   std::span<void*> functions) {
  TESSERA_CHECK_EQ(names.size(), functions.size());
  std::error_code error;
  const std::vector<std::string> places = plugin_places(file_name);
  Status status = Status::not_found(std::filesystem::path(places[0]).parent_path().string() +
                                    " and ../lib/tessera have no " + file_name);
  for (const std::string& path : places) {
    if (!std::filesystem::exists(path, error)) continue;
    status = load_from(path, names, functions);
    if (status.is_ok()) break;
  }
  return status;
}

}  // namespace tessera
