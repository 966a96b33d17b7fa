// SPDX-License-Identifier: Apache-2.0
// An application whose scene never stands still, for tests. It prints a frame's digest a line.
//   edits_app edit SEED FRAMES MASTER:PORT KEYS_FOLDER   changes drawn from the seed, committed
//   edits_app steady SEED FRAMES MASTER:PORT KEYS_FOLDER   likewise, and it stays as large as it is
//   edits_app whole SEED FRAMES     the same scenes, each made, sent and built in one go
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <memory>
#include <random>
#include <string>
#include <vector>

#include "master/session/session.h"

namespace {

using tessera::Mesh;
using tessera::ObjectName;
using tessera::Status;
using tessera::Vec3f;
using Random = std::mt19937;

constexpr std::uint32_t kSide = 40;  // quads along a side of a sheet
constexpr std::chrono::seconds kPatience{600};

float unit(Random& random) { return std::uniform_real_distribution<float>(-1, 1)(random); }

int below(Random& random, int count) {
  return std::uniform_int_distribution<int>(0, count - 1)(random);
}

float height(std::uint32_t i, float phase) {
  return 0.2f * std::sin(0.3f * static_cast<float>(i % (kSide + 1)) + phase);
}

std::shared_ptr<const Mesh> make_sheet() {
  auto sheet = std::make_shared<Mesh>();
  for (std::uint32_t i = 0; i < (kSide + 1) * (kSide + 1); ++i) {
    const auto x = static_cast<float>(i % (kSide + 1)), y = static_cast<float>(i / (kSide + 1));
    sheet->positions.push_back({2 * x / kSide - 1, 2 * y / kSide - 1, height(i, 0)});
  }
  for (std::uint32_t y = 0; y < kSide; ++y) {
    for (std::uint32_t x = 0; x < kSide; ++x) {
      const std::uint32_t at = y * (kSide + 1) + x;
      sheet->triangles.push_back({at, at + 1, at + kSide + 2});
      sheet->triangles.push_back({at, at + kSide + 2, at + kSide + 1});
    }
  }
  sheet->materials = {0};
  return sheet;
}

tessera::Transform place(Random& random) {
  const float angle = 3 * unit(random), size = 0.6f + 0.3f * unit(random);
  tessera::Transform t;
  t.m[0] = {size * std::cos(angle), -size * std::sin(angle), 0, 3 * unit(random)};
  t.m[1] = {size * std::sin(angle), size * std::cos(angle), 0, 2 * unit(random)};
  t.m[2] = {0, 0, size, unit(random)};
  return t;
}

class Scenery {
 public:
  explicit Scenery(std::uint32_t seed) : random_(seed) {
    check(edits_.set_environment({0.4f, 0.4f, 0.5f}));
    tessera::Light light;
    light.position = {3, 3, 5};
    light.intensity = {30, 30, 25};
    check(edits_.add_light(light).status());
    for (int i = 0; i < 12; ++i) add();
  }

  // One object moves, another one waves, and a third one goes as a new one comes.
  void change_steadily() {
    check(edits_.set_transform(names_[any()], place(random_)));
    deform(names_[any()]);
    remove(any());
    add();
  }

  void change() {
    for (int i = 1 + below(random_, 3); i > 0; --i) change_once();
  }
  tessera::SceneEdits& edits() { return edits_; }

  // Nothing of it is shared with anything.
  tessera::Scene whole() {
    tessera::Scene scene = edits_.scene();
    for (auto& mesh : scene.meshes) mesh = std::make_shared<const Mesh>(*mesh);
    return scene;
  }

 private:
  static void check(const Status& status) {
    if (status.is_ok()) return;
    std::puts(status.message().c_str());
    std::exit(1);
  }

  std::size_t any() {
    return static_cast<std::size_t>(below(random_, static_cast<int>(names_.size())));
  }

  void remove(std::size_t at) {
    check(edits_.remove_object(names_[at]));
    names_.erase(names_.begin() + static_cast<std::ptrdiff_t>(at));
  }

  void add() {
    auto name = edits_.add_object(make_sheet(), place(random_));
    check(name.status());
    names_.push_back(*name);
  }

  void change_once() {
    const std::size_t at = any();
    tessera::Material material;
    material.albedo = {0.5f + 0.4f * unit(random_), 0.5f, 0.5f};
    switch (below(random_, 8)) {
      case 0:
        return check(edits_.set_material(0, material));
      case 1:
        return add();
      case 2:
        if (names_.size() >= 6) remove(at);
        return;
      case 3:
      case 4:
        return deform(names_[at]);
      default:
        return check(edits_.set_transform(names_[at], place(random_)));
    }
  }

  void deform(ObjectName object) {
    const std::vector<Vec3f> rest = make_sheet()->positions;
    const auto first = static_cast<std::size_t>(below(random_, static_cast<int>(rest.size() / 2)));
    std::vector<Vec3f> moved(rest.begin() + static_cast<std::ptrdiff_t>(first), rest.end());
    const float phase = 3 * unit(random_);
    for (std::size_t i = 0; i < moved.size(); ++i)
      moved[i].z = height(static_cast<std::uint32_t>(first + i), phase);
    check(edits_.set_positions(object, first, moved));
  }

  Random random_;
  tessera::SceneEdits edits_;
  std::vector<ObjectName> names_;
};

tessera::FrameSettings settings() {
  tessera::FrameSettings s;
  s.width_px = 96;
  s.height_px = 72;
  s.tile_edge_px = 16;
  s.renderer = tessera::Renderer::kDirect;
  s.camera = {{0, 0, 9}, {0, 0, 0}, {0, 1, 0}, 40};
  return s;
}

// Returns: what is wrong.
Status print_next(tessera::Session& session) {
  auto result = session.next_frame(kPatience);
  if (!result.is_ok()) return result.status();
  if (!result->status.is_ok()) return result->status;
  std::printf("%s\n", result->image->digest().hex().c_str());
  std::fflush(stdout);
  return Status::ok();
}

// Two frames are in work, of two versions.
Status edit(Scenery& scenery, bool is_steady, int frames, const std::string& connect,
            const std::string& keys) {
  tessera::SessionOptions options;
  options.connect = connect;
  options.keys_folder = keys;
  auto session = tessera::Session::open(options);
  if (!session.is_ok()) return session.status();
  for (int i = 0; i < frames; ++i) {
    is_steady ? scenery.change_steadily() : scenery.change();
    if (auto version = (*session)->commit(scenery.edits()); !version.is_ok())
      return version.status();
    if (auto frame = (*session)->submit(settings()); !frame.is_ok()) return frame.status();
    if (i == 0) continue;
    if (const Status status = print_next(**session); !status.is_ok()) return status;
  }
  return print_next(**session);
}

Status show_whole(Scenery& scenery, int frames) {
  for (int i = 0; i < frames; ++i) {
    scenery.change();
    tessera::SessionOptions options;
    options.local_slaves = options.local_threads = 1;
    auto session = tessera::Session::open(options);
    if (!session.is_ok()) return session.status();
    auto version = (*session)->commit_scene(scenery.whole());
    if (!version.is_ok()) return version.status();
    if (auto frame = (*session)->submit(settings()); !frame.is_ok()) return frame.status();
    if (const Status status = print_next(**session); !status.is_ok()) return status;
  }
  return Status::ok();
}

}  // namespace

int main(int argc, char** argv) {
  const std::string how = argc > 1 ? argv[1] : "";
  const bool is_steady = how == "steady";
  const bool is_edit = (how == "edit" || is_steady) && argc == 6;
  if (!is_edit && !(how == "whole" && argc == 4)) {
    std::puts("usage: edits_app edit|steady SEED FRAMES MASTER:PORT KEYS | whole SEED FRAMES");
    return 2;
  }
  Scenery scenery(static_cast<std::uint32_t>(std::strtoul(argv[2], nullptr, 10)));
  const int frames = std::atoi(argv[3]);
  const Status status =
      is_edit ? edit(scenery, is_steady, frames, argv[4], argv[5]) : show_whole(scenery, frames);
  if (status.is_ok()) return 0;
  std::fprintf(stderr, "%s\n", status.message().c_str());
  return 1;
}
