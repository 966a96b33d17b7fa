// SPDX-License-Identifier: Apache-2.0
#include "tests/bench/method_rows.h"

#include <algorithm>
#include <limits>
#include <optional>

#include "slave/core/trace/method_tracer.h"
#include "slave/core/trace/scene_tracer.h"
#include "tests/bench/method_lanes.h"
#include "tests/bench/patch_scene.h"

namespace tessera::bench {
namespace {

constexpr float kMiss = std::numeric_limits<float>::infinity();
constexpr core::PatchSplitting kWhole{1, 1, 0};
// By how much of the square a frame may leave open for rays up to 45 degrees from its normal.
constexpr double kFlatness[] = {2, 1, 0.5, 0.25};

core::SingleRay ray_of(const RayBlock& rays, int i) {
  return {{rays.origin[0][i], rays.origin[1][i], rays.origin[2][i]},
          {rays.direction[0][i], rays.direction[1][i], rays.direction[2][i]},
          0,
          rays.t_max[i]};
}

void trace_fans(const core::SceneTracer& tracer, const RayBlock& rays, float* t) {
  core::PacketHits hits;
  for (int first = 0; first < rays.count; first += core::kPacketRays) {
    core::FanPacket packet;
    packet.t_min = 0;
    packet.active = ~std::uint64_t{0};
    for (int a = 0; a < 3; ++a) {
      packet.origin[a] = rays.origin[a][first];
      std::copy_n(rays.direction[a] + first, core::kPacketRays, packet.direction[a]);
    }
    std::copy_n(rays.t_max + first, core::kPacketRays, packet.t_max);
    tracer.closest(packet, hits);
    for (int i = 0; i < core::kPacketRays; ++i)
      t[first + i] = hits.primitive[i] == core::kNoPrimitive ? kMiss : hits.t[i];
  }
}

template <class Tracer>
void trace_alone(const Tracer& tracer, const RayBlock& rays, float* t) {
  for (int i = 0; i < rays.count; ++i) {
    const core::SingleHit hit = tracer.closest(ray_of(rays, i));
    t[i] = hit.primitive == core::kNoPrimitive ? kMiss : hit.t;
  }
}

void trace_bundles(TraceLanes trace, const LaneScene& scene, const LaneHow& how, int count,
                   const RayBlock& rays, float* t) {
  LaneBundle bundle;
  for (int first = 0; first < rays.count; first += count) {
    for (int a = 0; a < 3; ++a) std::copy_n(rays.direction[a] + first, count, bundle.direction[a]);
    trace(scene, how, bundle);
    std::copy_n(bundle.t, count, t + first);
  }
}

std::string number(double x) {
  std::string text = std::to_string(x);
  text.erase(text.find_last_not_of('0') + 1);
  if (text.back() == '.') text.pop_back();
  return text;
}

}  // namespace

MethodRows::MethodRows(Isa isa)
    : isa_(isa), lanes_(core::lane_kernels(isa)), eye_(camera_of_field(1).eye) {
  add_usual(isa);
  add_refinement();
  add_newton();
  add_solvers();
}

const MethodScene& MethodRows::scene_of(const core::PatchSplitting* splitting) {
  const int lanes = core::kernels_for(isa_).lane_count;
  scenes_.push_back(std::make_unique<MethodScene>(teapot_field(1), splitting, lanes));
  return *scenes_.back();
}

// What a frame may ask for, on the product's own parts.
void MethodRows::add_usual(Isa isa) {
  const MethodScene& scene = scene_of(nullptr);
  const core::KernelTable& table = core::kernels_for(isa);
  for (const PatchMethod method : kPatchMethods) {
    const auto tracer = std::make_shared<core::SceneTracer>(scene.index(), table, nullptr, method);
    MethodRow row{
        "setting", std::string(patch_method_name(method)), scene.store().parts.size(), {}};
    if (method == PatchMethod::kAuto) {
      row.trace = [tracer](const RayBlock& rays, float* t) { trace_fans(*tracer, rays, t); };
      rows_.push_back(row);
      rows_.back().takes_one_eye = true;
      row.name += ", single rays";
    }
    row.trace = [tracer](const RayBlock& rays, float* t) { trace_alone(*tracer, rays, t); };
    rows_.push_back(row);
  }
}

void MethodRows::add_call(const std::string& group, const std::string& name,
                          const MethodScene& scene, std::shared_ptr<const CountedHow> how,
                          core::PatchMethodCall call) {
  const std::optional<core::MethodTracer> tracer =
      core::MethodTracer::make(scene.index(), call, isa_);
  MethodRow row{group, name, scene.store().parts.size(), {}};
  row.trace = [tracer](const RayBlock& rays, float* t) { trace_alone(*tracer, rays, t); };
  row.begin = [how] { how->work = 0; };
  row.how = std::move(how);
  rows_.push_back(row);
}

void MethodRows::add_lanes(const std::string& group, const std::string& name,
                           const MethodScene& scene, LaneHow how,
                           const TraceLanes (&trace)[kLaneSizes], int size) {
  const int count = lanes_.lanes[size];
  if (size > 0 && count == lanes_.lanes[size - 1]) return;  // registers are no wider
  if (lane_parts_.empty() || &lane_parts_.back()->scene() != &scene)
    lane_parts_.push_back(std::make_unique<LaneParts>(scene, eye_));
  LaneParts* const parts = lane_parts_.back().get();
  const TraceLanes call = trace[size];
  MethodRow row{group,
                name + ", " + std::to_string(count) + (count == 1 ? " ray" : " rays"),
                scene.store().parts.size(),
                {}};
  row.trace = [call, parts, how, count](const RayBlock& rays, float* t) {
    trace_bundles(call, parts->view(), how, count, rays, t);
  };
  row.begin = [parts] { parts->forget(); };
  row.takes_one_eye = true;
  rows_.push_back(row);
}

void MethodRows::add_refinement() {
  const MethodScene& whole = scene_of(&kWhole);
  for (const int level : {8, 12, 16}) {
    for (const bool is_bilinear : {true, false}) {
      CountedHow how;
      how.refine = {(level + 1) / 2, level / 2};
      const auto kept = std::make_shared<const CountedHow>(how);
      add_call("refine, double",
               "level " + std::to_string(level) + (is_bilinear ? ", bilinear" : ", triangles"),
               whole, kept, refine_call(*kept, is_bilinear));
    }
  }
  for (int size = 0; size < kLaneSizes; ++size) {
    for (int level = 0; level <= 12; ++level) {
      if (size == 1 && level % 4 != 0) continue;
      add_lanes("refine, lanes", "level " + std::to_string(level) + ", bilinear", whole, {level},
                lanes_.refine, size);
      if (level != 0 && level % 4 == 0)
        add_lanes("refine, lanes", "level " + std::to_string(level) + ", triangles", whole,
                  {level, false}, lanes_.refine, size);
    }
  }
}

void MethodRows::add_newton() {
  std::vector<std::pair<std::string, const MethodScene*>> scenes{{"whole", &scene_of(&kWhole)}};
  for (const double flatness : kFlatness) {
    const core::PatchSplitting splitting{flatness, 1, 5};
    scenes.emplace_back("flat to " + number(flatness), &scene_of(&splitting));
  }
  for (const auto& [name, scene] : scenes) {
    const auto how = std::make_shared<const CountedHow>();
    add_call("newton, double", name, *scene, how, newton_call(*how));
    for (int size = 0; size < kLaneSizes; ++size) {
      add_lanes("newton, float", name, *scene, {}, lanes_.newton, size);
      add_lanes("newton, from neighbours", name, *scene, {}, lanes_.neighbours, size);
    }
  }
}

void MethodRows::add_solvers() {
  const MethodScene& whole = scene_of(&kWhole);
  const core::PatchSplitting flat{1, 1, 5};
  const MethodScene* const scenes[] = {&whole, &scene_of(&flat)};
  constexpr const char* kNames[] = {"whole", "flat to 1"};
  for (int s = 0; s < 2; ++s) {
    const auto add = [&](const std::string& group, const std::string& name, CountedHow with,
                         auto call_of) {
      const auto how = std::make_shared<const CountedHow>(with);
      add_call(group, std::string(kNames[s]) + ", " + name, *scenes[s], how, call_of(*how));
    };
    const auto krawczyk = [](SlopeBounds bounds) {
      return [bounds](const CountedHow& how) { return krawczyk_call(how, bounds); };
    };
    add("krawczyk", "bounds by clipping", {}, krawczyk(SlopeBounds::kClipped));
    add("krawczyk", "by intervals", {}, krawczyk(SlopeBounds::kInterval));
    add("krawczyk", "by second derivatives", {}, krawczyk(SlopeBounds::kSecond));
    CountedHow first;
    first.clip.widening = 0;
    first.clip.line_sine = 0;
    add("clip", "as published first", first, clip_call);
    CountedHow widened;
    widened.clip.line_sine = 0;
    add("clip", "hulls widened", widened, clip_call);
    add("clip", "and both distances", {}, clip_call);
    if (s != 0) continue;
    for (int size = 0; size < kLaneSizes; ++size)
      add_lanes("krawczyk, newton lanes", kNames[s], whole, {}, lanes_.serial, size);
  }
}

}  // namespace tessera::bench
