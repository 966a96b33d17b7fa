// SPDX-License-Identifier: Apache-2.0
// Sub-patches in a kd-tree beside the hierarchy over them: rates of rays by one thread, CPU time to
// build, memory, and camera rays whose answers differ.
//
//   kd_patches [SIDE [SIZE [REPEATS]]]    a field of SIDE x SIDE teapots, SIZE x SIZE pixels
//
// Prints a line of JSON for each structure. kd: the fast build; kd-quality: boxes are cut at the
// faces of voxels; both for some costs of a sub-patch's test, a step down being 1.
#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <numeric>

#include "slave/core/accel/kd_builder.h"
#include "slave/core/integrate/tile_renderer.h"
#include "slave/core/primitive/freeform/patch_point.h"
#include "slave/core/primitive/freeform/patched_index.h"
#include "slave/core/primitive/mixed_writer.h"
#include "slave/core/simd/isa_support.h"
#include "tests/bench/kd_patches/kd_patch_view.h"
#include "tests/bench/patch_scene.h"
#include "tests/bench/structure_ways.h"

namespace tessera::bench {
namespace {

class BoxClipper final : public core::PrimitiveClipper {
 public:
  explicit BoxClipper(const std::vector<Bounds3f>& boxes) : boxes_(boxes) {}
  Bounds3f clip(std::uint32_t primitive, const Bounds3f& voxel) const override {
    const Bounds3f& box = boxes_[primitive];
    return {max(box.lower, voxel.lower), min(box.upper, voxel.upper)};
  }

 private:
  const std::vector<Bounds3f>& boxes_;
};

struct Subject {
  std::string name;
  std::vector<Contender> contenders{};
  std::shared_ptr<void> structure{};
  double build_cpu_seconds = 0, megabytes = 0;
};

class Comparison {
 public:
  Comparison(int side, int size_px, Isa isa)
      : table_(core::kernels_for(isa)),
        light_(light_of_field(side)),
        primary_(primary_rays(camera_of_field(side), size_px)) {
    auto store = core::make_patch_store(teapot_field(side), boxes_);
    for (std::size_t p = 0; p < store.parts.size(); ++p)
      store.parts[p].primitive = static_cast<std::uint32_t>(p);
    patches_ = std::make_shared<const core::PatchStore>(std::move(store));
  }

  template <int W>
  void build_all() {
    add("bvh", [&] { return *core::index_patches<W>({{}, {}, {}, boxes_}, patches_, {}); });
    const BoxClipper clipper(boxes_);
    for (const float cost : {0.002f, 0.006f, 0.1f}) {
      for (const bool is_quality : {false, true}) {
        core::KdBuildConfig config = is_quality ? core::quality_build(clipper) : KdConfig{};
        config.cost_intersect = cost;
        add((is_quality ? "kd-quality, " : "kd, ") + std::to_string(cost).substr(0, 5),
            [&] { return kd<W>(config); });
      }
    }
  }

  void run(int repeats) {
    const auto answers = answers_of(subjects_[0]);
    find_secondary(answers);
    for (const Subject& subject : subjects_) {
      std::uint64_t differ = 0;
      const auto others = answers_of(subject);
      for (std::size_t b = 0; b < answers.size(); ++b)
        for (int i = 0; i < primary_.blocks[b].count; ++i)
          differ +=
              answers[b].primitive[i] != others[b].primitive[i] ||
              (answers[b].primitive[i] != core::kNoPrimitive && answers[b].t[i] != others[b].t[i]);
      std::printf(
          "{\"structure\": \"%s\", \"parts\": %zu, \"build_cpu_seconds\": %.4g, "
          "\"megabytes\": %.4g, \"differ\": %llu",
          subject.name.c_str(), boxes_.size(), subject.build_cpu_seconds, subject.megabytes,
          static_cast<unsigned long long>(differ));
      for (const RayKind kind : {RayKind::kPrimary, RayKind::kShadow, RayKind::kBounce})
        std::printf(", \"%s\": %.4g", ray_kind_name(kind), rate_of(subject, kind, repeats));
      std::printf("}\n");
      std::fflush(stdout);
    }
  }

 private:
  using KdConfig = core::KdBuildConfig;

  template <int W>
  core::PatchedKd<W> kd(const core::KdBuildConfig& config) const {
    std::vector<std::uint32_t> items(boxes_.size());
    std::iota(items.begin(), items.end(), 0u);
    core::MixedWriter<W> writer({}, items);
    auto structure = core::build_kd_index<W>({boxes_, writer, 0}, {}, config);
    if (!structure.is_ok()) {
      std::fprintf(stderr, "kd_patches: %s\n", structure.status().message().c_str());
      std::exit(1);
    }
    return {std::move(*structure), writer.take_blocks(), patches_};
  }

  template <class Build>
  void add(const std::string& name, const Build& build) {
    const double start = process_cpu_seconds();
    auto index = build();
    Subject& subject = subjects_.emplace_back(Subject{name});
    subject.build_cpu_seconds = process_cpu_seconds() - start;
    subject.megabytes = 1e-6 * static_cast<double>(index.memory_bytes());
    auto ways =
        std::make_shared<StructureWays<decltype(index)>>(std::move(index), table_, name, false);
    ways->enter(subject.contenders);
    subject.structure = ways;
  }

  std::vector<BlockHits> answers_of(const Subject& subject) const {
    std::vector<BlockHits> hits(primary_.blocks.size());
    for (const Contender& contender : subject.contenders) {
      if (contender.kind != RayKind::kPrimary) continue;
      for (std::size_t b = 0; b < hits.size(); ++b) contender.trace(primary_.blocks[b], hits[b]);
      break;
    }
    return hits;
  }

  void find_secondary(const std::vector<BlockHits>& hits) {
    std::vector<RayStart> starts;
    for (std::size_t b = 0; b < hits.size(); ++b) {
      const RayBlock& rays = primary_.blocks[b];
      for (int i = 0; i < rays.count; ++i) {
        RayStart& start = starts.emplace_back();
        if (hits[b].primitive[i] == core::kNoPrimitive) continue;
        const float o[3] = {rays.origin[0][i], rays.origin[1][i], rays.origin[2][i]};
        const float d[3] = {rays.direction[0][i], rays.direction[1][i], rays.direction[2][i]};
        const core::SubPatch& part = patches_->parts[hits[b].primitive[i]];
        const auto met = patch_point(patches_->patches[part.patch], part, o, d, hits[b].t[i]);
        const bool is_back = dot(met.normal, {d[0], d[1], d[2]}) > 0;
        const Vec3f normal = is_back ? -met.normal : met.normal;
        start = {true, met.point + normal * met.offset, normal};
      }
    }
    secondary_ = secondary_rays(starts, light_);
  }

  // Millions of rays a CPU-second, by the best way.
  double rate_of(const Subject& subject, RayKind kind, int repeats) const {
    const Workload& work = kind == RayKind::kPrimary  ? primary_
                           : kind == RayKind::kShadow ? secondary_.shadow
                                                      : secondary_.bounce;
    double best = 0;
    BlockHits hits;
    for (const Contender& contender : subject.contenders) {
      if (contender.kind != kind) continue;
      for (int repeat = 0; repeat < repeats; ++repeat) {
        const double start = thread_cpu_seconds();
        for (const RayBlock& block : work.blocks) contender.trace(block, hits);
        const double seconds = thread_cpu_seconds() - start;
        best = std::max(best, 1e-6 * static_cast<double>(work.ray_count) / seconds);
      }
    }
    return best;
  }

  const core::KernelTable& table_;
  const Vec3f light_;
  const Workload primary_;
  SecondaryRays secondary_;
  std::vector<Bounds3f> boxes_;
  std::shared_ptr<const core::PatchStore> patches_;
  std::vector<Subject> subjects_;
};

}  // namespace
}  // namespace tessera::bench

int main(int argc, char** argv) {
  using namespace tessera;
  const auto number = [&](int at, int usual) {
    return argc > at ? std::max(1, std::atoi(argv[at])) : usual;
  };
  const Isa isa = widest_isa(core::supported_isas());
  bench::Comparison comparison(number(1, 1), number(2, 512) / 32 * 32, isa);
  if (core::kernels_for(isa).lane_count >= 16) {
    comparison.build_all<16>();
  } else {
    comparison.build_all<8>();
  }
  comparison.run(number(3, 3));
  return 0;
}
