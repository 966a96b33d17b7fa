// SPDX-License-Identifier: Apache-2.0
#include "master/commands/typed_options.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <optional>

#include "common/base/limits.h"
#include "common/base/path_suffix.h"
#include "common/frame/frame_image.h"
#include "common/net/endpoint.h"
#include "common/net/liveness.h"
#include "common/scene/validate.h"
#include "common/scene_io/camera_file.h"
#include "master/image/file_channels.h"
#include "master/loader/load_scene.h"
#include "master/session/master_host.h"

namespace tessera::master {
namespace {

Result<int> parse_int(const std::string& option, const std::string& text, int low, int high) {
  int value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || end != text.data() + text.size() || value < low || value > high) {
    return Status::invalid_argument(option + " " + text + ": give a whole number from " +
                                    std::to_string(low) + " to " + std::to_string(high));
  }
  return value;
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

// Reads an inline --camera; a camera file is read where the scene is.
Status check_camera(MasterOptions& o) {
  if (o.camera.find(',') == std::string::npos) return Status::ok();
  auto camera = parse_camera_text(o.camera);
  Status status = camera.is_ok() ? validate_camera(*camera) : camera.status();
  if (!status.is_ok()) {
    return Status::invalid_argument("--camera '" + o.camera + "': " + status.message());
  }
  o.inline_camera = *camera;
  return Status::ok();
}

// Reads "constant:R,G,B"; the file of a sky is read where the scene is.
Status check_environment(MasterOptions& o, const TypedOptions& t) {
  if (t.environment.empty()) return Status::ok();
  if (!t.environment.starts_with("constant:")) {
    o.environment_file = t.environment;
    return check_sky_name(t.environment);
  }
  Vec3f radiance;
  int used = 0;
  const bool is_read = std::sscanf(t.environment.c_str(), "constant:%f,%f,%f%n", &radiance.x,
                                   &radiance.y, &radiance.z, &used) == 3;
  const bool is_light =
      is_finite(radiance) && radiance.x >= 0 && radiance.y >= 0 && radiance.z >= 0;
  if (!is_read || used != static_cast<int>(t.environment.size()) || !is_light) {
    return Status::invalid_argument(
        "--environment " + t.environment +
        ": give constant:R,G,B, radiances from 0, such as constant:1,1,1");
  }
  o.environment = radiance;
  return Status::ok();
}

// "#rrggbb", as a display shows it. Returns: nothing where the text is no colour.
std::optional<Vec3f> parse_color(const std::string& text) {
  if (text.size() != 7 || text[0] != '#') return std::nullopt;
  unsigned code = 0;
  const auto [end, error] = std::from_chars(text.data() + 1, text.data() + 7, code, 16);
  if (error != std::errc() || end != text.data() + 7) return std::nullopt;
  const auto light = [code](int shift) {
    return srgb_decode(static_cast<float>(code >> shift & 255u) / 255);
  };
  return Vec3f{light(16), light(8), light(0)};
}

Status check_exposure(MasterOptions& o, const TypedOptions& t) {
  o.is_exposure_each = t.exposure == "auto-each";
  if (o.is_exposure_each && o.command == Command::kView)
    return Status::invalid_argument("--exposure auto-each is for render; view adapts by itself");
  if (t.exposure == "auto" || o.is_exposure_each) return Status::ok();
  float ev = 0;
  const char* const last = t.exposure.data() + t.exposure.size();
  const auto [end, error] = std::from_chars(t.exposure.data(), last, ev);
  if (error != std::errc() || end != last || !(std::fabs(ev) <= kExposureEvMax)) {
    return Status::invalid_argument(
        "--exposure " + t.exposure +
        ": give stops from -64 to 64, such as 0 or -1.5, auto, or for render auto-each");
  }
  o.look.exposure_ev = ev;
  return Status::ok();
}

Status check_look(MasterOptions& o, const TypedOptions& t) {
  auto light = parse_light_choice(t.light);
  if (!light.is_ok()) return light.status();
  o.look.light = *light;
  if (!t.environment.empty()) {  // the environment is the light
    if (*light == LightChoice::kStudio)
      return Status::invalid_argument("--light studio and --environment exclude each other");
    o.look.light = LightChoice::kScene;
  }
  if (t.background == "sky") {
    o.look.background = BackgroundChoice::kSky;
  } else if (t.background == "transparent") {  // black, so that colour is premultiplied
    o.look.background = BackgroundChoice::kColor;
    o.frame.planes.add(Plane::kAlpha);
  } else if (t.background != "auto") {
    const auto color = t.background == "black" ? Vec3f{} : parse_color(t.background);
    if (!color) {
      return Status::invalid_argument("--background " + t.background +
                                      ": give auto, sky, black, transparent or #rrggbb");
    }
    o.look.background = BackgroundChoice::kColor;
    o.look.background_color = *color;
  }
  auto tone = parse_tone_curve(t.tone);
  if (!tone.is_ok()) return tone.status();
  o.look.tone = *tone;
  return check_exposure(o, t);
}

// Whether the file can hold what is asked for besides colour.
Status check_planes(MasterOptions& o, const TypedOptions& t) {
  const std::string suffix = suffix_of(o.output);
  if (o.frame.planes.has(Plane::kAlpha)) {  // for a transparent background
    const std::string option = "--background transparent";
    if (o.command == Command::kView)
      return Status::invalid_argument(option + " is for render: a window has nothing behind it");
    if (!planes_held_by(suffix).has(Plane::kAlpha))
      return Status::invalid_argument(option + ": a " + suffix +
                                      " file cannot hold alpha; give OUT.png or OUT.exr");
    if (o.frame.pixel_format == PixelFormat::kDisplay8)
      return Status::invalid_argument(option + " needs --pixels float or half");
  }
  if (t.aov.empty()) return validate_planes(o.frame);
  auto planes = parse_planes(t.aov);
  if (!planes.is_ok()) return planes.status();
  if ((planes->bits() & ~planes_held_by(suffix).bits()) != 0)
    return Status::invalid_argument("--aov: a " + suffix + " file cannot hold it; give OUT.exr");
  o.frame.planes = PlaneSet::of_bits(o.frame.planes.bits() | planes->bits());
  return validate_planes(o.frame);
}

Status check_frame(MasterOptions& o, const TypedOptions& t) {
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
  TESSERA_RETURN_IF_ERROR(check_camera(o));
  TESSERA_RETURN_IF_ERROR(check_environment(o, t));
  TESSERA_RETURN_IF_ERROR(check_look(o, t));
  auto renderer = parse_renderer(t.renderer);
  if (!renderer.is_ok()) return renderer.status();
  o.frame.renderer = *renderer;
  auto patch_method = parse_patch_method(t.patch_method);
  if (!patch_method.is_ok()) return patch_method.status();
  o.frame.patch_method = *patch_method;
  auto pixels = parse_pixel_format(
      t.pixels.empty() ? (o.command == Command::kView ? "half" : "float") : t.pixels);
  if (!pixels.is_ok()) return pixels.status();
  o.frame.pixel_format = *pixels;
  if (t.clamp != "off") {
    o.frame.clamp = kClampAuto;
    if (t.clamp != "auto") {
      char* end = nullptr;
      o.frame.clamp = std::strtof(t.clamp.c_str(), &end);
      if (end == t.clamp.c_str() || *end != 0 || !(o.frame.clamp >= 0) ||
          !std::isfinite(o.frame.clamp))
        return Status::invalid_argument("--clamp " + t.clamp +
                                        ": give a number that is not negative, off or auto");
    }
  }
  if (t.samples != "auto") {
    auto samples = parse_int("--aa", t.samples, 1, kSamplesPerPixelMax);
    if (!samples.is_ok()) return samples.status();
    o.frame.samples_per_pixel = *samples;
  }
  // A person who gives --passes has chosen how many samples there are.
  o.has_usual_samples = o.command == Command::kRender && t.samples == "auto" && o.passes == 0;
  o.frame.tile_edge_px = kTileEdgeAuto;
  if (t.tile != "auto") {
    auto tile = parse_int("--tile", t.tile, kTileEdgeMinPx, kTileEdgeMaxPx);
    if (!tile.is_ok()) return tile.status();
    o.frame.tile_edge_px = *tile;
  }
  return check_planes(o, t);
}

Status check_cluster(MasterOptions& o, const TypedOptions& t) {
  if (t.isa != "auto") {
    auto isa = parse_isa(t.isa);
    if (!isa.is_ok()) return isa.status();
    o.session.isa = *isa;
  }
  if (t.isa_policy != "same" && t.isa_policy != "mixed") {
    return Status::invalid_argument("--isa-policy " + t.isa_policy + ": give same or mixed");
  }
  o.session.is_isa_mixed = t.isa_policy == "mixed";
  if (o.session.is_isa_mixed && o.session.audit_percent.value_or(0) > 0) {
    return Status::invalid_argument(
        "--audit compares pixels to the bit, and slaves of several instruction sets do not render "
        "the same bits; leave out --isa-policy mixed");
  }
  if (t.relay != "on" && t.relay != "off") {
    return Status::invalid_argument("--relay " + t.relay + ": give on or off");
  }
  o.session.is_relaying = t.relay == "on";
  if (t.pixel_coding != "auto" && t.pixel_coding != "off") {
    return Status::invalid_argument("--pixel-coding " + t.pixel_coding + ": give auto or off");
  }
  o.session.is_pixel_coding = t.pixel_coding == "auto";
  if (t.prefetch != "auto") {
    auto prefetch = parse_int("--prefetch", t.prefetch, 0, kTilesPerWorkerMax - 1);
    if (!prefetch.is_ok()) return prefetch.status();
    o.session.prefetch_per_thread = *prefetch;
  }
  auto heartbeat = parse_int("--heartbeat", t.heartbeat, net::Pulse::kHeartbeatMsLeast,
                             net::Pulse::kHeartbeatMsMost);
  if (!heartbeat.is_ok()) return heartbeat.status();
  o.session.heartbeat_ms = static_cast<std::uint32_t>(*heartbeat);
  auto missed = parse_int("--heartbeats-missed", t.heartbeats_missed, 1, net::Pulse::kMissedMost);
  if (!missed.is_ok()) return missed.status();
  o.session.heartbeats_missed_max = static_cast<std::uint32_t>(*missed);
  if (t.faulty_pixels != "colour" && t.faulty_pixels != "fail") {
    return Status::invalid_argument("--faulty-pixels " + t.faulty_pixels + ": give colour or fail");
  }
  o.session.is_faulty_frame_failed = t.faulty_pixels == "fail";
  if (t.schedule != "dynamic" && t.schedule != "static") {
    return Status::invalid_argument("--schedule " + t.schedule + ": give dynamic or static");
  }
  o.session.is_static = t.schedule == "static";
  if (t.scene_transfer != "async" && t.scene_transfer != "sync") {
    return Status::invalid_argument("--scene-transfer " + t.scene_transfer +
                                    ": give async or sync");
  }
  o.session.is_scene_transfer_sync = t.scene_transfer == "sync";
  const bool is_serve = o.command == Command::kServe;
  if (is_serve && o.session.listen.empty()) o.session.listen = "127.0.0.1:7400";
  const bool others_may_come = !o.session.listen.empty() || !o.session.connect.empty();
  const bool is_local_needed = !others_may_come && o.session.slaves_min == 0;
  o.session.local_slaves = t.local != TypedOptions::kLocalAuto ? t.local : is_local_needed ? 1 : 0;
  o.session.local_threads = static_cast<int>(t.threads);
  if (!o.session.connect.empty() && (!o.session.listen.empty() || t.local > 0)) {
    return Status::invalid_argument(
        "--connect uses a running master; --listen and --local belong to that one");
  }
  const int slaves_needed = std::max(1, o.session.slaves_min);
  if (!others_may_come && o.session.local_slaves < slaves_needed) {
    return Status::invalid_argument((o.session.slaves_min > 0
                                         ? "--slaves " + std::to_string(o.session.slaves_min)
                                         : "--local 0") +
                                    ": nobody can come; add --listen HOST:PORT or --local N");
  }
  return Status::ok();
}

// Checks the two ends that a session may have on the network, and their credentials.
Status check_links(const MasterOptions& o) {
  struct Link {
    const char *option, *role;
    const std::string& address;
  };
  for (const Link& link : {Link{"--listen", "master", o.session.listen},
                           Link{"--connect", "app", o.session.connect}}) {
    if (link.address.empty()) continue;
    const auto refuse = [&](const Status& status) {
      return Status::invalid_argument(std::string(link.option) + " " + status.message());
    };
    auto endpoints = net::parse_endpoints(link.address);
    if (!endpoints.is_ok()) return refuse(endpoints.status());
    for (const net::Endpoint& endpoint : *endpoints) {
      const Status status = check_credentials(o.session, endpoint, link.role);
      if (!status.is_ok()) return refuse(status);
    }
  }
  if (!o.session.keys_folder.empty() && o.session.is_plain) {
    return Status::invalid_argument("--keys and --plain exclude each other; give one of them");
  }
  return Status::ok();
}

Status check_watching(const MasterOptions& o) {
  const SessionOptions& s = o.session;
  if (s.trace_seconds > 0 && s.trace_path.empty()) {
    return Status::invalid_argument("--trace-seconds needs --trace FILE.json");
  }
  if (!s.connect.empty() && !(s.metrics.empty() && s.trace_path.empty())) {
    return Status::invalid_argument(
        "--metrics and --trace watch a master inside this process, and --connect uses another: "
        "give them to 'tessera-master serve'");
  }
  if (s.metrics.empty()) return Status::ok();
  const auto endpoint = net::parse_endpoint(s.metrics);
  if (!endpoint.is_ok()) {
    return Status::invalid_argument("--metrics " + endpoint.status().message());
  }
  if (!net::is_loopback(*endpoint)) {
    return Status::invalid_argument("--metrics " + s.metrics +
                                    " is not loopback, and the page has neither keys nor "
                                    "encryption: give 127.0.0.1:PORT");
  }
  return Status::ok();
}

Status check_log(MasterOptions& o, const TypedOptions& t) {
  auto level = parse_log_level(t.log_level);
  if (!level.is_ok()) return level.status();
  o.log_level = o.is_quiet ? std::max(*level, LogLevel::kWarn) : *level;
  if (t.log_format != "text" && t.log_format != "json") {
    return Status::invalid_argument("--log-format " + t.log_format + ": give text or json");
  }
  o.log_format = t.log_format == "json" ? LogFormat::kJson : LogFormat::kText;
  return Status::ok();
}

}  // namespace

Status check_options(const TypedOptions& t, MasterOptions& o) {
  TESSERA_RETURN_IF_ERROR(check_log(o, t));
  if (o.command == Command::kView || o.command == Command::kRender) {
    TESSERA_RETURN_IF_ERROR(check_frame(o, t));
    TESSERA_RETURN_IF_ERROR(check_scene_name(o.scene));
  }
  if (o.command != Command::kStatus) TESSERA_RETURN_IF_ERROR(check_cluster(o, t));
  TESSERA_RETURN_IF_ERROR(check_watching(o));
  return check_links(o);
}

}  // namespace tessera::master
