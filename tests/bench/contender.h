// SPDX-License-Identifier: Apache-2.0
// A contender of the benchmark: a function that takes blocks of rays and says where each ray hits.
//
// Threads. Contenders trace on any number of threads; the rest is for one.
#pragma once

#include <algorithm>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "common/base/isa.h"
#include "slave/core/primitive/freeform/patch_store.h"
#include "slave/core/primitive/triangle/triangle_store.h"
#include "tests/bench/workload.h"

namespace tessera::bench {

struct alignas(64) BlockHits {
  float t[kBlockRays];
  std::uint32_t primitive[kBlockRays];  // any-hit: 0 for blocked, core::kNoPrimitive for not
};

// Copies a number of each of up to N rays. How much a whole packet takes is known to the compiler,
// which spares a call.
template <int N, typename From, typename To>
void copy_rays(const From* from, int count, To* to) {
  if (count == N) {
    std::copy_n(from, N, to);
  } else {
    std::copy_n(from, count, to);
  }
}

// May be called by any number of threads at a time.
using Trace = std::function<void(const RayBlock& rays, BlockHits& hits)>;

struct Contender {
  std::string name;
  bool is_ours = false;
  RayKind kind = RayKind::kPrimary;
  Trace trace;
  bool is_reference_peer = false;  // ratios are to the fastest of these
};

struct Build {
  std::string name;
  double cpu_seconds = 0, wall_seconds = 0;
  double megabytes = 0;  // structure and copies of triangles; 0 where not known
};

// A set of contenders over one scene, and what building them took. The scene outlives it.
class Entrants {
 public:
  virtual ~Entrants() = default;
  std::vector<Contender> contenders;
  std::vector<Build> builds;
};

struct OursOptions {
  bool with_kd = true;      // kd-trees, beside the hierarchy
  bool with_sizes = false;  // fans of fewer rays, too, one by one
};

// The first contender of each kind is the one that the others' answers are compared with.
std::unique_ptr<Entrants> make_ours(const core::TriangleStore& triangles,
                                    const std::vector<Bounds3f>& boxes, Isa isa,
                                    const OursOptions& options);
// Our contenders with one structure for each mesh of the scene, and a second level over its
// instances.
std::unique_ptr<Entrants> make_ours_instanced(const Scene& scene, Isa isa);
// Our contenders over patches. Requires: sub-patches have their numbers, and boxes are theirs.
std::unique_ptr<Entrants> make_ours_patched(std::shared_ptr<const core::PatchStore> patches,
                                            const std::vector<Bounds3f>& boxes, Isa isa);
// Our contenders over triangles that have moved: "built" and "fast" are built where they are in the
// last frame, "fitted" in the first one and fitted to each that follows; what is timed is the last
// fit. Shape: boxes [triangle], of the last frame. Requires: all frames have the same triangles.
std::unique_ptr<Entrants> make_ours_deformed(const std::vector<core::TriangleStore>& frames,
                                             const std::vector<Bounds3f>& boxes, Isa isa);
struct EmbreeMode {
  bool is_high = false;    // build quality "high" (spatial splits) and not "medium", its default
  bool is_robust = false;  // its watertight tests
};
// Null where the benchmark was built without Embree.
std::unique_ptr<Entrants> make_embree(const core::TriangleStore& triangles, Isa isa,
                                      const EmbreeMode& mode);
std::unique_ptr<Entrants> make_embree_instanced(const Scene& scene, Isa isa);

// Uniform bicubic B-spline patches. Shape: points [patch][i][j] of 4 x 4, of N_i(u) N_j(v).
struct SplinePatches {
  std::vector<Vec3f> points;
};
// Embree's subdivision surfaces, which it cuts into cells x cells squares for each patch. What is
// hit has the numbers of the triangles of tessellated(). Null where built without Embree.
std::unique_ptr<Entrants> make_embree_subdivided(const SplinePatches& patches, int cells, Isa isa);

// Builds Embree's scene once and throws it away. Requires: has_embree().
Build build_embree(const core::TriangleStore& triangles, Isa isa, const EmbreeMode& mode,
                   int threads);
// The same with its build quality "low"; and what it takes to fit (its quality "refit") a scene of
// the first triangles to the second. Requires: has_embree().
Build build_embree_low(const core::TriangleStore& triangles, Isa isa);
Build refit_embree(const core::TriangleStore& before, const core::TriangleStore& after, Isa isa);
bool has_embree();

// Wall-clock seconds since some moment; CPU-seconds of the calling thread and of the process so
// far.
double wall_seconds();
double thread_cpu_seconds();
double process_cpu_seconds();

}  // namespace tessera::bench
