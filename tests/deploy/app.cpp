// SPDX-License-Identifier: Apache-2.0
// The smallest application: one triangle, one picture, a master and a slave inside the process.
#include <cstdio>

#include "common/viewpoint/scene_overview.h"
#include "master/session/session.h"

int main() {
  tessera::Scene scene;
  auto mesh = std::make_shared<tessera::Mesh>();
  mesh->positions = {{-1, -1, 0}, {1, -1, 0}, {0, 1, 0}};
  mesh->triangles = {{0, 1, 2}};
  mesh->materials = {0};
  scene.meshes = {mesh};
  scene.materials.resize(1);
  scene.instances.resize(1);

  tessera::SessionOptions options;
  options.local_slaves = 1;
  auto session = tessera::Session::open(options);
  if (!session.is_ok()) return std::puts(session.status().message().c_str()), 1;
  tessera::FrameSettings settings;
  settings.width_px = settings.height_px = 64;
  settings.camera = tessera::default_camera(scene, settings.width_px, settings.height_px);
  const auto version = (*session)->commit_scene(scene);
  const auto frame = (*session)->submit(settings);
  if (!version.is_ok() || !frame.is_ok()) return std::puts("refused"), 1;
  auto result = (*session)->next_frame(std::chrono::seconds(30));
  if (!result.is_ok() || !result->status.is_ok()) return std::puts("no frame"), 1;
  std::printf("%s\n", result->image->digest().hex().c_str());
  return 0;
}
