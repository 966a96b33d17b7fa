// SPDX-License-Identifier: Apache-2.0
#include "tests/bench/move_suite.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <memory>
#include <random>
#include <utility>

#include "common/base/json.h"
#include "common/scene/scene_codec.h"
#include "slave/core/scene/prepared_scene.h"
#include "slave/core/scene/ray_caster.h"
#include "tests/bench/contender.h"
#include "tests/bench/shape_builder.h"
#include "tests/support/test_meshes.h"

namespace tessera::bench {
namespace {

using Prepared = std::shared_ptr<const core::PreparedScene>;

struct Crowd {
  int instances;  // of one mesh, in a square
  int segments;   // of that mesh, a ball of 2 * segments^2 triangles
  int ground;     // cells along a side of a mesh that stands once
};

// How many triangles stand for how much is told by the tables, so these are few.
constexpr Crowd kCrowds[] = {{100, 64, 64},    {10'000, 16, 64},  {10'000, 64, 64},
                             {2'000, 256, 64}, {10'000, 64, 512}, {100'000, 16, 64}};

std::shared_ptr<const Mesh> with_material(Mesh mesh) {
  mesh.materials = {0};
  return std::make_shared<const Mesh>(std::move(mesh));
}

std::shared_ptr<const Mesh> ball(int segments) {
  ShapeBuilder b;
  b.add_superellipsoid({0, 0, 0.5f}, {0.4f, 0.4f, 0.5f}, 1, 1, 2 * segments, segments / 2);
  return with_material(b.take());
}

std::shared_ptr<const Mesh> ground(int cells, float size) {
  ShapeBuilder b;
  b.add_surface(cells, cells, [size](float u, float v) {
    return Vec3f{size * u, size * v, 0.2f * std::sin(40 * u) * std::cos(30 * v)};
  });
  return with_material(b.take());
}

Scene scene_of(const Crowd& crowd) {
  const int side = static_cast<int>(std::ceil(std::sqrt(static_cast<double>(crowd.instances))));
  Scene scene = test::make_scene(*ground(crowd.ground, static_cast<float>(side)));
  scene.meshes.push_back(ball(crowd.segments));
  scene.instances.clear();
  scene.instances.push_back({0, {}});
  for (int i = 0; i < crowd.instances; ++i) {
    Instance instance;
    instance.mesh = 1;
    instance.object_to_world.m[0][3] = static_cast<float>(i % side);
    instance.object_to_world.m[1][3] = static_cast<float>(i / side);
    scene.instances.push_back(instance);
  }
  return scene;
}

Result<Prepared> prepare(const Scene& scene, const Prepared& other) {
  core::BuildOptions options;
  options.other = other.get();
  return core::PreparedScene::build(scene, options);
}

// CPU time for rays that leave places above the field for anywhere on it, in packets.
double trace_seconds(const core::PreparedScene& scene, float size, Isa isa) {
  std::mt19937 random(5);
  const auto place = [&](float z) {
    const auto at = [&] { return std::uniform_real_distribution<float>(0, size)(random); };
    return Vec3f{at(), at(), z};
  };
  std::vector<core::CastRay> rays;
  for (int eye = 0; eye < 400; ++eye) {
    const Vec3f from = place(4), target = place(0);
    for (int i = 0; i < 64; ++i) {
      const Vec3f off{0.02f * static_cast<float>(i % 8), 0.02f * static_cast<float>(i / 8), 0};
      rays.push_back({from, target + off - from, 0, Bounds3f::kInf});
    }
  }
  std::vector<core::CastHit> hits(rays.size());
  const double start = process_cpu_seconds();
  core::cast_rays(scene, rays, {isa, 64, 1, false}, hits);
  return process_cpu_seconds() - start;
}

double median(std::vector<double> values) {
  std::sort(values.begin(), values.end());
  return values[values.size() / 2];
}

// Moves instances to places anywhere on the field, one a version.
class Mover {
 public:
  Mover(Scene& scene, SceneDecoder& decoder, Prepared newest, float size)
      : scene_(scene), decoder_(decoder), newest_(std::move(newest)), size_(size) {}

  Status move() {
    auto& m = scene_.instances[1 + random_() % (scene_.instances.size() - 1)].object_to_world.m;
    for (std::size_t axis = 0; axis < 2; ++axis)
      m[axis][3] = std::uniform_real_distribution<float>(0, size_)(random_);
    const EncodedScene encoded = encoder_.encode(scene_);
    const double begun = process_cpu_seconds();
    Result<Scene> decoded = decoder_.decode(encoded);
    if (!decoded.is_ok()) return decoded.status();
    const double start = process_cpu_seconds();
    Result<Prepared> next = prepare(*decoded, newest_);
    if (!next.is_ok()) return next.status();
    const double end = process_cpu_seconds();
    seconds_.push_back(end - start);
    with_decoding_.push_back(end - begun);
    newest_ = std::move(*next);
    return Status::ok();
  }
  const Prepared& newest() const { return newest_; }
  const std::vector<double>& seconds() const { return seconds_; }
  // As a slave does it that has the blocks.
  const std::vector<double>& with_decoding() const { return with_decoding_; }

 private:
  Scene& scene_;
  SceneDecoder& decoder_;  // of the scene's meshes
  Prepared newest_;
  const float size_;
  std::mt19937 random_{7};
  SceneEncoder encoder_;
  std::vector<double> seconds_, with_decoding_;  // of each version
};

// Rays in the hierarchy that was edited for each move to rays in one that is built for the places
// where all stand now.
Result<double> edited_to_built(const Scene& scene, const Prepared& edited, float size,
                               const CoreSuiteOptions& options) {
  // The other version has all meshes in other places, so that the hierarchy over them is built
  // anew.
  Scene other = scene;
  for (Instance& instance : other.instances) instance.object_to_world.m[2][3] += 1;
  other.instances.pop_back();
  Result<Prepared> before = prepare(other, edited);
  if (!before.is_ok()) return before.status();
  Result<Prepared> built = prepare(scene, *before);
  if (!built.is_ok()) return built.status();
  std::vector<double> ratios;
  for (int repeat = 0; repeat < options.repeats; ++repeat)
    ratios.push_back(trace_seconds(*edited, size, options.isa) /
                     trace_seconds(**built, size, options.isa));
  return median(ratios);
}

Result<std::string> run_crowd(const Crowd& crowd, const CoreSuiteOptions& options) {
  // The scene is one that was decoded, so that versions of it share its meshes.
  SceneDecoder decoder;
  Result<Scene> made = decoder.decode(SceneEncoder().encode(scene_of(crowd)));
  if (!made.is_ok()) return made.status();
  Scene& scene = *made;
  const float size = std::sqrt(static_cast<float>(crowd.instances));
  const double begun = process_cpu_seconds();
  Result<Prepared> first = prepare(scene, nullptr);
  if (!first.is_ok()) return first.status();
  const double whole = process_cpu_seconds() - begun;
  // The first move builds what then stays as it is, and counts apart.
  Mover mover(scene, decoder, std::move(*first), size);
  const int moves = options.is_quick ? 10 : std::min(crowd.instances / 4, 2500);
  for (int k = 0; k <= moves; ++k) TESSERA_RETURN_IF_ERROR(mover.move());
  const double first_move = mover.seconds().front();
  const double moved = median({mover.seconds().begin() + 1, mover.seconds().end()});
  const double decoded = median({mover.with_decoding().begin() + 1, mover.with_decoding().end()});
  const Result<double> ratio = edited_to_built(scene, mover.newest(), size, options);
  if (!ratio.is_ok()) return ratio.status();
  const auto of_mesh = [&](std::size_t m) {
    return static_cast<std::uint64_t>(scene.meshes[m]->triangles.size());
  };
  std::printf("  %10d %12llu %12llu %12.1f %12.2f %12.2f %12.2f %12.2f\n", crowd.instances,
              static_cast<unsigned long long>(of_mesh(1)),
              static_cast<unsigned long long>(of_mesh(0)), 1e3 * whole, 1e3 * first_move,
              1e3 * moved, 1e3 * decoded, *ratio);
  JsonObject json;
  json.add("instances", static_cast<std::uint64_t>(crowd.instances));
  json.add("triangles", of_mesh(1)).add("ground_triangles", of_mesh(0));
  json.add("first_cpu_seconds", whole).add("moved_cpu_seconds", moved);
  json.add("first_move_cpu_seconds", first_move);
  json.add("decoded_and_moved_cpu_seconds", decoded);
  return json.add("edited_to_built", *ratio).text();
}

}  // namespace

Status run_move_suite(const CoreSuiteOptions& options, std::vector<std::string>& json) {
  std::printf("\none instance moves, CPU-ms to prepare the scene\n");
  std::printf("  %10s %12s %12s %12s %12s %12s %12s %12s\n", "instances", "triangles", "ground",
              "first", "first move", "moved", "and decoded", "rays to new");
  for (const Crowd& crowd : kCrowds) {
    if (options.is_quick && crowd.instances * crowd.segments > 1'000'000) continue;
    Result<std::string> row = run_crowd(crowd, options);
    if (!row.is_ok()) return row.status();
    json.push_back(std::move(*row));
  }
  return Status::ok();
}

}  // namespace tessera::bench
