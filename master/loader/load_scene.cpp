#include "master/loader/load_scene.h"

#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>

#include "common/base/path_suffix.h"
#include "master/loader/import_process.h"

namespace tessera::master {
namespace {

Status check_file(const std::string& path) {
  struct stat info {};
  if (stat(path.c_str(), &info) != 0) {
    return Status::not_found("scene " + path + ": " + std::strerror(errno) +
                             "; give a file, or builtin:NAME");
  }
  if (S_ISDIR(info.st_mode))
    return Status::invalid_argument("scene " + path + " is a folder; give a file in it");
  if (!S_ISREG(info.st_mode))
    return Status::invalid_argument("scene " + path + " is not a regular file");
  if (access(path.c_str(), R_OK) != 0)
    return Status::permission_denied("scene " + path + ": " + std::strerror(errno));
  if (info.st_size == 0) return Status::invalid_argument("scene " + path + " is empty");
  return Status::ok();
}

}  // namespace

Status check_scene_name(const std::string& scene_argument) {
  if (scene_argument.starts_with("builtin:")) {
    const std::vector<std::string> names = builtin_names();
    const std::string name = scene_argument.substr(8);
    if (std::find(names.begin(), names.end(), name) != names.end()) return Status::ok();
    std::string known;
    for (const std::string& n : names) known += (known.empty() ? "" : ", ") + n;
    return Status::invalid_argument(scene_argument + " does not exist; there are " + known);
  }
  const std::string suffix = suffix_of(scene_argument);
  if (suffix == ".obj" || suffix == ".ply" || suffix == ".gltf" || suffix == ".glb") {
    return Status::ok();
  }
  return Status::invalid_argument("scene " + scene_argument + ": unknown suffix '" + suffix +
                                  "'; known are .obj, .ply, .gltf, .glb, and builtin:NAME");
}

Result<LoadedScene> load_scene(const std::string& scene_argument, const LoadProgress& progress) {
  TESSERA_RETURN_IF_ERROR(check_scene_name(scene_argument));
  if (scene_argument.starts_with("builtin:")) return make_builtin(scene_argument.substr(8));
  TESSERA_RETURN_IF_ERROR(check_file(scene_argument));
  progress("reading " + scene_argument, -1);
  auto stream = run_import(scene_argument, ImportLimits{}, [&](std::uint64_t bytes) {
    const std::string size = bytes >> 20 > 0 ? ", " + std::to_string(bytes >> 20) + " MiB" : "";
    return progress("reading " + scene_argument + size, -1);
  });
  if (!stream.is_ok()) return stream.status();
  SceneDecoder decoder;
  auto scene = decoder.decode(stream->scene);
  if (!scene.is_ok())
    return Status(scene.status().code(), scene_argument + ": " + scene.status().message());
  LoadedScene loaded;
  loaded.scene = std::move(*scene);
  loaded.warnings = std::move(stream->warnings);
  return loaded;
}

}  // namespace tessera::master
