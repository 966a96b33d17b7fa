// SPDX-License-Identifier: Apache-2.0
// Property: on a teapot of patches in car paint, beside glass, under a sky, instant global
// illumination shows the light that the reference does, and prints how much.
#include <gtest/gtest.h>

#include <cstdio>

#include "master/loader/load_scene.h"
#include "tests/support/render.h"

namespace tessera::core {
namespace {

double mean_of(const Scene& scene, Renderer renderer, int samples) {
  FrameSettings settings;
  settings.width_px = 64;
  settings.height_px = 48;
  settings.camera = *scene.camera;
  settings.renderer = renderer;
  settings.samples_per_pixel = samples;
  double sum = 0;
  const std::vector<float> rgb = test::render(scene, settings);
  for (const float x : rgb) sum += double{x};
  return sum / static_cast<double>(rgb.size());
}

// Of the light that glass gathers, which the reference knows, instant global illumination has none:
// it goes through glass on the way from the camera alone.
TEST(CarPaint, IgiShowsTheLightOfTheReference) {
  const auto loaded = master::make_builtin("paint");
  ASSERT_TRUE(loaded.is_ok());
  Scene without_glass = loaded->scene;
  for (Material& material : without_glass.materials)
    if (material.bsdf == BsdfKind::kGlass) material = without_glass.materials[0];
  Scene close = loaded->scene;  // where paint fills the picture
  close.camera = Camera{{1.5f, 3.2f, 6.5f}, {0.1f, 1.3f, 0}, {0, 1, 0}, 26};
  struct Row {
    const char* name;
    const Scene& scene;
    double off;
  };
  for (const Row& row : {Row{"paint and glass", loaded->scene, 0.08},
                         Row{"paint in place of glass", without_glass, 0.04},
                         Row{"paint, from near by", close, 0.03}}) {
    const double path = mean_of(row.scene, Renderer::kPath, 64);
    const double igi = mean_of(row.scene, Renderer::kIgi, 16);
    std::printf("%s: mean of igi %.4f, of path %.4f, ratio %.4f\n", row.name, igi, path,
                igi / path);
    EXPECT_NEAR(igi / path, 1, row.off) << row.name;
  }
}

}  // namespace
}  // namespace tessera::core
