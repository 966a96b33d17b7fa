// SPDX-License-Identifier: Apache-2.0
// Moves one object of 10,000, as an application does: it says the one matrix that is different, and
// commits. Usage: moving MASTER:PORT KEYS_FOLDER FRAMES FRAMES_PER_SECOND
#include <cstdio>
#include <cstdlib>
#include <thread>

#include "master/session/session.h"

namespace {

tessera::Transform at(float x, float y, float z) {
  tessera::Transform place;
  place.m = {{{0.4f, 0, 0, x}, {0, 0.4f, 0, y}, {0, 0, 0.4f, z}}};
  return place;
}

int fail(const tessera::Status& status) { return std::puts(status.message().c_str()), 1; }

}  // namespace

int main(int argc, char** argv) {
  if (argc != 5) return std::puts("usage: moving MASTER:PORT KEYS_FOLDER FRAMES PER_SECOND"), 2;
  const int frames = std::atoi(argv[3]);
  const std::chrono::duration<double> period(1 / std::atof(argv[4]));
  auto mesh = std::make_shared<tessera::Mesh>();
  mesh->positions = {{-1, -1, -1}, {1, -1, -1}, {0, 1, -1}, {0, 0, 1}};
  mesh->triangles = {{0, 2, 1}, {0, 1, 3}, {1, 2, 3}, {2, 0, 3}};
  mesh->materials = {0};

  tessera::SceneEdits edits;
  for (int i = 0; i < 10'000; ++i) {
    const auto x = static_cast<float>(i % 100), y = static_cast<float>(i / 100);
    if (auto object = edits.add_object(mesh, at(x, y, 0)); !object.is_ok())
      return fail(object.status());
  }
  if (auto lit = edits.set_environment({1, 1, 1}); !lit.is_ok()) return fail(lit);

  tessera::SessionOptions options;
  options.connect = argv[1];
  options.keys_folder = argv[2];
  auto session = tessera::Session::open(options);
  if (!session.is_ok()) return fail(session.status());
  tessera::FrameSettings settings;
  settings.width_px = settings.height_px = 64;
  settings.camera = {{50, 50, 40}, {50, 50, 0}, {0, 1, 0}, 53};
  for (int i = 0; i < frames; ++i) {
    const auto next = std::chrono::steady_clock::now() + period;
    const auto moved = edits.set_transform(4950, at(50, 49.5f, static_cast<float>(i % 60) * 0.5f));
    if (!moved.is_ok()) return fail(moved);
    if (auto version = (*session)->commit(edits); !version.is_ok()) return fail(version.status());
    if (auto frame = (*session)->submit(settings); !frame.is_ok()) return fail(frame.status());
    auto result = (*session)->next_frame(std::chrono::seconds(60));
    if (!result.is_ok()) return fail(result.status());
    if (!result->status.is_ok()) return fail(result->status);
    std::printf("%s\n", result->image->digest().hex().c_str());
    std::this_thread::sleep_until(next);
  }
  return 0;
}
