// SPDX-License-Identifier: Apache-2.0
// What trims cost in frames: CPU time of a frame of the scene as it is, of the same without the
// widths of its segments, and of the same whole, without any loop, by one thread, in turns.
//
//   cad_trims [renderer NAME] [repeats N] FILE...   CAD files, under the studio's sky
//   cad_trims [renderer NAME] [repeats N]           one patch with 1 to 1,000 loops, beside each
//                                                   other or one in the other
//
// Prints the least of some frames each, and the ratio to the last of them.
#include <time.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <limits>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "common/frame/frame_settings.h"
#include "common/frame/tile_grid.h"
#include "common/viewpoint/scene_overview.h"
#include "master/import/cad/reader.h"
#include "master/look/studio_sky.h"
#include "slave/core/integrate/frame_light.h"
#include "slave/core/integrate/tile_renderer.h"
#include "slave/core/scene/prepared_scene.h"
#include "tests/support/trim_shapes.h"

namespace tessera::bench {
namespace {

constexpr int kSidePx = 512;

double thread_cpu_seconds() {
  timespec t{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
  return static_cast<double>(t.tv_sec) + 1e-9 * static_cast<double>(t.tv_nsec);
}

// A scene that is rendered with the others of its group.
struct Entry {
  std::string name;
  std::shared_ptr<const core::PreparedScene> scene;
  double seconds = std::numeric_limits<double>::infinity();
};

using Change = void (*)(PatchSurface&);

Scene changed(const Scene& scene, Change change) {
  Scene other = scene;
  for (auto& surface : other.surfaces) {
    PatchSurface copy = *surface;
    change(copy);
    surface = std::make_shared<const PatchSurface>(std::move(copy));
  }
  return other;
}

void drop_widths(PatchSurface& surface) { surface.trim_widths.clear(); }
void drop_trims(PatchSurface& surface) {
  surface.loop_counts.clear();
  surface.segment_counts.clear();
  surface.degrees.clear();
  surface.trim_points.clear();
  surface.trim_widths.clear();
  for (PatchForm& form : surface.patches) form.keeps_outside = 0;
}

Result<Entry> entry_of(const std::string& name, const Scene& scene) {
  auto built = core::PreparedScene::build(scene, core::BuildOptions{});
  if (!built.is_ok()) return built.status();
  Entry entry;
  entry.name = name;
  entry.scene = *built;
  return entry;
}

void render(Entry& entry, const FrameSettings& settings, Isa isa) {
  static core::TileRenderer renderer;
  const TileGrid grid(settings.width_px, settings.height_px, settings.tile_edge_px);
  core::FrameLight light;
  std::vector<float> tile;
  double seconds = 0;
  for (TileIndex i = 0; i < grid.tile_count(); ++i) {
    const TileRect rect = grid.rect(i);
    tile.assign(3 * static_cast<std::size_t>(rect.pixel_count()), 0);
    const double start = thread_cpu_seconds();
    renderer.render(*entry.scene, settings, isa, rect, tile, nullptr, &light);
    seconds += thread_cpu_seconds() - start;
  }
  entry.seconds = std::min(entry.seconds, seconds);
}

struct Options {
  std::vector<Renderer> renderers;
  int repeats = 7;
  std::vector<std::string> files;
};

void compare(std::vector<Entry>& entries, const Camera& camera, const Options& options,
             const std::string& name) {
  const Isa isa = widest_isa(core::supported_isas());
  for (const Renderer which : options.renderers) {
    FrameSettings settings;
    settings.width_px = settings.height_px = kSidePx;
    settings.camera = camera;
    settings.renderer = which;
    for (Entry& entry : entries) entry.seconds = std::numeric_limits<double>::infinity();
    for (int repeat = 0; repeat < options.repeats; ++repeat)
      for (Entry& entry : entries) render(entry, settings, isa);
    std::printf("%s, %s:", name.c_str(), std::string(renderer_name(which)).c_str());
    for (const Entry& entry : entries)
      std::printf("  %s %.2f ms, %.1f MB, %.2f", entry.name.c_str(), 1e3 * entry.seconds,
                  1e-6 * static_cast<double>(entry.scene->memory_bytes()),
                  entry.seconds / entries.back().seconds);
    std::printf("\n");
    std::fflush(stdout);
  }
}

Status compare_file(const std::string& path, const Options& options) {
  auto read = import::cad::read_cad(path);
  if (!read.is_ok()) return read.status();
  std::vector<Entry> entries;
  const Camera camera = SceneOverview(read->scene).default_camera(1.0);
  const Vec3f view = camera.eye - camera.target;
  read->scene.environment = {1, 1, 1};
  read->scene.environment_map = master::make_studio_sky(view * (1 / length(view)));
  const Scene scenes[] = {read->scene, changed(read->scene, drop_widths),
                          changed(read->scene, drop_trims)};
  const char* const names[] = {"trimmed", "no widths", "whole"};
  for (int i = 0; i < 3; ++i) {
    auto entry = entry_of(names[i], scenes[i]);
    if (!entry.is_ok()) return entry.status();
    entries.push_back(*entry);
  }
  compare(entries, camera, options, path.substr(path.find_last_of('/') + 1));
  return Status::ok();
}

Scene patch_with_loops(int loops, bool is_nested) {
  auto surface = std::make_shared<PatchSurface>(test::plain_patch(true));
  const int side = static_cast<int>(std::ceil(std::sqrt(loops)));
  for (int i = 0; i < loops; ++i) {
    const float cell = 1 / static_cast<float>(is_nested ? loops : side);
    const auto at = [&](int place) { return (static_cast<float>(place) + 0.5f) * cell; };
    if (is_nested) {
      test::add_circle(*surface, 0.5f, 0.5f, 0.5f * at(i));
    } else {
      test::add_circle(*surface, at(i % side), at(i / side), 0.3f * cell);
    }
  }
  Scene scene;
  scene.materials.resize(1);
  scene.surfaces = {surface};
  scene.instances = {{0, {}, ObjectKind::kPatchSurface}};
  return scene;
}

Status compare_loops(const Options& options) {
  for (const bool is_nested : {false, true}) {
    std::vector<Entry> entries;
    for (const int loops : {1000, 100, 10, 1}) {
      auto entry = entry_of(std::to_string(loops), patch_with_loops(loops, is_nested));
      if (!entry.is_ok()) return entry.status();
      entries.push_back(*entry);
    }
    const Camera camera = SceneOverview(patch_with_loops(1, false)).default_camera(1.0);
    compare(entries, camera, options, is_nested ? "nested" : "beside");
  }
  return Status::ok();
}

Result<Options> read_options(const std::vector<std::string>& words) {
  Options options;
  std::size_t i = 0;
  for (; i + 1 < words.size() && (words[i] == "renderer" || words[i] == "repeats"); i += 2) {
    if (words[i] == "repeats") {
      options.repeats = std::max(1, std::atoi(words[i + 1].c_str()));
      continue;
    }
    const auto renderer = parse_renderer(words[i + 1]);
    if (!renderer.is_ok()) return renderer.status();
    options.renderers.push_back(*renderer);
  }
  if (options.renderers.empty()) options.renderers = {Renderer::kPrimary, Renderer::kDirect};
  options.files.assign(words.begin() + static_cast<std::ptrdiff_t>(i), words.end());
  return options;
}

constexpr const char* kUsage =
    "usage: cad_trims [renderer primary|direct|path|igi] [repeats N] [FILE...]\n"
    "CPU time of frames of trimmed patches, over that of the same without loops. Without a FILE:\n"
    "one patch with 1 to 1,000 loops.\n";

Status run(const std::vector<std::string>& words) {
  if (!words.empty() && (words[0] == "--help" || words[0] == "-h")) {
    std::printf("%s", kUsage);
    return Status::ok();
  }
  const auto options = read_options(words);
  if (!options.is_ok()) return options.status();
  if (options->files.empty()) return compare_loops(*options);
  for (const std::string& file : options->files)
    TESSERA_RETURN_IF_ERROR(compare_file(file, *options));
  return Status::ok();
}

}  // namespace
}  // namespace tessera::bench

int main(int argc, char** argv) {
  const tessera::Status status = tessera::bench::run({argv + 1, argv + argc});
  if (status.is_ok()) return 0;
  std::fprintf(stderr, "cad_trims: %s\n", status.message().c_str());
  return 1;
}
