// SPDX-License-Identifier: Apache-2.0
#include "tests/bench/method_suite.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <random>

#include "common/base/json.h"
#include "common/math/vec3d.h"
#include "slave/core/primitive/freeform/patch_point.h"
#include "slave/core/primitive/patch/patch_evaluation.h"
#include "slave/core/trace/scene_tracer.h"
#include "tests/bench/contender.h"
#include "tests/bench/method_rows.h"
#include "tests/bench/patch_scene.h"

namespace tessera::bench {
namespace {

constexpr float kMiss = std::numeric_limits<float>::infinity();

// What a ray meets, by the usual way.
struct Met {
  float t = kMiss;
  std::uint32_t patch = 0;
  float u = 0, v = 0;
};

// Of camera rays, and of rays that graze the surface.
struct Losses {
  double off = 0;
  std::uint64_t missed = 0, wrong = 0, invented = 0;
  std::uint64_t all() const { return missed + wrong + invented; }
};
struct Result {
  double cpu_seconds = INFINITY;
  Losses camera, grazing;
  std::uint64_t work = 0;
};

Vec3f at(const float (&values)[3][kBlockRays], int i) {
  return {values[0][i], values[1][i], values[2][i]};
}

// All rays are judged.
class MethodJudge {
 public:
  MethodJudge(const MethodScene& scene, Isa isa, const Workload& work)
      : truth_(scene.store(), scene.boxes()), work_(work) {
    const core::SceneTracer tracer(scene.index(), core::kernels_for(isa));
    for (const RayBlock& rays : work.blocks) {
      for (int i = 0; i < rays.count; ++i) {
        const Vec3f o = at(rays.origin, i), d = at(rays.direction, i);
        const core::SingleHit hit =
            tracer.closest(core::SingleRay{{o.x, o.y, o.z}, {d.x, d.y, d.z}, 0, kMiss});
        Met& met = wanted_.emplace_back();
        if (hit.primitive == core::kNoPrimitive) continue;
        const core::SubPatch& part = scene.store().parts[hit.primitive];
        const auto point = patch_point(scene.store().patches[part.patch], part, &o.x, &d.x, hit.t);
        met = {hit.t, part.patch, point.u, point.v};
      }
    }
  }

  // Shape: t [ray_count].
  void judge(const std::vector<float>& t, Losses& to) const {
    std::vector<double> off;
    for (std::size_t n = 0; n < wanted_.size(); ++n) {
      const Met& met = wanted_[n];
      const bool is_met = met.t < kMiss, is_hit = t[n] < kMiss;
      to.missed += is_met && !is_hit;
      to.invented += !is_met && is_hit;
      if (!is_met || !is_hit) continue;
      const RayBlock& rays = work_.blocks[n / kBlockRays];
      const int i = static_cast<int>(n % kBlockRays);
      const Vec3f o = at(rays.origin, i), d = at(rays.direction, i);
      const double apart = std::fabs(double{t[n]} - double{met.t}) * double{length(d)};
      if (apart > 1e-2 * truth_.diagonal()) {
        ++to.wrong;
        continue;
      }
      double point[3];
      for (int a = 0; a < 3; ++a) point[a] = double{o[a]} + double{t[n]} * double{d[a]};
      off.push_back(truth_.distance(met.patch, double{met.u}, double{met.v}, point));
    }
    if (off.empty()) return;
    const auto rank = static_cast<std::ptrdiff_t>(0.999 * static_cast<double>(off.size() - 1));
    std::nth_element(off.begin(), off.begin() + rank, off.end());
    to.off = off[static_cast<std::size_t>(rank)] / truth_.diagonal();
  }

 private:
  const PatchTruth truth_;
  const Workload& work_;
  std::vector<Met> wanted_;
};

// Traces all rays in all rows, in turns; the least time counts.
std::vector<Result> measured(const std::vector<const MethodRow*>& rows, const Workload& work,
                             const MethodJudge& judge, int repeats) {
  std::vector<Result> results(rows.size());
  std::vector<float> t(work.blocks.size() * kBlockRays);
  for (int repeat = 0; repeat < repeats; ++repeat) {
    for (std::size_t r = 0; r < rows.size(); ++r) {
      rows[r]->begin();
      const double start = thread_cpu_seconds();
      for (std::size_t b = 0; b < work.blocks.size(); ++b)
        rows[r]->trace(work.blocks[b], t.data() + b * kBlockRays);
      results[r].cpu_seconds = std::min(results[r].cpu_seconds, thread_cpu_seconds() - start);
      if (repeat != 0) continue;
      if (rows[r]->how) results[r].work = rows[r]->how->work;
      judge.judge(t, results[r].camera);
    }
  }
  return results;
}

// Rays at slopes of 10^-7 to 1 to the surface, from half a size to one and a half away.
Workload grazing_rays(const core::PatchStore& patches, double size, std::size_t blocks) {
  std::mt19937 random(11);
  const auto share = [&] { return std::uniform_real_distribution<double>()(random); };
  Workload work;
  work.blocks.resize(blocks);
  work.ray_count = blocks * kBlockRays;
  for (RayBlock& rays : work.blocks) {
    rays.count = kBlockRays;
    for (int i = 0; i < kBlockRays; ++i) {
      const core::Patch& patch = patches.patches[random() % patches.patches.size()];
      const core::PatchJet jet = core::evaluate(patch, share(), share());
      const Vec3d p{jet.point[0], jet.point[1], jet.point[2]};
      const Vec3d du = normalize(Vec3d{jet.du[0], jet.du[1], jet.du[2]});
      const Vec3d dv = normalize(Vec3d{jet.dv[0], jet.dv[1], jet.dv[2]});
      const double angle = 6.283185307179586 * share(), slope = std::pow(10.0, -7 * share());
      const Vec3d along = normalize(std::cos(angle) * du + std::sin(angle) * dv);
      const Vec3d d = along + (share() < 0.5 ? slope : -slope) * normalize(cross(du, dv));
      const Vec3f origin = rounded(p - ((0.5 + share()) * size) * d);
      for (int a = 0; a < 3; ++a) {
        rays.origin[a][i] = origin[a];
        rays.direction[a][i] = static_cast<float>(p[a] - double{origin[a]});
      }
      rays.t_max[i] = kMiss;
    }
  }
  return work;
}

double judge_size(const MethodScene& scene) {
  return PatchTruth(scene.store(), scene.boxes()).diagonal();
}

// Counts what rows lose of them; rows that take rays of one eye alone stay out.
void graze(const std::vector<const MethodRow*>& rows, const MethodScene& scene, Isa isa,
           std::size_t blocks, std::vector<Result>& results) {
  const Workload work = grazing_rays(scene.store(), judge_size(scene), blocks);
  const MethodJudge judge(scene, isa, work);
  std::vector<float> t(blocks * kBlockRays);
  for (std::size_t r = 0; r < rows.size(); ++r) {
    if (rows[r]->takes_one_eye) continue;
    for (std::size_t b = 0; b < blocks; ++b)
      rows[r]->trace(work.blocks[b], t.data() + b * kBlockRays);
    judge.judge(t, results[r].grazing);
  }
}

double share_of(std::uint64_t part, std::uint64_t all) {
  return static_cast<double>(part) / static_cast<double>(all);
}

std::string report(const MethodRow& row, const Result& result, std::uint64_t ray_count) {
  const double rate = 1e-6 * static_cast<double>(ray_count) / result.cpu_seconds;
  const double work = share_of(result.work, ray_count);
  const Losses& camera = result.camera;
  const std::string grazing = row.takes_one_eye ? "" : std::to_string(result.grazing.all());
  std::printf("  %-24s %-36s %6zu %8.2f %9.2g %7llu %7llu %7llu %8s %7.2f\n", row.group.c_str(),
              row.name.c_str(), row.parts, rate, camera.off,
              static_cast<unsigned long long>(camera.missed),
              static_cast<unsigned long long>(camera.wrong),
              static_cast<unsigned long long>(camera.invented), grazing.c_str(), work);
  JsonObject json;
  json.add("group", row.group).add("name", row.name).add("parts", std::uint64_t{row.parts});
  json.add("mrays_per_cpu_second", rate).add("off_p999_of_diagonal", camera.off);
  json.add("missed", camera.missed).add("wrong", camera.wrong).add("false", camera.invented);
  if (!row.takes_one_eye) json.add("lost_of_grazing", result.grazing.all());
  if (row.how) json.add("work_per_ray", work);
  return json.text();
}

}  // namespace

Status run_method_suite(const CoreSuiteOptions& options, std::vector<std::string>& json) {
  const int size_px = options.is_quick ? 256 : options.size_px / 2;
  const int repeats = options.is_quick ? 1 : std::min(options.repeats, 5);
  const Workload work = primary_rays(camera_of_field(1), size_px);
  const MethodRows all(options.isa);
  const MethodJudge judge(all.product(), options.isa, work);
  std::vector<const MethodRow*> rows;
  for (const MethodRow& row : all.rows()) {
    if (rows.empty() || options.only.empty() ||
        (row.group + " " + row.name).find(options.only) != std::string::npos)
      rows.push_back(&row);
  }
  std::vector<Result> results = measured(rows, work, judge, repeats);
  const std::size_t grazing_blocks = options.is_quick ? 2 : 16;
  graze(rows, all.product(), options.isa, grazing_blocks, results);
  std::printf(
      "\nmethods for patches: teapot, %llu camera rays; lost of %zu that graze; boxes or steps a "
      "ray\n",
      static_cast<unsigned long long>(work.ray_count), grazing_blocks * kBlockRays);
  std::printf("  %-24s %-36s %6s %8s %9s %7s %7s %7s %8s %7s\n", "", "", "parts", "Mrays/s",
              "off p99.9", "missed", "wrong", "false", "grazing", "work");
  std::string list;
  for (std::size_t r = 0; r < rows.size(); ++r)
    list += (r == 0 ? "" : ",") + report(*rows[r], results[r], work.ray_count);
  JsonObject object;
  object.add("scene", std::string("teapot")).add("rays", work.ray_count);
  object.add("grazing_rays", std::uint64_t{grazing_blocks * kBlockRays});
  object.add_raw("rows", "[" + list + "]");
  json.push_back(object.text());
  return Status::ok();
}

}  // namespace tessera::bench
