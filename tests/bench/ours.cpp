// SPDX-License-Identifier: Apache-2.0
#include <time.h>

#include <algorithm>
#include <memory>
#include <utility>

#include "slave/core/kernels/kernel_table.h"
#include "slave/core/primitive/freeform/patched_index.h"
#include "slave/core/primitive/instance/instanced_index.h"
#include "slave/core/primitive/primitive_index.h"
#include "slave/core/primitive/triangle/triangle_clipper.h"
#include "tests/bench/contender.h"
#include "tests/bench/structure_ways.h"

namespace tessera::bench {
namespace {

double seconds_of(clockid_t clock) {
  timespec now{};
  clock_gettime(clock, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

class Ours final : public Entrants {
 public:
  Ours(const core::TriangleStore& triangles, const std::vector<Bounds3f>& boxes, Isa isa,
       const OursOptions& options)
      : options_(options) {
    const core::KernelTable& table = core::kernels_for(isa);
    if (table.lane_count >= 16) {
      build_all<16>(table, triangles, boxes);
    } else {
      build_all<8>(table, triangles, boxes);
    }
  }

  Ours(std::shared_ptr<const core::PatchStore> patches, const std::vector<Bounds3f>& boxes,
       Isa isa) {
    const core::KernelTable& table = core::kernels_for(isa);
    if (table.lane_count >= 16) {
      build_patched<16>(table, std::move(patches), boxes);
    } else {
      build_patched<8>(table, std::move(patches), boxes);
    }
  }

  Ours(const std::vector<core::TriangleStore>& frames, const std::vector<Bounds3f>& boxes,
       Isa isa) {
    const core::KernelTable& table = core::kernels_for(isa);
    if (table.lane_count >= 16) {
      build_deformed<16>(table, frames, boxes);
    } else {
      build_deformed<8>(table, frames, boxes);
    }
  }

  Ours(const Scene& scene, Isa isa) {
    const core::KernelTable& table = core::kernels_for(isa);
    if (table.lane_count >= 16) {
      build_instanced<16>(table, scene);
    } else {
      build_instanced<8>(table, scene);
    }
  }

 private:
  template <int W>
  void build_all(const core::KernelTable& table, const core::TriangleStore& triangles,
                 const std::vector<Bounds3f>& boxes) {
    const std::string width = std::to_string(W);
    const core::BuildControl alone{1, nullptr};
    const core::TriangleClipper clipper(triangles.vertices);
    build<core::IndexedBvh<W>>("bvh" + width, table, [&] {
      return core::index_by_bvh<W>(boxes, triangles.vertices, alone, core::usual_build(clipper));
    });
    if (!options_.with_kd) return;
    build<core::IndexedBvh<W>>("bvh" + width + "q", table, [&] {
      return core::index_by_bvh<W>(boxes, triangles.vertices, alone, core::spatial_build(clipper));
    });
    build<core::IndexedKd<W>>("kd" + width, table, [&] {
      return core::index_by_kd<W>(boxes, triangles.vertices, alone);
    });
    build<core::IndexedKd<W>>("kd" + width + "q", table, [&] {
      return core::index_by_kd<W>(boxes, triangles.vertices, alone, core::quality_build(clipper));
    });
  }

  template <int W>
  void build_deformed(const core::KernelTable& table,
                      const std::vector<core::TriangleStore>& frames,
                      const std::vector<Bounds3f>& boxes) {
    const core::BuildControl alone{1, nullptr};
    const std::span<const float> now = frames.back().vertices;
    build<core::IndexedBvh<W>>("built", table,
                               [&] { return core::index_by_bvh<W>(boxes, now, alone); });
    build<core::IndexedBvh<W>>("fast", table,
                               [&] { return core::index_fast<W>(boxes, now, alone); });
    const std::vector<Bounds3f> first_boxes = core::boxes_of(frames[0].vertices);
    auto fitted = core::index_by_bvh<W>(first_boxes, frames[0].vertices, alone);
    for (std::size_t frame = 1; frame + 1 < frames.size(); ++frame)
      fitted = core::fit_index<W>(*fitted, frames[frame].vertices, alone);
    build<core::IndexedBvh<W>>("fitted", table,
                               [&] { return core::fit_index<W>(*fitted, now, alone); });
  }

  template <int W>
  void build_instanced(const core::KernelTable& table, const Scene& scene) {
    const core::BuildControl alone{1, nullptr};
    build<core::InstancedBvh<W>>("instanced" + std::to_string(W), table, [&] {
      auto placed = core::place_instances<W>(scene, {core::Instancing::kAlways}, {}, alone);
      return core::index_instances<W>(std::move(*placed), {}, nullptr, alone);
    });
  }

  template <int W>
  void build_patched(const core::KernelTable& table,
                     std::shared_ptr<const core::PatchStore> patches,
                     const std::vector<Bounds3f>& boxes) {
    const double store = 1e-6 * static_cast<double>(patches->memory_bytes());
    build<core::PatchedBvh<W>>("patches", table, [&] {
      return core::index_patches<W>({{}, {}, {}, boxes}, patches, {1, nullptr});
    });
    builds.back().megabytes += store;
  }

  template <class Index, class Build>
  void build(const std::string& name, const core::KernelTable& table, const Build& build_index) {
    const double start = process_cpu_seconds(), start_wall = wall_seconds();
    Index index = std::move(*build_index());
    const double seconds = process_cpu_seconds() - start, wall = wall_seconds() - start_wall;
    builds.push_back({name, seconds, wall, 1e-6 * static_cast<double>(index.memory_bytes())});
    auto structure =
        std::make_shared<StructureWays<Index>>(std::move(index), table, name, options_.with_sizes);
    structure->enter(contenders);
    structures_.push_back(structure);
  }

  const OursOptions options_;
  std::vector<std::shared_ptr<void>> structures_;
};

}  // namespace

double wall_seconds() { return seconds_of(CLOCK_MONOTONIC); }
double thread_cpu_seconds() { return seconds_of(CLOCK_THREAD_CPUTIME_ID); }
double process_cpu_seconds() { return seconds_of(CLOCK_PROCESS_CPUTIME_ID); }

std::unique_ptr<Entrants> make_ours(const core::TriangleStore& triangles,
                                    const std::vector<Bounds3f>& boxes, Isa isa,
                                    const OursOptions& options) {
  return std::make_unique<Ours>(triangles, boxes, isa, options);
}

std::unique_ptr<Entrants> make_ours_deformed(const std::vector<core::TriangleStore>& frames,
                                             const std::vector<Bounds3f>& boxes, Isa isa) {
  return std::make_unique<Ours>(frames, boxes, isa);
}

std::unique_ptr<Entrants> make_ours_patched(std::shared_ptr<const core::PatchStore> patches,
                                            const std::vector<Bounds3f>& boxes, Isa isa) {
  return std::make_unique<Ours>(std::move(patches), boxes, isa);
}

std::unique_ptr<Entrants> make_ours_instanced(const Scene& scene, Isa isa) {
  return std::make_unique<Ours>(scene, isa);
}

}  // namespace tessera::bench
