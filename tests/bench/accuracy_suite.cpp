// SPDX-License-Identifier: Apache-2.0
#include "tests/bench/accuracy_suite.h"

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "common/base/cpu_count.h"
#include "common/base/json.h"
#include "slave/core/scene/ray_caster.h"
#include "tests/bench/contender.h"
#include "tests/support/hard_cases.h"
#include "tests/support/test_meshes.h"

namespace tessera::bench {
namespace {

constexpr std::uint32_t kSeed = 2006;

struct Method {
  const char* name;
  core::Structure structure;
  int bundle;
};
constexpr Method kMethods[] = {{"bvh, packets", core::Structure::kBvh, 64},
                               {"bvh, single", core::Structure::kBvh, 1},
                               {"bvh-q, packets", core::Structure::kBvhQuality, 64},
                               {"kd, packets", core::Structure::kKd, 64},
                               {"kd, single", core::Structure::kKd, 1},
                               {"kd-q, packets", core::Structure::kKdQuality, 64}};

struct Spread {
  double median, most, max;  // most: 99.9 %
  bool is_empty;
};

// "-" where there is nothing to say: no judged ray of the class hits away from edges.
std::string text_of(const Spread& spread, const char* format) {
  if (spread.is_empty) return "-";
  char text[80];
  std::snprintf(text, sizeof(text), format, spread.median, spread.most, spread.max);
  return text;
}

Spread spread_of(std::vector<double> values) {
  if (values.empty()) return {0, 0, 0, true};
  std::sort(values.begin(), values.end());
  const std::size_t n = values.size();
  return {values[n / 2], values[std::min(n - 1, n * 999 / 1000)], values[n - 1], false};
}

std::vector<test::Answer> answers_of(const std::vector<core::CastHit>& hits) {
  std::vector<test::Answer> answers;
  for (const core::CastHit& hit : hits)
    answers.push_back({hit.is_hit, hit.primitive, hit.t, hit.u, hit.v});
  return answers;
}

std::string json_of(const Spread& spread) {
  JsonObject json;
  json.add("median", spread.median).add("p999", spread.most).add("max", spread.max);
  return json.text();
}

// Millions of rays per second, by wall clock.
double rate_of(const core::PreparedScene& scene, const std::vector<core::CastRay>& rays,
               const core::CastOptions& options, std::vector<core::CastHit>& hits) {
  const double start = wall_seconds();
  core::cast_rays(scene, rays, options, hits);
  return 1e-6 * static_cast<double>(rays.size()) / (wall_seconds() - start);
}

class Report {
 public:
  explicit Report(const CoreSuiteOptions& options) : options_(options) {}

  std::size_t bad() const { return bad_; }

  std::string run(const std::string& name) {
    const test::HardCase hard =
        test::make_hard_case(name, options_.is_quick ? 4'000 : 100'000, kSeed);
    std::vector<core::CastRay> rays;
    for (const test::Ray& ray : hard.rays)
      rays.push_back({ray.origin, ray.direction, ray.t_min, ray.t_max});
    std::printf("\n%s: %zu triangles, %zu rays, seed %u\n", name.c_str(),
                hard.mesh.triangles.size(), rays.size(), kSeed);
    std::printf("  %-14s %9s %9s %7s %7s %7s %7s %7s   %-26s %-26s %s\n", "", "Mray/s", "all thr.",
                "missed", "wrong", "false", "leak", "invalid", "t_rel median/99.9%/max", "t_norm",
                "u, v");
    std::string list;
    std::vector<core::CastHit> first;
    test::Verdicts verdicts;
    for (const Method& method : kMethods) {
      const auto scene =
          core::PreparedScene::build(test::make_scene(hard.mesh), {1, nullptr, method.structure});
      std::vector<core::CastHit> hits(rays.size());
      const double one = rate_of(**scene, rays, {options_.isa, method.bundle, 1, false}, hits);
      const double all =
          rate_of(**scene, rays, {options_.isa, method.bundle, available_cpu_count(), false}, hits);
      // Answers that are the same to the bit have the same errors. They are not judged again, since
      // looking at every triangle is slow.
      const bool is_same = std::equal(hits.begin(), hits.end(), first.begin(), first.end(),
                                      [](const core::CastHit& a, const core::CastHit& b) {
                                        return a.is_hit == b.is_hit && a.primitive == b.primitive &&
                                               a.t == b.t && a.u == b.u && a.v == b.v;
                                      });
      if (!is_same) verdicts = test::judge_all(hard, answers_of(hits));
      if (first.empty()) first = hits;
      list += (list.empty() ? "" : ",") + row(method, one, all, verdicts);
      bad_ += verdicts.bad();
    }
    if (!verdicts.worst_ray.empty())
      std::printf("  worst ray, t_norm %.2f: %s\n", verdicts.worst, verdicts.worst_ray.c_str());
    JsonObject json;
    json.add("class", name).add("rays", static_cast<std::uint64_t>(rays.size()));
    json.add("worst_ray", verdicts.worst_ray).add_raw("methods", "[" + list + "]");
    return json.text();
  }

 private:
  static std::string row(const Method& method, double one, double all, const test::Verdicts& v) {
    const Spread t = spread_of(v.t_relative), normed = spread_of(v.t_normed), uv = spread_of(v.uv);
    const char* const powers = "%.1e/%.1e/%.1e";
    std::printf("  %-14s %9.2f %9.2f %7zu %7zu %7zu %7zu %7zu   %-26s %-26s %s\n", method.name, one,
                all, v.missed, v.wrong, v.false_hits, v.leaks, v.invalid,
                text_of(t, powers).c_str(), text_of(normed, "%.3f/%.3f/%.3f").c_str(),
                text_of(uv, powers).c_str());
    JsonObject json;
    json.add("name", std::string(method.name)).add("mrays_one", one).add("mrays_all", all);
    const auto count = [](std::size_t n) { return static_cast<std::uint64_t>(n); };
    json.add("missed", count(v.missed)).add("wrong", count(v.wrong));
    json.add("false", count(v.false_hits)).add("leak", count(v.leaks));
    json.add("invalid", count(v.invalid)).add_raw("t_rel", json_of(t));
    json.add_raw("t_norm", json_of(normed)).add_raw("uv", json_of(uv));
    return json.text();
  }

  const CoreSuiteOptions& options_;
  std::size_t bad_ = 0;
};

}  // namespace

Status run_accuracy_suite(const CoreSuiteOptions& options, std::vector<std::string>& json) {
  Report report(options);
  std::printf(
      "\nEvery answer is judged in double against every triangle; t_norm is the error of t in "
      "u s / (|D| cos), u = 2^-24. %s.\n",
      isa_name(options.isa).data());
  for (const std::string& name : test::hard_case_names()) json.push_back(report.run(name));
  if (report.bad() == 0) return Status::ok();
  return Status::internal(std::to_string(report.bad()) + " answers are not right");
}

}  // namespace tessera::bench
