// SPDX-License-Identifier: Apache-2.0
#include "tests/bench/gi_surfaces.h"

#include <cstdio>
#include <vector>

#include "common/base/json.h"
#include "common/scene/validate.h"
#include "slave/core/scene/prepared_scene.h"
#include "tests/bench/gi_frame.h"

namespace tessera::bench {
namespace {

struct Subject {
  const char* name;
  std::shared_ptr<const core::PreparedScene> scene;
  std::vector<double> seconds;
};

// `scale`: factor on the default lengths of patterns, so that a scene has as many of them as a room
// of 4 units.
Subject make_subject(Scene scene, SurfaceKind kind, float scale) {
  const SurfaceProgramShape* shape = find_surface_program(kind);
  for (Material& material : scene.materials) {
    material.surface.kind = kind;
    material.surface.parameters = shape->defaults;
    float* first = material.surface.parameters.data();
    if (kind == SurfaceKind::kBrick) {
      for (int i = 0; i < 3; ++i) first[i] *= scale;  // width, height, mortar
    } else {
      *first /= scale;  // frequency
    }
  }
  auto prepared = core::PreparedScene::build(scene, {});
  return {shape->name, prepared.is_ok() ? *prepared : nullptr, {}};
}

}  // namespace

std::string measure_surfaces(const Scene& scene, const FrameSettings& settings,
                             const CoreSuiteOptions& options) {
  FrameSettings s = settings;
  s.width_px = options.is_quick ? 128 : 640;
  s.height_px = options.is_quick ? 96 : 480;
  const float scale = length(scene_bounds(scene).extent()) / 7;
  std::vector<Subject> subjects;
  for (const SurfaceKind kind :
       {SurfaceKind::kConstant, SurfaceKind::kMarble, SurfaceKind::kWood, SurfaceKind::kBrick})
    subjects.push_back(make_subject(scene, kind, scale));
  // The subjects take turns, so that ratios are of one run.
  for (int repeat = 0; repeat < (options.is_quick ? 1 : options.repeats); ++repeat) {
    for (Subject& subject : subjects)
      subject.seconds.push_back(render_gi(*subject.scene, s, options.isa).cpu_seconds);
  }
  JsonObject o;
  for (std::size_t i = 1; i < subjects.size(); ++i) {
    const double ratio = median(subjects[i].seconds) / median(subjects[0].seconds);
    std::printf("  everything of %-44s %8.2f\n", subjects[i].name, ratio);
    o.add(subjects[i].name, ratio);
  }
  std::fflush(stdout);
  return o.text();
}

}  // namespace tessera::bench
