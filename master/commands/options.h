// SPDX-License-Identifier: Apache-2.0
// Everything a person can say on tessera-master's command line or in its config file, checked.
//
// parse_command_line() is the border: what it returns is in range and consistent, as far as can be
// told without opening the scene. CLI11 is confined to cluster_options.h and
// what includes it, toml++ to config_file.cpp.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "common/base/log.h"
#include "common/base/status.h"
#include "common/frame/frame_settings.h"
#include "master/loader/import_process.h"
#include "master/look/first_look.h"
#include "master/session/session.h"

namespace tessera::master {

enum class Command { kServe, kView, kRender, kStatus };

// Passes after which a window whose camera rests stops rendering.
inline constexpr int kViewPasses = 64;

struct MasterOptions {
  Command command = Command::kRender;
  std::string scene;   // view, render
  std::string output;  // render: -o
  ImportLimits import_limits;
  SessionOptions session;
  double wait_seconds = 0;           // for --slaves; 0: for ever
  FrameSettings frame;               // camera not yet resolved
  std::optional<Vec3f> environment;  // instead of the scene's, as environment_file
  std::string environment_file;
  LookOptions look;                     // light, background, exposure, tone
  bool is_exposure_each = false;        // render: automatic for each frame, not the first alone
  std::string camera;                   // --camera as given; empty: the scene's
  std::optional<Camera> inline_camera;  // what it says, where it is not a file
  double orbit_degrees = 0;             // render: round the scene, from the first frame to the last
  bool has_size = false;                // --size was given; else a camera file's size wins
  long frame_first = 0, frame_last = 0;
  double fps = 24;
  std::string animation;           // --animation as given; empty: the first one
  bool has_usual_samples = false;  // render: frame.samples_per_pixel is for the scene to say
  int passes = 0;          // pictures of one view that are averaged; 0: 1, view: kViewPasses
  std::string reference;   // render: a picture that the others are compared with; empty: none
  std::string stats_path;  // empty: none
  LogLevel log_level = LogLevel::kInfo;
  LogFormat log_format = LogFormat::kText;
  bool is_quiet = false;
  bool is_json = false;         // status
  bool has_events = false;      // status: the last lines of the master's log, too
  std::string screenshot_path;  // view, tests: save the window and end
  int screenshot_after = 0;
  double frame_time_ms = 100;  // view: of frames while something moves; 0: no limit
};

struct ParsedCommandLine {
  // Set by --help and --version (0) and by wrong usage (2); everything is printed already.
  std::optional<int> exit_code;
  MasterOptions options;
};

ParsedCommandLine parse_command_line(int argc, const char* const* argv);

// Reads `path` (TOML, keys as the long options) into "--key=value" words, for keys in `known` that
// are not in `given`. Returns: one line with file, line and what is wrong.
Result<std::vector<std::string>> read_config_file(const std::string& path,
                                                  const std::vector<std::string>& known,
                                                  const std::vector<std::string>& given);

}  // namespace tessera::master
