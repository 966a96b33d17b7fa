// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cstdio>
#include <set>

#include "common/base/clean_text.h"
#include "common/base/cli_usage.h"
#include "common/base/limits.h"
#include "common/base/version.h"
#include "master/commands/cluster_options.h"

namespace tessera::master {
namespace {

constexpr char kCameraHelp[] =
    "A camera file has lines 'eye X Y Z', 'target X Y Z', 'up X Y Z', 'vfov DEGREES', 'size W H';\n"
    "'frame N' begins the keys of frame N, between which the camera moves smoothly.";

void add_look_options(CLI::App& app, TypedOptions& t) {
  add_text(app, "--light", t.light, "LIGHT",
           "auto (the scene's, and a studio sky where that lights nothing), scene, or studio");
  add_text(app, "--background", t.background, "COLOR",
           "what is seen behind: auto (grey where the studio lights), sky, black, #rrggbb or "
           "transparent (alpha)");
  add_text(app, "--exposure", t.exposure, "EV|auto",
           "stops, or auto (by the first frame; render: auto-each by every frame)");
  add_text(app, "--tone", t.tone, "CURVE",
           "tone curve of PNG, display8 and the window: linear, filmic, aces or agx");
}

// Options of instant global illumination.
void add_gi_options(CLI::App& app, MasterOptions& o, TypedOptions& t) {
  app.add_option("--vpls", o.frame.vpls, "igi: points that light a pixel, 1 to 4096")
      ->check(whole_in(1, kVplsMax))
      ->capture_default_str()
      ->type_name("N");
  app.add_option("--interleave", o.frame.interleave,
                 "igi: N x N pixels have points of their own: 1, 3 or 5")
      ->check(CLI::IsMember({1, 3, 5}))
      ->capture_default_str()
      ->type_name("N");
  o.frame.is_compensated = true;
  app.add_option("--filter", o.frame.is_filtered,
                 "igi: pixels that show one surface share the light of their points: on or off")
      ->default_str("on")
      ->type_name("on|off");
  add_text(app, "--clamp", t.clamp, "X|off|auto",
           "igi: bound of what a point sheds near by, per unit of area; auto: by the scene's size");
  app.add_option("--compensate", o.frame.is_compensated,
                 "igi: trace what --clamp takes away: on or off")
      ->default_str("on")
      ->type_name("on|off");
}

// How much work a pixel is.
void add_sample_options(CLI::App& app, MasterOptions& o, TypedOptions& t) {
  add_text(
      app, "--aa", t.samples, "N|auto",
      "samples per pixel, 1 to 256, or auto (render without --passes: 4, igi 16 where surfaces "
      "shine or pass light, path 64; otherwise 1)");
  app.add_option("--passes", o.passes,
                 "pictures with other random choices that are averaged, 1 to 65536; view: while "
                 "nothing moves (default: 1; view: 64)")
      ->check(whole_in(1, static_cast<int>(kPassesMax)))
      ->type_name("N");
  app.add_option("--light-samples", o.frame.light_samples,
                 "direct: samples per area light and of the sky, 1 to 256")
      ->check(whole_in(1, kLightSamplesMax))
      ->capture_default_str()
      ->type_name("N");
  app.add_option(
         "--bounces", o.frame.bounces,
         "igi, path: surfaces that light may meet after the one that is seen, 0 (direct light "
         "only) to 64")
      ->check(whole_in(0, kBouncesMax))
      ->capture_default_str()
      ->type_name("N");
}

void add_frame_options(CLI::App& app, MasterOptions& o, TypedOptions& t) {
  app.add_option(
         "SCENE", o.scene,
         "scene file (.obj .ply .stl .gltf .glb .fbx .dae .bpt .step .iges) or builtin:NAME "
         "(cones, cones-mesh, cornell, evening, paint, room, teapot, teapot-mesh, teapots,\n"
         "waves)")
      ->required()
      ->type_name(" ");
  app.add_option("--connect", o.session.connect, "a running 'tessera-master serve'")
      ->type_name("HOST:PORT");
  app.add_option("--size", t.size, "in pixels, each 1 to 16384 (default: 640x480)")
      ->type_name("WxH");
  app.add_option("--camera", o.camera,
                 "camera file, number (from 1) or name of a camera in SCENE, or\n"
                 "\"ex,ey,ez lx,ly,lz ux,uy,uz fov\" (eye, look-at, up, degrees)")
      ->type_name("CAMERA");
  app.add_option("--animation", o.animation,
                 "which animation of SCENE is played: its name or number (from 1), all, or none\n"
                 "(default: the first)")
      ->type_name("NAME");
  app.add_option("--fps", o.fps, "time of frame n is n/FPS seconds")
      ->check(number_in(1e-3, 1e6))
      ->capture_default_str()
      ->type_name("FPS");
  add_text(app, "--renderer", t.renderer, "NAME",
           "igi (light over all surfaces, from --vpls points that shed it), direct (lights and "
           "shadows), path (as igi, without noise in common or bias), or "
           "primary (distance to the first surface; PNG shows 1 and more as white)");
  add_sample_options(app, o, t);
  add_gi_options(app, o, t);
  add_text(app, "--patch-method", t.patch_method, "NAME", patch_method_help().c_str());
  app.add_option("--environment", t.environment,
                 "radiance from where there is nothing: constant:R,G,B, or a latitude-longitude "
                 "picture, FILE.hdr or FILE.exr (default: the scene's)")
      ->type_name("SKY");
  add_look_options(app, t);
  app.add_option("--seed", o.frame.seed, "of every random choice, 0 to 4294967295")
      ->capture_default_str()
      ->type_name("N");
  app.add_option("--pixels", t.pixels,
                 "float (exact), half (11 significant bits: relative error 2^-11; 65520 and more "
                 "become infinite) or display8 (8-bit sRGB: half a code, clamped to 0..1): what "
                 "travels (default: float for files, half for view)")
      ->type_name("FORMAT");
  add_text(app, "--tile", t.tile, "N|auto", "edge of a tile in pixels, 4 to 256, or auto");
  app.add_option("--import-seconds", o.import_limits.seconds_max, "most seconds to read a file")
      ->check(number_in(1, 86400))
      ->capture_default_str()
      ->type_name("SECONDS");
  app.add_option("--stats", o.stats_path, "write one JSON object per frame to this file")
      ->type_name("FILE");
  add_cluster_options(app, o, t);
}

// Whether a message, which begins with the option it is about, is about one of `words`.
bool is_about(const std::string& message, const std::vector<std::string>& words) {
  const std::string option = message.substr(0, message.find_first_of(": "));
  return std::any_of(words.begin(), words.end(), [&](const std::string& word) {
    return word.substr(0, word.find('=')) == option;
  });
}

// `command`: the word that the person gave, if it is one.
int usage_error(const std::string& text, const std::string& command) {
  std::fprintf(stderr, "tessera-master: %s (see 'tessera-master %s--help')\n",
               clean_text(text).c_str(), command.empty() ? "" : (command + " ").c_str());
  return 2;
}

// The four commands and their options; `typed` and `options` must outlive the app.
struct Grammar {
  CLI::App app{
      "Tessera: one interactive frame on all the PCs in the room, that survives any of them.",
      "tessera-master"};
  CLI::App* serve = app.add_subcommand(
      "serve", "the daemon: keeps slaves, waits for applications; ends on SIGTERM");
  CLI::App* view = app.add_subcommand("view", "show a scene in a window");
  CLI::App* render = app.add_subcommand("render", "render pictures to files");
  CLI::App* status = app.add_subcommand("status", "what a running master is doing");

  Grammar(MasterOptions& o, TypedOptions& t) {
    app.require_subcommand(1);
    app.set_version_flag("--version", std::string("tessera-master ") + kBuildId);
    add_cluster_options(*serve, o, t);
    for (CLI::App* command : {view, render}) command->footer(kCameraHelp);
    add_frame_options(*view, o, t);
    view->add_option("--screenshot", o.screenshot_path,
                     "save the window as PNG after --screenshot-after frames, and end")
        ->type_name("FILE");
    view->add_option("--screenshot-after", o.screenshot_after, "frames to show before --screenshot")
        ->check(whole_in(1, 1'000'000))
        ->type_name("N");
    view->add_option(
            "--frame-time", o.frame_time_ms,
            "while something moves, fewer samples and pixels so that a frame takes so many\n"
            "milliseconds; everything again, step by step, when it rests; 0: off")
        ->capture_default_str()
        ->check(number_in(0, 60'000))
        ->type_name("MS");
    add_frame_options(*render, o, t);
    render
        ->add_option("-o,--output", o.output, "OUT.(exr|png|jpg|hdr|pfm); %04d numbers a sequence")
        ->required()
        ->type_name("OUT");
    render->add_option("--frames", t.frames, "inclusive (default: 0:0)")->type_name("FIRST:LAST");
    render
        ->add_option("--orbit", o.orbit_degrees,
                     "turn the camera round the scene by so many degrees over the frames")
        ->check(number_in(-3600, 3600))
        ->type_name("DEGREES");
    render
        ->add_option("--reference", o.reference,
                     "a picture to compare with: prints RMSE, relMSE and FLIP after each pass")
        ->type_name("FILE");
    render
        ->add_option("--aov", t.aov, "further channels of OUT.exr, commas between: " + aov_names())
        ->type_name("NAMES");
    status->add_option("--connect", o.session.connect, "a running master")
        ->required()
        ->type_name("HOST:PORT");
    status->add_flag("--json", o.is_json, "machine-readable");
    status->add_flag("--events", o.has_events, "the last 100 lines of the master's log, too");
    add_key_options(*status, o);
    add_log_options(*status, o, t);
  }

  Command chosen() const {
    return *serve    ? Command::kServe
           : *view   ? Command::kView
           : *status ? Command::kStatus
                     : Command::kRender;
  }

  // Long names of all options of all commands, or of those that were given.
  std::vector<std::string> names(bool only_given) const {
    std::vector<std::string> result;
    for (const CLI::App* command : {serve, view, render, status}) {
      for (const CLI::Option* option : command->get_options()) {
        if (only_given && option->count() == 0) continue;
        for (const std::string& name : option->get_lnames()) result.push_back(name);
      }
    }
    return result;
  }
  bool command_has(Command command, const std::string& name) const {
    const CLI::App* app_of = command == Command::kServe    ? serve
                             : command == Command::kView   ? view
                             : command == Command::kStatus ? status
                                                           : render;
    return app_of->get_option_no_throw("--" + name) != nullptr;
  }
};

// Returns: kInvalidArgument, what is wrong. Throws: CLI::Success for --help and --version.
Status parse_into(MasterOptions& o, TypedOptions& t, std::vector<std::string> words,
                  std::vector<std::string>* config_words) {
  Grammar grammar(o, t);
  std::reverse(words.begin(), words.end());  // CLI11 takes them from the back
  try {
    grammar.app.parse(words);
  } catch (const CLI::Success&) {
    throw;
  } catch (const CLI::Error& error) {
    return Status::invalid_argument(usage_text(grammar.app, error));
  }
  o.command = grammar.chosen();
  if (config_words != nullptr && !t.config.empty()) {
    auto read = read_config_file(t.config, grammar.names(false), grammar.names(true));
    if (!read.is_ok()) return read.status();
    for (const std::string& word : *read) {  // keys of other commands are theirs
      if (grammar.command_has(o.command, word.substr(2, word.find('=') - 2)))
        config_words->push_back(word);
    }
    return Status::ok();
  }
  return check_options(t, o);
}

}  // namespace

ParsedCommandLine parse_command_line(int argc, const char* const* argv) {
  std::vector<std::string> words(argv + 1, argv + argc);
  ParsedCommandLine parsed;
  const std::set<std::string> commands{"serve", "view", "render", "status"};
  const std::string command = !words.empty() && commands.contains(words[0]) ? words[0] : "";
  TypedOptions typed;
  std::vector<std::string> config_words;
  const auto refuse = [&](const std::string& text) {
    const std::string origin = is_about(text, config_words) ? typed.config + ": " : "";
    parsed.exit_code = usage_error(origin + text, command);
  };
  if (command.empty() && !words.empty() && !words[0].starts_with('-')) {
    refuse("unknown command '" + words[0] + "': give serve, view, render or status" +
           did_you_mean(words[0], {commands.begin(), commands.end()}));
    return parsed;
  }
  try {
    Status status = parse_into(parsed.options, typed, words, &config_words);
    if (status.is_ok() && !typed.config.empty()) {
      words.insert(words.end(), config_words.begin(), config_words.end());
      parsed.options = {};
      typed = TypedOptions();
      status = parse_into(parsed.options, typed, words, nullptr);
    }
    if (!status.is_ok()) refuse(status.message());
  } catch (const CLI::Success& success) {
    TypedOptions other;
    MasterOptions options;
    Grammar grammar(options, other);
    std::reverse(words.begin(), words.end());
    try {
      grammar.app.parse(words);
    } catch (const CLI::Success& again) {
      grammar.app.exit(again);
    }
    parsed.exit_code = 0;
  }
  return parsed;
}

}  // namespace tessera::master
