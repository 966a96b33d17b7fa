// SPDX-License-Identifier: Apache-2.0
// The rows of the table of methods: what each is called and how it traces.
// Threads. One.
#pragma once

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "common/base/isa.h"
#include "tests/bench/method_scene.h"
#include "tests/bench/method_variants.h"

namespace tessera::bench {

struct MethodRow {
  std::string group, name;
  std::size_t parts = 0;
  // Shape: t [kBlockRays], infinite for a miss.
  std::function<void(const RayBlock& rays, float* t)> trace;
  std::function<void()> begin = [] {};      // before all rays
  std::shared_ptr<const CountedHow> how{};  // null where nothing is counted
  bool takes_one_eye = false;               // that of the teapot's camera
};

// The scenes that rows trace, and the rows. They are over the teapot, as teapot_field(1) has it,
// and for rays from its camera.
class MethodRows {
 public:
  explicit MethodRows(Isa isa);

  const std::vector<MethodRow>& rows() const { return rows_; }
  // The one that is split as the product does it, whose usual way is the first row.
  const MethodScene& product() const { return *scenes_[0]; }

 private:
  const MethodScene& scene_of(const core::PatchSplitting* splitting);
  void add_usual(Isa isa);
  void add_call(const std::string& group, const std::string& name, const MethodScene& scene,
                std::shared_ptr<const CountedHow> how, core::PatchMethodCall call);
  void add_lanes(const std::string& group, const std::string& name, const MethodScene& scene,
                 LaneHow how, const TraceLanes (&trace)[kLaneSizes], int size);
  void add_refinement();
  void add_newton();
  void add_solvers();

  Isa isa_;
  LaneKernels lanes_;
  Vec3f eye_;
  std::vector<std::unique_ptr<MethodScene>> scenes_;
  std::vector<std::unique_ptr<LaneParts>> lane_parts_;
  std::vector<MethodRow> rows_;
};

}  // namespace tessera::bench
