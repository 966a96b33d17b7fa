// SPDX-License-Identifier: Apache-2.0
// How far what camera rays meet in a field of CAD files lies from its surface:
//
//   cad_error PLAN WIDTH HEIGHT "ex,ey,ez tx,ty,tz ux,uy,uz DEGREES"
//
// A plan as field.h has it, and a camera as `render --camera` has it; one ray through the middle of
// each pixel. The surface is the patch that was met, found in extended precision by tests/support
// from the hit's u and v on. Prints JSON; distances are over the scene's diagonal. Hits beside
// widened borders are up to their width away from a surface, and are among them.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <numbers>
#include <string>
#include <vector>

#include "common/base/json.h"
#include "common/math/bounds3.h"
#include "common/math/vec3d.h"
#include "slave/core/integrate/tile_renderer.h"
#include "slave/core/scene/prepared_scene.h"
#include "slave/core/scene/prepared_scene_impl.h"
#include "slave/core/scene/ray_caster.h"
#include "tests/bench/cad_field/field.h"
#include "tests/support/patch_reference.h"

namespace tessera::bench {
namespace {

struct View {
  int width = 0, height = 0;
  Vec3d eye, target, up;
  double degrees = 0;
};

Result<View> read_view(char** words) {
  View view;
  view.width = std::atoi(words[0]);
  view.height = std::atoi(words[1]);
  const int read = std::sscanf(words[2], "%lf,%lf,%lf %lf,%lf,%lf %lf,%lf,%lf %lf", &view.eye.x,
                               &view.eye.y, &view.eye.z, &view.target.x, &view.target.y,
                               &view.target.z, &view.up.x, &view.up.y, &view.up.z, &view.degrees);
  if (read != 10 || view.width < 1 || view.height < 1)
    return Status::invalid_argument("no camera: " + std::string(words[2]));
  return view;
}

std::vector<core::CastRay> rays_of(const View& view) {
  const auto unit = [](Vec3d a) { return (1 / length(a)) * a; };
  const Vec3d ahead = unit(view.target - view.eye), right = unit(cross(ahead, view.up));
  const Vec3d above = cross(right, ahead);
  const double step = 2 * std::tan(view.degrees * std::numbers::pi / 360) / view.height;
  std::vector<core::CastRay> rays;
  for (int y = 0; y < view.height; ++y)
    for (int x = 0; x < view.width; ++x) {
      const double to_right = (x + 0.5 - 0.5 * view.width) * step;
      const double to_above = (0.5 * view.height - y - 0.5) * step;
      const Vec3d direction = unit(ahead + to_right * right + to_above * above);
      rays.push_back({rounded(view.eye), rounded(direction), 0, Bounds3f::kInf});
    }
  return rays;
}

// From a place to a patch, by steps to the nearest point of its tangent planes.
double distance_to(const core::Patch& patch, const long double (&place)[3], double u, double v) {
  constexpr int kSteps = 8;
  long double at[2] = {u, v}, best = HUGE_VALL;
  for (int step = 0; step < kSteps; ++step) {
    const test::LongJet jet = test::long_jet(patch, at[0], at[1]);
    long double square = 0, uu = 0, uv = 0, vv = 0, ru = 0, rv = 0;
    for (int a = 0; a < 3; ++a) {
      const long double off = place[a] - jet.point[a];
      square += off * off;
      uu += jet.du[a] * jet.du[a];
      uv += jet.du[a] * jet.dv[a];
      vv += jet.dv[a] * jet.dv[a];
      ru += off * jet.du[a];
      rv += off * jet.dv[a];
    }
    best = std::min(best, std::sqrt(square));
    const long double determinant = uu * vv - uv * uv;
    if (!(determinant > 0)) break;
    at[0] = std::clamp(at[0] + (vv * ru - uv * rv) / determinant, 0.0L, 1.0L);
    at[1] = std::clamp(at[1] + (uu * rv - uv * ru) / determinant, 0.0L, 1.0L);
  }
  return static_cast<double>(best);
}

Status run(const std::string& path, const View& view) {
  const auto plan = read_plan(path);
  if (!plan.is_ok()) return plan.status();
  const auto field = make_field(*plan);
  if (!field.is_ok()) return field.status();
  core::BuildOptions build;
  build.threads = 2;
  const auto built = core::PreparedScene::build(*field, build);
  if (!built.is_ok()) return built.status();
  const core::PatchStore& store = *(*built)->impl().patches;
  Bounds3f box;
  for (const core::Patch& patch : store.patches) {
    const int count = (patch.degree_u + 1) * (patch.degree_v + 1);
    for (int k = 0; patch.numbers != nullptr && k < count; ++k) {
      const float* p = patch.numbers + k * (patch.is_rational ? 4 : 3);
      box.grow(Vec3f{p[0], p[1], p[2]});
    }
  }
  const double diagonal{length(box.upper - box.lower)};

  const std::vector<core::CastRay> rays = rays_of(view);
  std::vector<core::CastHit> hits(rays.size());
  core::CastOptions options;
  options.isa = widest_isa(core::supported_isas());
  cast_rays(**built, rays, options, hits);
  std::vector<double> errors;
  for (std::size_t i = 0; i < rays.size(); ++i) {
    if (!hits[i].is_hit) continue;
    long double place[3];
    for (int a = 0; a < 3; ++a)
      place[a] = rays[i].origin[a] + static_cast<long double>(hits[i].t) *
                                         static_cast<long double>(rays[i].direction[a]);
    errors.push_back(
        distance_to(store.patches[hits[i].primitive], place, double{hits[i].u}, double{hits[i].v}) /
        diagonal);
  }
  if (errors.empty()) return Status::invalid_argument(path + ": no ray meets anything");
  std::sort(errors.begin(), errors.end());
  const std::size_t last = errors.size() - 1;
  JsonObject json;
  json.add("rays", rays.size()).add("hits", errors.size()).add("diagonal", diagonal);
  json.add("error_p50", errors[last / 2]).add("error_p999", errors[last - last / 1000]);
  json.add("error_worst", errors[last]);
  std::printf("%s\n", json.text().c_str());
  return Status::ok();
}

}  // namespace
}  // namespace tessera::bench

int main(int argc, char** argv) {
  if (argc != 5) {
    std::fprintf(stderr, "usage: cad_error PLAN WIDTH HEIGHT CAMERA\n");
    return 2;
  }
  const auto view = tessera::bench::read_view(argv + 2);
  const tessera::Status status = view.is_ok() ? tessera::bench::run(argv[1], *view) : view.status();
  if (status.is_ok()) return 0;
  std::fprintf(stderr, "cad_error: %s\n", status.message().c_str());
  return 1;
}
