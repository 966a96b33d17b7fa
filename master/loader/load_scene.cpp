// SPDX-License-Identifier: Apache-2.0
#include "master/loader/load_scene.h"

#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>

#include "common/base/near_word.h"
#include "common/base/path_suffix.h"
#include "common/scene_io/file_format.h"

namespace tessera::master {
namespace {

// what: "scene", "environment"; hint: what else could have been given.
Status check_file(const std::string& what, const std::string& path, const std::string& hint) {
  const std::string name = what + " " + path;
  struct stat info {};
  if (stat(path.c_str(), &info) != 0)
    return Status::not_found(name + ": " + std::strerror(errno) + "; give a file, or " + hint);
  if (S_ISDIR(info.st_mode))
    return Status::invalid_argument(name + " is a folder; give a file in it");
  if (!S_ISREG(info.st_mode)) return Status::invalid_argument(name + " is not a regular file");
  if (access(path.c_str(), R_OK) != 0)
    return Status::permission_denied(name + ": " + std::strerror(errno));
  if (info.st_size == 0) return Status::invalid_argument(name + " is empty");
  return Status::ok();
}

Result<LoadedScene> import_file(const std::string& path, const LoadProgress& progress,
                                const ImportLimits& limits) {
  progress("reading " + path, -1);
  auto stream = run_import(path, limits, [&](std::uint64_t bytes) {
    const std::string size = bytes >> 20 > 0 ? ", " + std::to_string(bytes >> 20) + " MiB" : "";
    return progress("reading " + path + size, -1);
  });
  if (!stream.is_ok()) return stream.status();
  SceneDecoder decoder;
  auto scene = decoder.decode(stream->scene);
  if (!scene.is_ok()) return Status(scene.status().code(), path + ": " + scene.status().message());
  LoadedScene loaded;
  loaded.scene = std::move(*scene);
  loaded.warnings = std::move(stream->warnings);
  return loaded;
}

}  // namespace

Status check_scene_name(const std::string& scene_argument) {
  if (scene_argument.starts_with("builtin:")) {
    const std::vector<std::string> names = builtin_names();
    const std::string name = scene_argument.substr(8);
    if (std::find(names.begin(), names.end(), name) != names.end()) return Status::ok();
    std::string known;
    for (const std::string& n : names) known += (known.empty() ? "" : ", ") + n;
    return Status::invalid_argument(scene_argument + " does not exist; there are " + known +
                                    did_you_mean(name, names));
  }
  const FormatEntry* const format = format_of_suffix(scene_argument);
  if (format != nullptr && !format->is_sky) return Status::ok();
  return Status::invalid_argument("scene " + scene_argument + ": unknown suffix '" +
                                  suffix_of(scene_argument) + "'; known are " + suffix_list(false) +
                                  ", and builtin:NAME");
}

Result<LoadedScene> load_scene(const std::string& scene_argument, const LoadProgress& progress,
                               const ImportLimits& limits) {
  TESSERA_RETURN_IF_ERROR(check_scene_name(scene_argument));
  if (scene_argument.starts_with("builtin:")) return make_builtin(scene_argument.substr(8));
  TESSERA_RETURN_IF_ERROR(check_file("scene", scene_argument, "builtin:NAME"));
  return import_file(scene_argument, progress, limits);
}

Status check_sky_name(const std::string& path) {
  const FormatEntry* const format = format_of_suffix(path);
  if (format != nullptr && format->is_sky) return Status::ok();
  return Status::invalid_argument(
      "--environment " + path +
      ": give a latitude-longitude picture, FILE.hdr or FILE.exr, or constant:R,G,B, radiances "
      "from 0, such as constant:1,1,1");
}

Result<std::shared_ptr<const EnvironmentMap>> load_sky(const std::string& path,
                                                       const LoadProgress& progress,
                                                       const ImportLimits& limits) {
  TESSERA_RETURN_IF_ERROR(check_sky_name(path));
  TESSERA_RETURN_IF_ERROR(check_file("environment", path, "constant:R,G,B"));
  auto loaded = import_file(path, progress, limits);
  if (!loaded.is_ok()) return loaded.status();
  return loaded->scene.environment_map;
}

}  // namespace tessera::master
