// SPDX-License-Identifier: Apache-2.0
// Settles how a scene is lit, backed and exposed where its file leaves that open: once, before the
// first frame, by small pictures of the scene itself. The session renders them like any frame, so
// they have the same bits on any cluster.
//
// Threads. The application's, which owns the session. Requires: none of its frames is in work.
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <string_view>

#include "common/base/api.h"
#include "master/session/session.h"

namespace tessera {

// Who lights a scene.
enum class LightChoice {
  kAuto,   // the scene, or a studio sky where its light does not show what the camera sees
  kScene,  // the scene
  kStudio  // a studio sky, and surfaces that shine; lamps and sky of the scene are off
};

// What is seen behind the scene.
enum class BackgroundChoice {
  kAuto,  // a soft gradient where a studio lights the scene, else the sky
  kSky,   // the radiance of the sky
  kColor  // one colour, shown as it is given
};

struct LookOptions {
  LightChoice light = LightChoice::kAuto;
  BackgroundChoice background = BackgroundChoice::kAuto;
  Vec3f background_color{};          // kColor: linear light of the display, in [0, 1]
  std::optional<float> exposure_ev;  // none: automatic
  ToneCurve tone = ToneCurve::kLinear;
};

Result<LightChoice> parse_light_choice(std::string_view text);

// The settled look, which is applied to every version of the scene.
struct Look {
  DisplayTransform display;
  bool has_studio = false;
  std::shared_ptr<const EnvironmentMap> studio_sky;  // null: the scene's own
  bool has_lamps = true;                             // those of the scene stay on
  Background background;
  std::string words;          // one line for a person; empty: nothing was added
  bool is_committed = false;  // the session shows the scene with all this already
  SceneCost scene_cost;       // of the pictures that settled it

  TESSERA_API void apply(Scene& scene) const;
};

// Renders small pictures where they are needed, two for each metering and four at most. settings:
// those of the first frame; should_stop: asked while waiting. Returns: the session's refusal, or
// kCancelled.
TESSERA_API Result<Look> settle_look(Session& session, const Scene& scene,
                                     const FrameSettings& settings, const LookOptions& options,
                                     const std::function<bool()>& should_stop);

struct SettledExposure {
  float ev = 0;
  SceneCost scene_cost;  // of the pictures that settled it
};
// The automatic exposure of one view, for a look that stays. Requires: the session has the scene.
TESSERA_API Result<SettledExposure> settle_exposure(Session& session, const FrameSettings& settings,
                                                    const std::function<bool()>& should_stop);

}  // namespace tessera
