// SPDX-License-Identifier: Apache-2.0
#include "tests/bench/patch_suite.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <utility>

#include "common/base/json.h"
#include "slave/core/primitive/freeform/patch_point.h"
#include "slave/core/primitive/patch/patch_answer_abi.h"
#include "slave/core/primitive/patch/patch_horizon.h"
#include "slave/core/ray/packet_layout.h"
#include "tests/bench/contender.h"
#include "tests/bench/patch_scene.h"

namespace {

thread_local std::uint64_t answer_count = 0;

}  // namespace

// What the kernels ask out of line is counted on its way (CMakeLists.txt).
extern "C" {
void __real__ZN7tessera4core14solved_answersEPKNS0_13PatchQuestionEiPNS0_11PatchAnswerE(
    const tessera::core::PatchQuestion* questions, int count, tessera::core::PatchAnswer* answers);
void __wrap__ZN7tessera4core14solved_answersEPKNS0_13PatchQuestionEiPNS0_11PatchAnswerE(
    const tessera::core::PatchQuestion* questions, int count, tessera::core::PatchAnswer* answers) {
  answer_count += static_cast<std::uint64_t>(count);
  __real__ZN7tessera4core14solved_answersEPKNS0_13PatchQuestionEiPNS0_11PatchAnswerE(
      questions, count, answers);
}
std::uint64_t __real__ZN7tessera4core16filtered_answersEPKNS0_13PatchQuestionEiPNS0_11PatchAnswerE(
    const tessera::core::PatchQuestion* questions, int count, tessera::core::PatchAnswer* answers);
std::uint64_t __wrap__ZN7tessera4core16filtered_answersEPKNS0_13PatchQuestionEiPNS0_11PatchAnswerE(
    const tessera::core::PatchQuestion* questions, int count, tessera::core::PatchAnswer* answers) {
  answer_count += static_cast<std::uint64_t>(count);
  return __real__ZN7tessera4core16filtered_answersEPKNS0_13PatchQuestionEiPNS0_11PatchAnswerE(
      questions, count, answers);
}
}

namespace tessera::bench {
namespace {

struct Case {
  std::string name;
  int side;
  std::vector<int> cells;
  std::size_t judged;  // rays that are traced by brute force
};

// The surface as one entrant has it.
struct Row {
  std::string name;
  int cells = 0;  // 0: patches
  std::unique_ptr<Entrants> entrants{};
  double build_cpu_seconds = 0, megabytes = 0;
  SecondaryRays secondary{};
  double off = 0;  // 99.9th percentile of the hits' distance from the surface, of the diagonal
  std::uint64_t missed = 0, invented = 0, wrong = 0;  // of the judged camera rays
};

// One way of a row to trace rays of one kind.
struct Way {
  const Contender* contender;
  const Workload* work;
  double cpu_seconds = INFINITY;
  double asked = 0;  // of the filter and the complete solver, of a ray
};

Vec3f at(const float (&values)[3][kBlockRays], int i) {
  return {values[0][i], values[1][i], values[2][i]};
}

class Judge {
 public:
  Judge(const core::PatchStore& patches, const std::vector<Bounds3f>& boxes,
        const Workload& primary, std::size_t judged)
      : patches_(patches), truth_(patches, boxes), primary_(primary) {
    stride_ = std::max<std::size_t>(1, primary.ray_count / judged);
    for (std::size_t n = 0; n < primary.ray_count; n += stride_) {
      const RayBlock& rays = primary.blocks[n / kBlockRays];
      const int i = static_cast<int>(n % kBlockRays);
      wanted_.push_back(truth_.trace(at(rays.origin, i), at(rays.direction, i)));
    }
  }

  std::size_t judged() const { return wanted_.size(); }

  // Sets the errors of the row's camera rays.
  void judge(Row& row, const std::vector<BlockHits>& hits) const {
    for (std::size_t w = 0; w < wanted_.size(); ++w) {
      const BlockHits& block = hits[w * stride_ / kBlockRays];
      const std::size_t i = w * stride_ % kBlockRays;
      const PatchTruth::Hit& wanted = wanted_[w];
      const bool is_hit = block.primitive[i] != core::kNoPrimitive;
      row.missed += wanted.is_hit && !is_hit;
      row.invented += !wanted.is_hit && is_hit;
      if (!wanted.is_hit || !is_hit) continue;
      const bool is_apart =
          std::fabs(double{block.t[i]} - double{wanted.t}) > 1e-2 * truth_.diagonal();
      row.wrong += row.cells == 0 ? block.t[i] != wanted.t || block.primitive[i] != wanted.primitive
                                  : is_apart;
    }
    std::vector<double> off;
    for (std::size_t n = 0; n < primary_.ray_count; n += 7) {
      const BlockHits& block = hits[n / kBlockRays];
      const int i = static_cast<int>(n % kBlockRays);
      if (block.primitive[i] != core::kNoPrimitive) off.push_back(distance(row, block, n));
    }
    if (off.empty()) return;
    const auto rank = static_cast<std::ptrdiff_t>(0.999 * static_cast<double>(off.size() - 1));
    std::nth_element(off.begin(), off.begin() + rank, off.end());
    row.off = off[static_cast<std::size_t>(rank)] / truth_.diagonal();
  }

 private:
  double distance(const Row& row, const BlockHits& hits, std::size_t n) const {
    const RayBlock& rays = primary_.blocks[n / kBlockRays];
    const int i = static_cast<int>(n % kBlockRays);
    const Vec3f o = at(rays.origin, i), d = at(rays.direction, i);
    double point[3];
    for (int a = 0; a < 3; ++a) point[a] = double{o[a]} + double{hits.t[i]} * double{d[a]};
    if (row.cells == 0) {
      const core::SubPatch& part = patches_.parts[hits.primitive[i]];
      const auto met = patch_point(patches_.patches[part.patch], part, &o.x, &d.x, hits.t[i]);
      return truth_.distance(part.patch, double{met.u}, double{met.v}, point);
    }
    const auto cells = static_cast<std::uint32_t>(row.cells);
    const std::uint32_t square = hits.primitive[i] / 2;
    const std::uint32_t patch = square / (cells * cells), cell = square % (cells * cells);
    return truth_.distance(patch, (cell / cells + 0.5) / cells, (cell % cells + 0.5) / cells,
                           point);
  }

  const core::PatchStore& patches_;
  const PatchTruth truth_;
  const Workload& primary_;
  std::size_t stride_ = 1;
  std::vector<PatchTruth::Hit> wanted_;
};

// What the row's first way to trace camera rays hits.
std::vector<BlockHits> first_hits(const Row& row, const Workload& primary) {
  std::vector<BlockHits> hits(primary.blocks.size());
  for (const Contender& contender : row.entrants->contenders) {
    if (contender.kind != RayKind::kPrimary) continue;
    for (std::size_t b = 0; b < hits.size(); ++b) contender.trace(primary.blocks[b], hits[b]);
    break;
  }
  return hits;
}

std::vector<RayStart> starts_on_patches(const core::PatchStore& patches, const Workload& primary,
                                        const std::vector<BlockHits>& hits) {
  std::vector<RayStart> starts;
  for (std::size_t b = 0; b < hits.size(); ++b) {
    for (int i = 0; i < primary.blocks[b].count; ++i) {
      RayStart& start = starts.emplace_back();
      if (hits[b].primitive[i] == core::kNoPrimitive) continue;
      const Vec3f o = at(primary.blocks[b].origin, i), d = at(primary.blocks[b].direction, i);
      const core::SubPatch& part = patches.parts[hits[b].primitive[i]];
      const auto met = patch_point(patches.patches[part.patch], part, &o.x, &d.x, hits[b].t[i]);
      const Vec3f normal = dot(met.normal, d) > 0 ? -met.normal : met.normal;
      start = {true, met.point + normal * met.offset, normal, part.primitive,
               horizon_at(patches.patches[part.patch], part, met.u, met.v, met.point, normal)
                   .value_or(core::kNoHorizon)};
    }
  }
  return starts;
}

std::vector<FirstHit> listed(const Workload& primary, const std::vector<BlockHits>& hits) {
  std::vector<FirstHit> list;
  for (std::size_t b = 0; b < hits.size(); ++b)
    for (int i = 0; i < primary.blocks[b].count; ++i)
      list.push_back({hits[b].t[i], hits[b].primitive[i]});
  return list;
}

Row patches_row(const Scene& scene, Isa isa, std::shared_ptr<core::PatchStore>& store,
                std::vector<Bounds3f>& boxes) {
  const double start = process_cpu_seconds();
  store = std::make_shared<core::PatchStore>(core::make_patch_store(scene, boxes));
  const double seconds = process_cpu_seconds() - start;
  for (std::size_t p = 0; p < store->parts.size(); ++p)
    store->parts[p].primitive = static_cast<std::uint32_t>(p);
  Row row{"patches"};
  row.entrants = make_ours_patched(store, boxes, isa);
  row.build_cpu_seconds = seconds + row.entrants->builds[0].cpu_seconds;
  row.megabytes = row.entrants->builds[0].megabytes;
  return row;
}

// Traces rays of one kind in all ways of all rows, in turns.
std::vector<std::vector<Way>> measured(const std::vector<Row>& rows, RayKind kind,
                                       const Workload& primary, int repeats) {
  std::vector<std::vector<Way>> ways(rows.size());
  for (std::size_t r = 0; r < rows.size(); ++r) {
    const SecondaryRays& secondary = rows[r].secondary;
    const Workload* const work = kind == RayKind::kPrimary  ? &primary
                                 : kind == RayKind::kShadow ? &secondary.shadow
                                                            : &secondary.bounce;
    for (const Contender& contender : rows[r].entrants->contenders)
      if (contender.kind == kind) ways[r].push_back({&contender, work});
  }
  BlockHits hits;
  for (int repeat = -1; repeat < repeats; ++repeat) {
    for (auto& of_row : ways) {
      for (Way& way : of_row) {
        answer_count = 0;
        const double start = thread_cpu_seconds();
        for (const RayBlock& block : way.work->blocks) way.contender->trace(block, hits);
        const double seconds = thread_cpu_seconds() - start;
        if (repeat >= 0) way.cpu_seconds = std::min(way.cpu_seconds, seconds);
        way.asked = static_cast<double>(answer_count) / static_cast<double>(way.work->ray_count);
      }
    }
  }
  return ways;
}

std::string report(RayKind kind, const std::vector<Row>& rows,
                   const std::vector<std::vector<Way>>& ways) {
  std::string list;
  double ours = 0;
  for (std::size_t r = 0; r < rows.size(); ++r) {
    const auto rate = [](const Way& way) {
      return 1e-6 * static_cast<double>(way.work->ray_count) / way.cpu_seconds;
    };
    const auto best =
        std::max_element(ways[r].begin(), ways[r].end(),
                         [&](const Way& a, const Way& b) { return rate(a) < rate(b); });
    if (rows[r].cells == 0) ours = rate(*best);
    const double to_these = rows[r].cells == 0 ? std::nan("") : ours / rate(*best);
    std::printf("  %-8s %-22s %8.2f Mrays/CPU-s  patches to these %5.2f  asked %.4f  %s\n",
                ray_kind_name(kind), rows[r].name.c_str(), rate(*best), to_these, best->asked,
                best->contender->name.c_str());
    JsonObject json;
    json.add("name", rows[r].name).add("way", best->contender->name);
    json.add("mrays_per_cpu_second", rate(*best)).add("patches_to_these", to_these);
    if (rows[r].cells == 0) json.add("questions_per_ray", best->asked);
    std::string all;
    for (const Way& way : ways[r]) {
      JsonObject one;
      one.add("name", way.contender->name).add("mrays_per_cpu_second", rate(way));
      all += (all.empty() ? "" : ",") + one.text();
    }
    json.add_raw("ways", "[" + all + "]");
    list += (list.empty() ? "" : ",") + json.text();
  }
  JsonObject json;
  json.add("kind", std::string(ray_kind_name(kind))).add_raw("rows", "[" + list + "]");
  return json.text();
}

std::string report_surfaces(const std::vector<Row>& rows, std::size_t judged) {
  std::string list;
  std::printf("  %-22s %10s %9s %14s %8s %8s %8s, of %zu rays\n", "", "build s", "MB", "off, p99.9",
              "missed", "invented", "wrong", judged);
  for (const Row& row : rows) {
    std::printf(
        "  %-22s %10.3f %9.2f %14.3g %8llu %8llu %8llu\n", row.name.c_str(), row.build_cpu_seconds,
        row.megabytes, row.off, static_cast<unsigned long long>(row.missed),
        static_cast<unsigned long long>(row.invented), static_cast<unsigned long long>(row.wrong));
    JsonObject json;
    json.add("name", row.name).add("build_cpu_seconds", row.build_cpu_seconds);
    json.add("mb", row.megabytes).add("off_p999_of_diagonal", row.off);
    json.add("missed", row.missed).add("invented", row.invented).add("wrong", row.wrong);
    list += (list.empty() ? "" : ",") + json.text();
  }
  return "[" + list + "]";
}

std::string run_case(const Case& which, const CoreSuiteOptions& options) {
  std::fprintf(stderr, "making %s\n", which.name.c_str());
  const Workload primary = primary_rays(camera_of_field(which.side), options.size_px);
  const Vec3f light = light_of_field(which.side);
  std::shared_ptr<core::PatchStore> store;
  std::vector<Bounds3f> boxes;
  std::vector<Row> rows;
  rows.push_back(patches_row(teapot_field(which.side), options.isa, store, boxes));
  const Judge judge(*store, boxes, primary, which.judged);
  auto hits = first_hits(rows[0], primary);
  judge.judge(rows[0], hits);
  rows[0].secondary = secondary_rays(starts_on_patches(*store, primary, hits), light);
  SplinePatches splines;
  if (!which.cells.empty()) splines = splines_of(*store);
  for (const int cells : which.cells) {
    if (!has_embree()) break;
    std::vector<Bounds3f> triangle_boxes;
    const core::TriangleStore triangles = tessellated(*store, cells, triangle_boxes);
    for (const bool is_subdivided : {false, true}) {
      Row& row = rows.emplace_back();
      const std::string side = std::to_string(cells);
      row.name = side + " x " + side + (is_subdivided ? ", subdivision" : "");
      row.cells = cells;
      row.entrants = is_subdivided ? make_embree_subdivided(splines, cells, options.isa)
                                   : make_embree(triangles, options.isa, {});
      row.build_cpu_seconds = row.entrants->builds[0].cpu_seconds;
      row.megabytes = row.entrants->builds[0].megabytes;
      if (!is_subdivided) row.megabytes += mesh_megabytes(*store, cells);
      hits = first_hits(row, primary);
      judge.judge(row, hits);
      row.secondary = secondary_rays(primary, listed(primary, hits), triangles, light);
    }
  }
  std::printf("\n%s, %zu patches, %zu sub-patches\n", which.name.c_str(), store->patches.size(),
              store->parts.size());
  JsonObject json;
  json.add("scene", which.name).add("patches", std::uint64_t{store->patches.size()});
  json.add("sub_patches", std::uint64_t{store->parts.size()});
  json.add("judged", std::uint64_t{judge.judged()});
  std::string kinds;
  for (const RayKind kind : {RayKind::kPrimary, RayKind::kShadow, RayKind::kBounce}) {
    const auto& wanted = options.kinds;
    if (!wanted.empty() &&
        std::find(wanted.begin(), wanted.end(), ray_kind_name(kind)) == wanted.end())
      continue;
    const auto ways = measured(rows, kind, primary, options.repeats);
    kinds += (kinds.empty() ? "" : ",") + report(kind, rows, ways);
  }
  json.add_raw("rays", "[" + kinds + "]");
  json.add_raw("surfaces", report_surfaces(rows, judge.judged()));
  return json.text();
}

}  // namespace

Status run_patch_suite(const CoreSuiteOptions& options, std::vector<std::string>& json) {
  std::vector<Case> cases = {{"teapot", 1, {16, 64, 160}, 8192}, {"teapots", 64, {4, 8}, 1024}};
  if (options.is_quick) cases = {{"teapot", 1, {16, 64}, 1024}, {"teapots", 8, {4, 8}, 256}};
  // Triangles of as many patches would take gigabytes.
  cases.push_back({"million", 182, {}, 256});
  for (const Case& which : cases) {
    const auto& wanted = options.scenes;
    if (wanted.empty() || std::find(wanted.begin(), wanted.end(), which.name) != wanted.end())
      json.push_back(run_case(which, options));
  }
  return Status::ok();
}

}  // namespace tessera::bench
