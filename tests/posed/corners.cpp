// SPDX-License-Identifier: Apache-2.0
// Prints where the corners of a file's triangles are at given times, in world space, as slaves
// evaluate them, and how far that is from another evaluator in double.
//
//   posed_corners FILE SECONDS...      posed_corners FILE keys
//
// With times: a line "reference WORST SIZE", then for each time a line "at SECONDS" and a line for
// each corner. With "keys": the times of the first clip's keys, one a line, below a line that says
// whether a channel turns something.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "common/scene/animation.h"
#include "common/scene/pose.h"
#include "master/loader/load_scene.h"
#include "tests/support/motion_reference.h"

namespace tessera {
namespace {

using Place = std::array<double, 3>;

Place placed(const Transform& t, Vec3f p) {
  Place at{};
  for (std::size_t i = 0; i < 3; ++i) {
    const auto m = [&](std::size_t j) { return static_cast<double>(t.m[i][j]); };
    at[i] = m(0) * static_cast<double>(p.x) + m(1) * static_cast<double>(p.y) +
            m(2) * static_cast<double>(p.z) + m(3);
  }
  return at;
}

double distance(const Place& a, const Place& b) {
  return std::hypot(a[0] - b[0], a[1] - b[1], a[2] - b[2]);
}

std::vector<Place> corners_of(const Scene& scene) {
  std::vector<Place> corners;
  for (const Instance& instance : scene.instances) {
    if (instance.kind != ObjectKind::kMesh) continue;
    const Mesh& mesh = *scene.meshes[instance.mesh];
    for (const auto& triangle : mesh.triangles) {
      for (const std::uint32_t vertex : triangle)
        corners.push_back(placed(instance.object_to_world, mesh.positions[vertex]));
    }
  }
  return corners;
}

// How far vertices of deformed meshes and the origins of moved instances are from where the other
// evaluator has them, at most.
double off_reference(const Scene& scene, const Scene& posed, double seconds) {
  const SceneAnimation& a = *scene.animation;
  double worst = 0;
  for (std::size_t i = 0; i < a.meshes.size(); ++i) {
    const std::vector<Place> there = test::reference_vertices(scene, i, seconds);
    const std::vector<Vec3f>& here = posed.meshes[a.meshes[i].mesh]->positions;
    for (std::size_t v = 0; v < here.size(); ++v)
      worst = std::max(worst, distance(placed({}, here[v]), there[v]));
  }
  // A place without an inverse leaves its instance out, and the numbers of the others change.
  if (posed.instances.size() != scene.instances.size()) return worst;
  for (const MovedInstance& moved : a.instances) {
    const test::Matrix4 node = test::reference_place(a, moved.node, seconds);
    const Place in_node = placed(moved.in_node, {});
    Place there{};
    for (std::size_t i = 0; i < 3; ++i) {
      there[i] = node[i][3];
      for (std::size_t j = 0; j < 3; ++j) there[i] += node[i][j] * in_node[j];
    }
    const Transform& here = posed.instances[moved.instance].object_to_world;
    worst = std::max(worst, distance(placed(here, {}), there));
  }
  return worst;
}

void print_keys(const SceneAnimation& animation) {
  std::set<float> times;
  bool is_turning = false;
  const std::size_t count = animation.clips.empty() ? 0 : animation.clips[0].channel_count;
  for (std::size_t i = 0; i < count; ++i) {
    const MotionChannel& channel = animation.channels[i];
    is_turning |= channel.path == MotionPath::kRotation;
    const auto first = animation.key_seconds.begin() + channel.first_key;
    times.insert(first, first + channel.key_count);
  }
  std::printf("turns %d\n", is_turning ? 1 : 0);
  for (const float time : times) std::printf("%.9g\n", static_cast<double>(time));
}

int fail(const std::string& text) {
  std::fprintf(stderr, "posed_corners: %s\n", text.c_str());
  return 1;
}

int run(int count, char** words) {
  if (count < 3) return fail("give a file, and times in seconds or 'keys'");
  Result<master::LoadedScene> loaded =
      master::load_scene(words[1], [](const std::string&, double) { return true; });
  if (!loaded.is_ok()) return fail(loaded.status().message());
  const Scene& scene = loaded->scene;
  if (!scene.animation) return fail("nothing moves in this file");
  if (std::string_view(words[2]) == "keys") {
    print_keys(*scene.animation);
    return 0;
  }
  ScenePoser poser;
  double worst = 0, size = 0;
  std::string text;
  for (int i = 2; i < count; ++i) {
    const double seconds = std::strtod(words[i], nullptr);
    Result<Scene> posed = poser.at(scene, seconds);
    if (!posed.is_ok()) return fail(posed.status().message());
    worst = std::max(worst, off_reference(scene, *posed, seconds));
    Place low{}, high{};
    char line[96];
    std::snprintf(line, sizeof line, "at %.17g\n", seconds);
    text += line;
    const std::vector<Place> corners = corners_of(*posed);
    for (std::size_t c = 0; c < corners.size(); ++c) {
      const Place& p = corners[c];
      for (std::size_t a = 0; a < 3; ++a) {
        low[a] = c == 0 ? p[a] : std::min(low[a], p[a]);
        high[a] = c == 0 ? p[a] : std::max(high[a], p[a]);
      }
      std::snprintf(line, sizeof line, "%.9g %.9g %.9g\n", p[0], p[1], p[2]);
      text += line;
    }
    size = std::max(size, distance(low, high));
  }
  std::printf("reference %.9g %.9g\n%s", worst, size, text.c_str());
  return 0;
}

}  // namespace
}  // namespace tessera

int main(int argc, char** argv) { return tessera::run(argc, argv); }
