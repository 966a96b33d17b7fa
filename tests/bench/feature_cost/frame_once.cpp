// SPDX-License-Identifier: Apache-2.0
// Renders a small frame of plain diffuse triangles with one thread, by the renderer that is named:
// for core_cost.sh, which counts instructions.
#include <cstdio>

#include "tests/support/render.h"
#include "tests/support/test_meshes.h"

namespace tessera::core {

// callgrind finds this function by its name, so it is not inlined.
[[gnu::noinline]] void render_once(const PreparedScene& scene, const FrameSettings& settings,
                                   std::vector<float>& rgb) {
  TileRenderer().render(scene, settings, Isa::kAvx2, {0, 0, settings.width_px, settings.height_px},
                        rgb);
}

}  // namespace tessera::core

int main(int argc, char** argv) {
  using namespace tessera;
  const auto renderer = parse_renderer(argc == 2 ? argv[1] : "");
  if (!renderer.is_ok() || (core::supported_isas() & isa_bit(Isa::kAvx2)) == 0) return 2;
  Scene scene = test::make_scene(test::make_torus(150, 60));
  Mesh lamp;
  lamp.materials.clear();
  test::add_quad(lamp, {-1, 3, -1}, {2, 0, 0}, {0, 0, 2}, 1);
  scene.meshes.push_back(std::make_shared<const Mesh>(lamp));
  scene.instances.push_back({1, {}});
  scene.materials.resize(2);
  scene.materials[1].emission = {9, 9, 9};
  FrameSettings settings;
  settings.width_px = settings.height_px = 128;
  settings.camera = {{0.3f, 3, 2.5f}, {0, 0, 0}, {0, 1, 0}, 40};
  settings.renderer = *renderer;
  settings.bounces = 2;
  const auto prepared = core::PreparedScene::build(scene, {});
  if (!prepared.is_ok()) return 1;
  std::vector<float> rgb(std::size_t{3} * 128 * 128);
  core::render_once(**prepared, settings, rgb);
  std::printf("%g\n", static_cast<double>(rgb[3 * (128 * 64 + 64)]));
  return 0;
}
