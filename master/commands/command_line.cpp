#include <CLI/CLI.hpp>
#include <algorithm>
#include <charconv>
#include <cstdio>
#include <set>
#include <sstream>

#include "common/base/limits.h"
#include "common/base/version.h"
#include "common/net/connection.h"
#include "master/commands/options.h"

namespace tessera::master {
namespace {

// Option values as typed; turned into MasterOptions by check_*().
struct Typed {
  std::string size, frames, renderer = "direct", pixels, isa = "auto", isa_policy = "same",
                            tile = "auto", prefetch = "auto", log_level = "info",
                            log_format = "text", config;
  int local = -1;
  std::uint32_t threads = 0;
};

Result<int> parse_int(const std::string& option, const std::string& text, int low, int high) {
  int value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || end != text.data() + text.size() || value < low || value > high) {
    return Status::invalid_argument(option + " " + text + ": give a whole number from " +
                                    std::to_string(low) + " to " + std::to_string(high));
  }
  return value;
}

// As CLI::Range, but "nan" is out of range too.
CLI::Validator number_in(double low, double high) {
  return CLI::Validator(
      [low, high](const std::string& text) {
        double value = 0;
        const bool is_number = CLI::detail::lexical_cast(text, value);
        if (is_number && value >= low && value <= high) return std::string();
        std::ostringstream reason;
        reason << "give a number from " << low << " to " << high << ", not " << text;
        return reason.str();
      },
      "");
}

// CLI::Range without its words in --help: they stand in the option's own text.
template <typename T>
CLI::Validator whole_in(T low, T high) {
  return CLI::Range(low, high).description("");
}

// "640x480", "0:11": two whole numbers around one separator.
std::optional<std::pair<long, long>> parse_pair(const std::string& text, char separator) {
  const auto middle = text.find(separator);
  if (middle == std::string::npos) return std::nullopt;
  long first = 0, second = 0;
  const char* const begin = text.data();
  const char* const end = begin + text.size();
  const auto a = std::from_chars(begin, begin + middle, first);
  const auto b = std::from_chars(begin + middle + 1, end, second);
  if (a.ec != std::errc() || a.ptr != begin + middle || b.ec != std::errc() || b.ptr != end)
    return std::nullopt;
  return std::pair(first, second);
}

void add_log_options(CLI::App& app, MasterOptions& o, Typed& t) {
  app.add_option("--log-level", t.log_level, "trace, debug, info, warn, error, off")
      ->capture_default_str()
      ->type_name("LEVEL");
  app.add_option("--log-format", t.log_format, "text or json, on stderr")
      ->capture_default_str()
      ->type_name("FORMAT");
  app.add_flag("--quiet", o.is_quiet, "no progress, and only warnings in the log");
  app.add_option("--config", t.config, "TOML file with the same names; the command line wins")
      ->type_name("FILE");
}

void add_key_options(CLI::App& app, MasterOptions& o) {
  app.add_option("--keys", o.session.keys_folder, "credentials folder made by tessera-keys")
      ->type_name("DIR");
  app.add_flag("--plain", o.session.is_plain, "TCP without TLS, loopback only");
}

void add_cluster_options(CLI::App& app, MasterOptions& o, Typed& t) {
  app.add_option("--listen", o.session.listen,
                 "where slaves (and, with serve, applications) connect")
      ->type_name("HOST:PORT");
  app.add_option("--local", t.local,
                 "slaves inside this process (default: 1 when nothing else gives slaves)")
      ->type_name("N");
  app.add_option("--slaves", o.session.slaves_min, "wait for so many slaves before the first frame")
      ->check(whole_in(0, kConnectionsMax))
      ->type_name("N");
  app.add_option("--wait", o.wait_seconds,
                 "wait at most so many seconds for --slaves (default: for ever)")
      ->check(number_in(0, 1e6))
      ->type_name("SECONDS");
  app.add_option("--threads", t.threads,
                 "render threads of slaves inside this process (default: all)")
      ->check(whole_in(1u, std::uint32_t{kWorkersMax}))
      ->type_name("N");
  app.add_option("--isa", t.isa, "auto, scalar, sse4, avx2, avx512: instruction set of the session")
      ->capture_default_str()
      ->type_name("SET");
  app.add_option("--isa-policy", t.isa_policy,
                 "same: one set per session; mixed: later slaves may have another")
      ->capture_default_str()
      ->type_name("POLICY");
  app.add_option("--prefetch", t.prefetch, "tiles queued per render thread of a slave, or auto (3)")
      ->capture_default_str()
      ->type_name("N|auto");
  app.add_option("--frames-in-flight", o.session.frames_in_flight, "1 or 2")
      ->check(whole_in(1, kFramesInFlightMax))
      ->capture_default_str()
      ->type_name("N");
  add_key_options(app, o);
  add_log_options(app, o, t);
}

void add_frame_options(CLI::App& app, MasterOptions& o, Typed& t) {
  app.add_option("SCENE", o.scene,
                 "scene file (.obj .ply .gltf .glb) or builtin:NAME (cornell, room, teapot, waves)")
      ->required()
      ->type_name(" ");
  app.add_option("--connect", o.session.connect, "a running 'tessera-master serve'")
      ->type_name("HOST:PORT");
  app.add_option("--size", t.size, "in pixels, each 1 to 16384 (default: 640x480)")
      ->type_name("WxH");
  app.add_option("--camera", o.camera,
                 "camera file, or \"ex,ey,ez lx,ly,lz ux,uy,uz fov\" (eye, look-at, up, degrees)")
      ->type_name("CAMERA");
  app.add_option("--fps", o.fps, "time of frame n is n/FPS seconds")
      ->check(number_in(1e-3, 1e6))
      ->capture_default_str()
      ->type_name("FPS");
  app.add_option("--renderer", t.renderer, "primary (distance) or direct (lights and shadows)")
      ->capture_default_str()
      ->type_name("NAME");
  app.add_option("--aa", o.frame.samples_per_pixel, "samples per pixel, 1 to 256")
      ->check(whole_in(1, kSamplesPerPixelMax))
      ->capture_default_str()
      ->type_name("N");
  app.add_option("--light-samples", o.frame.light_samples, "samples per area light, 1 to 256")
      ->check(whole_in(1, kLightSamplesMax))
      ->capture_default_str()
      ->type_name("N");
  app.add_option("--seed", o.frame.seed, "of every random choice")
      ->capture_default_str()
      ->type_name("N");
  app.add_option("--pixels", t.pixels,
                 "float, half or display8: what travels (default: float for files, half for view)")
      ->type_name("FORMAT");
  app.add_option("--tile", t.tile, "edge of a tile in pixels, 4 to 256, or auto")
      ->capture_default_str()
      ->type_name("N|auto");
  app.add_option("--stats", o.stats_path, "write one JSON object per frame to this file")
      ->type_name("FILE");
  add_cluster_options(app, o, t);
}

Status check_frame(MasterOptions& o, const Typed& t) {
  if (!t.size.empty()) {
    const auto size = parse_pair(t.size, 'x');
    if (!size || size->first < 1 || size->second < 1 || size->first > kImageSideMaxPx ||
        size->second > kImageSideMaxPx) {
      return Status::invalid_argument("--size " + t.size +
                                      ": give WxH, each from 1 to 16384, such as 640x480");
    }
    o.frame.width_px = static_cast<int>(size->first);
    o.frame.height_px = static_cast<int>(size->second);
    o.has_size = true;
  }
  if (!t.frames.empty()) {
    const auto frames = parse_pair(t.frames, ':');
    if (!frames || frames->first < 0 || frames->second < frames->first ||
        frames->second > 1'000'000'000) {
      return Status::invalid_argument("--frames " + t.frames +
                                      ": give FIRST:LAST with 0 <= FIRST <= LAST, such as 0:23");
    }
    o.frame_first = frames->first;
    o.frame_last = frames->second;
  }
  auto renderer = parse_renderer(t.renderer);
  if (!renderer.is_ok()) return renderer.status();
  o.frame.renderer = *renderer;
  auto pixels = parse_pixel_format(
      t.pixels.empty() ? (o.command == Command::kView ? "half" : "float") : t.pixels);
  if (!pixels.is_ok()) return pixels.status();
  o.frame.pixel_format = *pixels;
  o.frame.tile_edge_px = kTileEdgeAutoPx;
  if (t.tile != "auto") {
    auto tile = parse_int("--tile", t.tile, kTileEdgeMinPx, kTileEdgeMaxPx);
    if (!tile.is_ok()) return tile.status();
    o.frame.tile_edge_px = *tile;
  }
  return Status::ok();
}

Status check_cluster(MasterOptions& o, const Typed& t) {
  if (t.isa != "auto") {
    auto isa = parse_isa(t.isa);
    if (!isa.is_ok()) return isa.status();
    o.session.isa = *isa;
  }
  if (t.isa_policy != "same" && t.isa_policy != "mixed") {
    return Status::invalid_argument("--isa-policy " + t.isa_policy + ": give same or mixed");
  }
  o.session.is_isa_mixed = t.isa_policy == "mixed";
  if (t.prefetch != "auto") {
    auto prefetch = parse_int("--prefetch", t.prefetch, 1, kTilesPerWorkerMax - 1);
    if (!prefetch.is_ok()) return prefetch.status();
    o.session.prefetch_per_thread = *prefetch;
  }
  if (t.local < -1 || t.local > kWorkersMax) {
    return Status::invalid_argument("--local: give a whole number from 0 to " +
                                    std::to_string(kWorkersMax));
  }
  const bool has_other_slaves = o.command == Command::kServe || !o.session.listen.empty() ||
                                !o.session.connect.empty() || o.session.slaves_min > 0;
  o.session.local_slaves = t.local >= 0 ? t.local : has_other_slaves ? 0 : 1;
  o.session.local_threads = static_cast<int>(t.threads);
  if (!o.session.connect.empty() && (!o.session.listen.empty() || t.local > 0)) {
    return Status::invalid_argument(
        "--connect uses a running master; --listen and --local belong to that one");
  }
  if (o.command == Command::kServe && o.session.listen.empty()) o.session.listen = "127.0.0.1:7400";
  if (!o.session.keys_folder.empty() && o.session.is_plain) {
    return Status::invalid_argument("--keys and --plain exclude each other; give one of them");
  }
  if (o.command != Command::kServe && o.session.listen.empty() && o.session.connect.empty() &&
      o.session.slaves_min > o.session.local_slaves) {
    return Status::invalid_argument("--slaves " + std::to_string(o.session.slaves_min) +
                                    ": nobody can come; add --listen HOST:PORT or --local N");
  }
  for (const auto& [option, value] :
       {std::pair("--listen", o.session.listen), std::pair("--connect", o.session.connect)}) {
    if (value.empty()) continue;
    if (auto endpoint = net::parse_endpoint(value); !endpoint.is_ok()) {
      return Status::invalid_argument(std::string(option) + " " + endpoint.status().message());
    }
  }
  return Status::ok();
}

Status check_log(MasterOptions& o, const Typed& t) {
  auto level = parse_log_level(t.log_level);
  if (!level.is_ok()) return level.status();
  o.log_level = o.is_quiet ? std::max(*level, LogLevel::kWarn) : *level;
  if (t.log_format != "text" && t.log_format != "json") {
    return Status::invalid_argument("--log-format " + t.log_format + ": give text or json");
  }
  o.log_format = t.log_format == "json" ? LogFormat::kJson : LogFormat::kText;
  return Status::ok();
}

int usage_error(const std::string& text) {
  std::string line = text;
  std::replace(line.begin(), line.end(), '\n', ' ');
  std::fprintf(stderr, "tessera-master: %s (see 'tessera-master --help')\n", line.c_str());
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

  Grammar(MasterOptions& o, Typed& t) {
    app.require_subcommand(1);
    app.set_version_flag("--version", std::string("tessera-master ") + kBuildId);
    add_cluster_options(*serve, o, t);
    add_frame_options(*view, o, t);
    view->add_option("--screenshot", o.screenshot_path,
                     "save the window as PNG after --screenshot-after frames, and end")
        ->type_name("FILE");
    view->add_option("--screenshot-after", o.screenshot_after, "frames to show before --screenshot")
        ->check(whole_in(1, 1'000'000))
        ->type_name("N");
    add_frame_options(*render, o, t);
    render->add_option("-o,--output", o.output, "OUT.(exr|png|hdr|pfm); %04d numbers a sequence")
        ->required()
        ->type_name("OUT");
    render->add_option("--frames", t.frames, "inclusive (default: 0:0)")->type_name("FIRST:LAST");
    render
        ->add_option("--orbit", o.orbit_degrees,
                     "turn the camera round the scene by so many degrees over the frames")
        ->check(number_in(-3600, 3600))
        ->type_name("DEGREES");
    status->add_option("--connect", o.session.connect, "a running master")
        ->required()
        ->type_name("HOST:PORT");
    status->add_flag("--json", o.is_json, "machine-readable");
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

Status parse_into(MasterOptions& o, Typed& t, std::vector<std::string> words,
                  std::vector<std::string>* config_words) {
  Grammar grammar(o, t);
  std::reverse(words.begin(), words.end());  // CLI11 takes them from the back
  grammar.app.parse(words);
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
  TESSERA_RETURN_IF_ERROR(check_log(o, t));
  if (o.command == Command::kStatus) return Status::ok();
  if (o.command != Command::kServe) TESSERA_RETURN_IF_ERROR(check_frame(o, t));
  return check_cluster(o, t);
}

}  // namespace

ParsedCommandLine parse_command_line(int argc, const char* const* argv) {
  std::vector<std::string> words(argv + 1, argv + argc);
  ParsedCommandLine parsed;
  const std::set<std::string> commands{"serve", "view", "render", "status"};
  if (!words.empty() && !words[0].starts_with('-') && !commands.contains(words[0])) {
    parsed.exit_code =
        usage_error("unknown command '" + words[0] + "': give serve, view, render or status");
    return parsed;
  }
  try {
    Typed typed;
    std::vector<std::string> config_words;
    Status status = parse_into(parsed.options, typed, words, &config_words);
    if (status.is_ok() && !typed.config.empty()) {
      words.insert(words.end(), config_words.begin(), config_words.end());
      parsed.options = {};
      typed = {};
      status = parse_into(parsed.options, typed, words, nullptr);
    }
    if (!status.is_ok()) parsed.exit_code = usage_error(status.message());
  } catch (const CLI::Success& success) {
    Typed typed;
    MasterOptions options;
    Grammar grammar(options, typed);
    std::reverse(words.begin(), words.end());
    try {
      grammar.app.parse(words);
    } catch (const CLI::Success& again) {
      grammar.app.exit(again);
    }
    parsed.exit_code = 0;
  } catch (const CLI::Error& error) {
    parsed.exit_code = usage_error(error.what());
  }
  return parsed;
}

}  // namespace tessera::master
