// SPDX-License-Identifier: Apache-2.0
// Loads the SCENE of a command line: `builtin:NAME`, or a file, which tessera-import reads in a
// separate, limited process so that nothing in a file can crash, hang or exhaust the master.
//
// Threads. Any; blocks until done.
#pragma once

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "common/base/status.h"
#include "common/scene/scene.h"
#include "master/loader/import_process.h"

namespace tessera::master {

struct LoadedScene {
  Scene scene;  // at time 0
  bool is_animated = false;
  // The scene at a time in seconds; set only where is_animated. Scenes share unchanged meshes.
  std::function<Scene(double seconds)> at_time;
  // One line each: missing texture, degenerate triangles, unknown keyword, ...
  std::vector<std::string> warnings;
};

// Whether SCENE can name a scene at all: a built-in one, or a file of a known type.
// Returns: kInvalidArgument naming those that exist.
Status check_scene_name(const std::string& scene_argument);

// Called now and then from the loading thread (fraction < 0: unknown). Returns: whether to go on.
using LoadProgress = std::function<bool(const std::string& text, double fraction)>;

// Returns: one line naming the file and what to do: kNotFound, kInvalidArgument (malformed: element
// and line), kResourceExhausted (limits), kDataLoss, kCancelled (progress said so).
Result<LoadedScene> load_scene(const std::string& scene_argument, const LoadProgress& progress,
                               const ImportLimits& limits = {});

// Whether `path` can name the picture of a sky. Returns: kInvalidArgument, about --environment.
Status check_sky_name(const std::string& path);

// Loads a latitude-longitude picture of what surrounds the scene, in a process of its own as scenes
// are. Returns: as load_scene().
Result<std::shared_ptr<const EnvironmentMap>> load_sky(const std::string& path,
                                                       const LoadProgress& progress,
                                                       const ImportLimits& limits = {});

// The built-in scenes of builtin.cpp.
std::vector<std::string> builtin_names();
Result<LoadedScene> make_builtin(const std::string& name);

}  // namespace tessera::master
