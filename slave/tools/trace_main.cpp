// SPDX-License-Identifier: Apache-2.0
// tessera-trace: what rays from a file hit in a scene from a file.
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <cstdio>
#include <vector>

#include "common/base/clean_text.h"
#include "common/base/cli_usage.h"
#include "common/base/cpu_count.h"
#include "common/base/limits.h"
#include "common/base/path_suffix.h"
#include "common/base/version.h"
#include "common/scene_io/scene_reader.h"
#include "slave/core/integrate/tile_renderer.h"
#include "slave/core/scene/ray_caster.h"
#include "slave/tools/hit_file.h"
#include "slave/tools/ray_file.h"

namespace tessera::tools {
namespace {

constexpr std::size_t kRaysAtOnce = std::size_t{1} << 18;

struct Words {
  std::string scene, rays, hits, isa = "auto", bundle = "auto", structure = "auto",
                                 patch_method = "auto";
  int threads = 0;
  bool is_any = false;
};

void say(const std::string& text) {
  std::fprintf(stderr, "tessera-trace: %s\n", clean_text(text).c_str());
}

int fail(int code, const std::string& text) {
  say(text);
  return code;
}

Result<ReadScene> read_scene(const std::string& path) {
  const std::string suffix = suffix_of(path);
  if (suffix == ".obj") {
    return read_obj(path, [](const std::string&) -> Result<std::shared_ptr<const Texture>> {
      return Status::invalid_argument("pictures are not needed for tracing");
    });
  }
  if (suffix == ".ply") return read_ply(path);
  if (suffix == ".bpt") return read_bpt(path);
  return Status::invalid_argument(path +
                                  ": is none of .obj, .ply, .bpt, which is what can be read");
}

// What the scene's file says of pictures and materials does not matter here.
void print_warnings(const ReadScene& scene) {
  for (const std::string& warning : scene.warnings) {
    if (warning.find("degenerate") != std::string::npos) say(warning);
  }
}

class Progress {
 public:
  void show(std::uint64_t rays) const {
    if (isatty(STDERR_FILENO) != 0)
      std::fprintf(stderr, "\r%llu rays", static_cast<unsigned long long>(rays));
  }
  void end(std::uint64_t rays, std::uint64_t hits) const {
    std::fprintf(stderr, "%s%llu rays, %llu hits\n", isatty(STDERR_FILENO) != 0 ? "\r" : "",
                 static_cast<unsigned long long>(rays), static_cast<unsigned long long>(hits));
  }
};

Status trace(const Words& words, const core::CastOptions& options) {
  auto scene = read_scene(words.scene);
  if (!scene.is_ok()) return scene.status();
  print_warnings(*scene);
  if (options.patch_method != PatchMethod::kAuto && scene->scene.surfaces.empty())
    say(no_patches_line(options.patch_method));
  auto rays = RayFile::open(words.rays);
  if (!rays.is_ok()) return rays.status();
  auto prepared = core::PreparedScene::build(
      scene->scene, {options.threads, nullptr, *core::parse_structure(words.structure)});
  if (!prepared.is_ok()) return prepared.status();
  auto file = HitFile::create(words.hits);
  if (!file.is_ok()) return file.status();
  const Progress progress;
  std::uint64_t ray_count = 0, hit_count = 0;
  std::vector<core::CastHit> hits;
  for (;;) {
    auto some = rays->read(kRaysAtOnce);
    if (!some.is_ok()) return some.status();
    if (some->empty()) break;
    hits.resize(some->size());
    core::cast_rays(**prepared, *some, options, hits);
    file->write(hits);
    ray_count += hits.size();
    for (const core::CastHit& hit : hits) hit_count += hit.is_hit ? 1u : 0u;
    progress.show(ray_count);
  }
  TESSERA_RETURN_IF_ERROR(file->finish());
  progress.end(ray_count, hit_count);
  return Status::ok();
}

void describe(CLI::App& app, Words& words) {
  app.set_version_flag("--version", std::string("tessera-trace ") + kBuildId);
  app.add_option("SCENE", words.scene, "triangles: .obj or .ply; patches: .bpt")->required();
  app.add_option("RAYS", words.rays,
                 ".csv: lines ox,oy,oz,dx,dy,dz,tmin,tmax; any other name: 8 float32 a ray")
      ->required();
  app.add_option("HITS", words.hits,
                 ".csv: lines ray,hit,t,prim,u,v,ngx,ngy,ngz; any other name: records of 32 bytes: "
                 "uint32 hit, float t, uint32 prim, float u, v, ngx, ngy, ngz")
      ->required();
  app.add_flag("--any", words.is_any, "only whether something is hit; t and the rest are 0");
  app.add_option("--structure", words.structure,
                 "what rays go through; answers do not depend on it")
      ->check(CLI::IsMember(core::structure_names()))
      ->capture_default_str();
  app.add_option("--patch-method", words.patch_method, patch_method_help())->capture_default_str();
  app.add_option("--bundle", words.bundle, "rays traced together; answers do not depend on it")
      ->check(CLI::IsMember({"1", "4", "16", "64", "auto"}))
      ->capture_default_str();
  app.add_option("--threads", words.threads, "0: as many as there are cores")
      ->check(CLI::Range(0, kWorkersMax))
      ->capture_default_str();
  app.add_option("--isa", words.isa, "auto, scalar, sse4, avx2, avx512")->capture_default_str();
  app.footer(
      "Numbers of triangles and patches count from 0 in the order of the file, polygons as fans. A "
      "ray that is not finite, or has no direction, is a miss.\n"
      "Exit code: 0 done, 1 failed, 2 wrong usage.");
}

int run(int argc, char** argv) {
  CLI::App app("Says what rays hit in a scene.", "tessera-trace");
  Words words;
  describe(app, words);
  try {
    app.parse(argc, argv);
  } catch (const CLI::Success& success) {
    return app.exit(success);
  } catch (const CLI::ParseError& error) {
    return fail(2, usage_text(app, error) + " (see 'tessera-trace --help')");
  }
  core::CastOptions options;
  const IsaMask supported = core::supported_isas();
  options.isa = widest_isa(supported);
  if (words.isa != "auto") {
    const auto named = parse_isa(words.isa);
    if (!named.is_ok()) return fail(2, named.status().message());
    if ((supported & isa_bit(*named)) == 0)
      return fail(1, "--isa " + words.isa + ": this CPU does not have it; use --isa auto");
    options.isa = *named;
  }
  const auto method = parse_patch_method(words.patch_method);
  if (!method.is_ok()) return fail(2, method.status().message());
  options.patch_method = *method;
  options.bundle = words.bundle == "auto" ? 64 : std::stoi(words.bundle);
  options.threads = words.threads == 0 ? available_cpu_count() : words.threads;
  options.is_any = words.is_any;
  const Status status = trace(words, options);
  return status.is_ok() ? 0 : fail(1, status.message());
}

}  // namespace
}  // namespace tessera::tools

int main(int argc, char** argv) { return tessera::tools::run(argc, argv); }
