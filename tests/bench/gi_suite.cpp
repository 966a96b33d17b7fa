// SPDX-License-Identifier: Apache-2.0
#include "tests/bench/gi_suite.h"

#include <algorithm>
#include <cstdio>

#include "common/base/json.h"
#include "master/loader/load_scene.h"
#include "tests/bench/gi_error.h"
#include "tests/bench/gi_speed.h"
#include "tests/bench/gi_surfaces.h"

namespace tessera::bench {
namespace {

// Only those of the built-in scenes in which indirect light matters.
constexpr const char* kScenes[] = {"cornell", "room"};

}  // namespace

std::vector<std::string> gi_scene_names() { return {std::begin(kScenes), std::end(kScenes)}; }

Status run_gi_suite(const CoreSuiteOptions& options, std::vector<std::string>& json) {
  const auto is_wanted = [&](const char* part) {
    return options.only.empty() || options.only == part;
  };
  for (const std::string& name : gi_scene_names()) {
    if (!options.scenes.empty() &&
        std::find(options.scenes.begin(), options.scenes.end(), name) == options.scenes.end())
      continue;
    std::fprintf(stderr, "making %s\n", name.c_str());
    auto loaded = master::make_builtin(name);
    if (!loaded.is_ok()) return loaded.status();
    auto scene = core::PreparedScene::build(loaded->scene, {});
    if (!scene.is_ok()) return scene.status();
    std::printf("\n%s, %llu triangles\n", name.c_str(),
                static_cast<unsigned long long>((*scene)->primitive_count()));
    FrameSettings settings;
    settings.renderer = Renderer::kIgi;
    settings.tile_edge_px = 64;
    if (loaded->scene.camera) settings.camera = *loaded->scene.camera;
    JsonObject object;
    object.add("scene", name);
    if (is_wanted("speed")) {
      object.add_raw("speed", measure_speed(**scene, settings, options));
      object.add_raw("surfaces", measure_surfaces(loaded->scene, settings, options));
    }
    if (is_wanted("error")) object.add_raw("error", measure_error(**scene, settings, options));
    json.push_back(object.text());
  }
  return Status::ok();
}

}  // namespace tessera::bench
