// SPDX-License-Identifier: Apache-2.0
#include "master/look/first_look.h"

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "master/look/meter.h"
#include "master/look/studio_sky.h"

namespace tessera {
namespace {

constexpr int kPilotPixels = 4096;  // enough for a share of a quarter to be good to 0.7 %
constexpr std::chrono::milliseconds kPoll{100};

bool is_dark(Vec3f c) { return !(c.x > 0 || c.y > 0 || c.z > 0); }

// Whether there is anything that could light the scene; whether it does, pictures tell.
bool has_light(const Scene& scene) {
  const auto shines = [](const Material& m) { return m.is_unlit || !is_dark(m.emission); };
  return !scene.lights.empty() || !is_dark(scene.environment) ||
         std::any_of(scene.materials.begin(), scene.materials.end(), shines);
}

// The view of `frame` with few pixels; other settings stay, since they decide how bright it is.
FrameSettings pilot_settings(const FrameSettings& frame) {
  FrameSettings s = frame;
  const double aspect = static_cast<double>(frame.width_px) / frame.height_px;
  const double width = std::sqrt(kPilotPixels * aspect);
  s.width_px = std::clamp(static_cast<int>(std::lround(width)), 1, frame.width_px);
  s.height_px = std::clamp(static_cast<int>(std::lround(width / aspect)), 1, frame.height_px);
  s.pixel_format = PixelFormat::kFloat;
  s.tile_edge_px = 16;  // several tiles, for several slaves
  s.samples_per_pixel = 1;
  s.display = {};
  s.planes = {};
  s.pass = 0;
  return s;
}

Result<std::vector<float>> picture(Session& session, const FrameSettings& settings,
                                   const std::function<bool()>& should_stop, SceneCost& cost) {
  auto frame = session.submit(settings);
  if (!frame.is_ok()) return frame.status();
  while (true) {
    auto result = session.next_frame(kPoll);
    if (should_stop()) return Status::cancelled("interrupted before the first picture");
    if (!result.is_ok()) {
      if (result.status().code() == StatusCode::kDeadlineExceeded) continue;
      return result.status();
    }
    if (result->frame != *frame) continue;
    if (!result->status.is_ok()) return result->status;
    cost += result->stats.scene_cost;
    std::vector<float> rgb(result->image->bytes.size() / sizeof(float));
    decode_pixels(result->image->bytes, result->image->format, rgb);
    return rgb;
  }
}

Result<master::Metering> meter_view(Session& session, const FrameSettings& frame,
                                    const std::function<bool()>& should_stop, SceneCost& cost) {
  FrameSettings settings = pilot_settings(frame);
  auto rgb = picture(session, settings, should_stop, cost);
  if (!rgb.is_ok()) return rgb.status();
  settings.renderer = Renderer::kPrimary;
  auto distance = picture(session, settings, should_stop, cost);
  if (!distance.is_ok()) return distance.status();
  return master::meter(*rgb, *distance);
}

void light_by_studio(const Scene& scene, const FrameSettings& settings, bool is_asked_for,
                     Look& look) {
  look.has_studio = true;
  look.has_lamps = !is_asked_for;
  look.studio_sky = master::make_studio_sky(settings.camera.eye - settings.camera.target);
  if (is_asked_for) return;
  look.words = has_light(scene)
                   ? "the scene's own light does not reach what the camera sees: a studio sky is "
                     "added (--light scene: not)"
                   : "the scene has no light: a studio sky is added (--light scene: not)";
}

void set_background(const LookOptions& options, Look& look) {
  const bool is_gradient = options.background == BackgroundChoice::kAuto
                               ? look.has_studio
                               : options.background == BackgroundChoice::kColor;
  if (!is_gradient) return;
  look.is_committed = false;
  look.background.kind = BackgroundKind::kGradient;
  const bool is_color = options.background == BackgroundChoice::kColor;
  look.background.low =
      radiance_of(is_color ? options.background_color : master::kStudioLow, look.display);
  look.background.high =
      radiance_of(is_color ? options.background_color : master::kStudioHigh, look.display);
}

}  // namespace

Result<LightChoice> parse_light_choice(std::string_view text) {
  if (text == "auto") return LightChoice::kAuto;
  if (text == "scene") return LightChoice::kScene;
  if (text == "studio") return LightChoice::kStudio;
  return Status::invalid_argument("--light " + std::string(text) + ": give auto, scene or studio");
}

void Look::apply(Scene& scene) const {
  if (studio_sky) {
    scene.environment = {1, 1, 1};
    scene.environment_map = studio_sky;
  }
  if (!has_lamps) scene.lights.clear();
  if (background.kind != BackgroundKind::kSky) scene.background = background;
}

Result<Look> settle_look(Session& session, const Scene& scene, const FrameSettings& settings,
                         const LookOptions& options, const std::function<bool()>& should_stop) {
  Look look;
  look.display = {options.exposure_ev.value_or(0), options.tone};
  if (settings.renderer == Renderer::kPrimary) {  // distances: there is nothing to light or expose
    look.display = {};
    return look;
  }
  std::optional<master::Metering> metered;
  const auto meter_scene = [&](const Scene& shown) -> Status {
    look.is_committed = true;
    auto version = session.commit_scene(shown);
    if (!version.is_ok()) return version.status();
    auto metering = meter_view(session, settings, should_stop, look.scene_cost);
    if (!metering.is_ok()) return metering.status();
    metered = *metering;
    return Status::ok();
  };
  if (options.light == LightChoice::kStudio) {
    light_by_studio(scene, settings, true, look);
  } else if (options.light == LightChoice::kAuto) {
    const bool may_be_lit = has_light(scene);
    if (may_be_lit) TESSERA_RETURN_IF_ERROR(meter_scene(scene));
    const bool is_lit =
        metered && (metered->seen_share >= master::kSeenShareMin || !metered->has_surface);
    if (!is_lit) {
      light_by_studio(scene, settings, false, look);
      look.is_committed = false;
      metered.reset();
    }
  }
  const bool is_studio_alone =
      look.has_studio && (options.light == LightChoice::kStudio || !has_light(scene));
  if (!options.exposure_ev) {
    if (!metered) {
      Scene shown = scene;
      look.apply(shown);
      TESSERA_RETURN_IF_ERROR(meter_scene(shown));
    }
    look.display.exposure_ev =
        is_studio_alone ? master::studio_exposure_ev(metered->exposure_ev) : metered->exposure_ev;
  }
  set_background(options, look);
  return look;
}

Result<SettledExposure> settle_exposure(Session& session, const FrameSettings& settings,
                                        const std::function<bool()>& should_stop) {
  SettledExposure exposure;
  auto metering = meter_view(session, settings, should_stop, exposure.scene_cost);
  if (!metering.is_ok()) return metering.status();
  exposure.ev = metering->exposure_ev;
  return exposure;
}

}  // namespace tessera
