// SPDX-License-Identifier: Apache-2.0
#include "tests/bench/gi_speed.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <vector>

#include "common/base/json.h"
#include "slave/core/kernels/kernel_table.h"
#include "slave/core/scene/prepared_scene_impl.h"
#include "slave/core/trace/scene_tracer.h"
#include "tests/bench/contender.h"
#include "tests/bench/gi_frame.h"

namespace tessera::bench {
namespace {

struct Resolution {
  int width_px, height_px;
};
// Resolutions of the thesis's tables 9.1 and 9.2.
constexpr Resolution kSizes[] = {{640, 480}, {800, 600}, {1000, 1000}, {1600, 1200}};

class SpeedTables {
 public:
  SpeedTables(const core::PreparedScene& scene, const FrameSettings& settings,
              const CoreSuiteOptions& options)
      : scene_(scene), base_(settings), options_(options) {
    repeats_ = options.is_quick ? 1 : options.repeats;
  }

  std::string run() {
    json_.add_raw("profile", profile("without a bound", base_));
    FrameSettings usual = base_;
    usual.clamp = kClampAuto;
    usual.is_compensated = true;
    json_.add_raw("profile_compensated", profile("bound, compensated", usual));
    json_.add_raw("costs", costs());
    json_.add_raw("same_rays", same_rays());
    json_.add_raw("resolutions", resolutions());
    return json_.text();
  }

 private:
  // The frame whose time is the median.
  GiFrame measured(const FrameSettings& settings) const {
    std::vector<GiFrame> frames;
    for (int i = 0; i < repeats_; ++i) frames.push_back(render_gi(scene_, settings, options_.isa));
    std::sort(frames.begin(), frames.end(),
              [](const GiFrame& a, const GiFrame& b) { return a.cpu_seconds < b.cpu_seconds; });
    return frames[frames.size() / 2];
  }

  FrameSettings sized(Resolution size) const { return sized(size, base_); }
  FrameSettings sized(Resolution size, const FrameSettings& settings) const {
    FrameSettings s = settings;
    s.width_px = options_.is_quick ? size.width_px / 5 : size.width_px;
    s.height_px = options_.is_quick ? size.height_px / 5 : size.height_px;
    return s;
  }

  // Where a frame's time goes.
  std::string profile(const char* what, const FrameSettings& settings) {
    const GiFrame frame = measured(sized(kSizes[0], settings));
    std::printf("  profile of a frame, 640x480, 64 VPLs, 3x3, %s:", what);
    JsonObject o;
    for (int part = 0; part < kGiParts; ++part) {
      const double share = frame.share[static_cast<std::size_t>(part)];
      std::printf(" %s %.1f%%", gi_part_name(static_cast<GiPart>(part)), 100 * share);
      o.add(gi_part_name(static_cast<GiPart>(part)), share);
    }
    std::printf("\n");
    return o.text();
  }

  // Prints ratios of times of whole frames, and of camera rays where the line says so.
  std::string costs() {
    const FrameSettings base = sized(kSizes[0]);
    FrameSettings s = base;
    const GiFrame three = measured(base);
    s.interleave = 1;
    const GiFrame one = measured(s);
    s = base;
    s.samples_per_pixel = 4;
    const GiFrame four_samples = measured(s);
    JsonObject o;
    const auto say = [&](const char* name, double ratio) {
      std::printf("  %-58s %8.2f\n", name, ratio);
      o.add(name, ratio);
    };
    say("four samples a pixel, to one", four_samples.cpu_seconds / three.cpu_seconds);
    say("camera rays with 3x3 interleaving, to without",
        three.seconds(GiPart::kCamera) / one.seconds(GiPart::kCamera));
    say("frame with 3x3 interleaving, to without", three.cpu_seconds / one.cpu_seconds);
    for (const int k : {3, 5}) {
      s = base;
      s.interleave = k;
      s.tile_edge_px = 256;
      s.is_filtered = false;
      const double alone = measured(s).cpu_seconds;
      s.is_filtered = true;
      for (const int edge : {16, 32, 64, 128}) {
        s.tile_edge_px = edge;
        char name[80];
        std::snprintf(name, sizeof(name), "border and filter, %dx%d, tiles of %d, to no filter", k,
                      k, edge);
        say(name, measured(s).cpu_seconds / alone);
      }
    }
    return o.text();
  }

  // Traces some of the frame's shadow rays again, outside the renderer, in the core and in Embree.
  std::string same_rays() {
    const FrameSettings s = sized(kSizes[0]);
    const GiFrame frame = measured(s);
    const double inside = 1e-6 * static_cast<double>(frame.rays.shadow) / frame.cpu_seconds;
    const Workload work = shadow_rays_of(scene_, s, options_.isa, options_.is_quick ? 40 : 16);
    const core::TriangleStore& triangles = scene_.impl().triangles;
    std::vector<Bounds3f> boxes(triangles.primitive_count());
    for (std::size_t i = 0; i < boxes.size(); ++i) {
      for (int k = 0; k < 3; ++k) boxes[i].grow(triangles.vertex(i, k));
    }
    std::vector<std::unique_ptr<Entrants>> entrants;
    entrants.push_back(make_ours(triangles, boxes, options_.isa, {}));
    if (auto embree = make_embree(triangles, options_.isa, {}))
      entrants.push_back(std::move(embree));
    std::printf("  %-44s %12s\n", "shadow rays of the frame", "Mrays/CPU-s");
    std::printf("  %-44s %12.2f\n", "in the renderer, everything included", inside);
    double fans = 0, single = 0, peer = 0;
    for (const auto& entrant : entrants) {
      for (const Contender& contender : entrant->contenders) {
        if (contender.kind != RayKind::kShadow) continue;
        const double rate = rate_of(contender, work);
        std::printf("  %-44s %12.2f\n", contender.name.c_str(), rate);
        if (contender.name.find("fan from light") != std::string::npos) fans = std::max(fans, rate);
        if (contender.is_ours && contender.name.find("single") != std::string::npos)
          single = std::max(single, rate);
        if (contender.is_reference_peer) peer = std::max(peer, rate);
      }
    }
    std::printf(
        "  in the renderer, to the core's fans %.2f, to its single rays %.2f, to Embree %.2f\n",
        inside / fans, inside / single, peer > 0 ? inside / peer : std::nan(""));
    JsonObject o;
    o.add("in_renderer", inside).add("fans", fans).add("single", single);
    if (peer > 0) o.add("embree", peer);
    return o.text();
  }

  double rate_of(const Contender& contender, const Workload& work) const {
    std::vector<double> times;
    BlockHits hits;
    for (int repeat = -1; repeat < repeats_; ++repeat) {
      const double start = thread_cpu_seconds();
      for (const RayBlock& block : work.blocks) contender.trace(block, hits);
      if (repeat >= 0) times.push_back(thread_cpu_seconds() - start);
    }
    return 1e-6 * static_cast<double>(work.ray_count) / median(times);
  }

  // Tables 9.1 and 9.2; the thesis's figures are of its scenes Office, Conference and Power Plant
  // on an Athlon MP 1800+, and its tiles have 40x40 pixels.
  std::string resolutions() {
    constexpr const char* kNewToOld[] = {"2.7 3.2 2.5", "2.9 3.41 2.7", "4.2 7.2 4.0",
                                         "5.7 8.0 5.1"};
    constexpr const char* kRates[] = {"1.72 1.12 0.33", "1.77 1.22 0.42", "1.84 1.33 0.44",
                                      "2.00 1.46 0.48"};
    std::printf("  %-11s %9s %9s %12s %-16s %12s %-16s %10s %8s\n", "resolution", "CPU-s",
                "to single", "(9.1)", "", "16 VPLs,", "(9.2) Mrays/s", "kB a frame", "");
    std::string list = "[";
    for (std::size_t i = 0; i < std::size(kSizes); ++i) {
      FrameSettings s = sized(kSizes[i]);
      const GiFrame frame = measured(s);
      const double single = single_rate(s);
      // Time of the frame with single shadow rays, if all else takes as long as it does now.
      const double rays = 1e-6 * static_cast<double>(frame.rays.shadow);
      const double with_single = frame.cpu_seconds - frame.seconds(GiPart::kShadow) -
                                 frame.seconds(GiPart::kGroup) + rays / single;
      s.vpls = 16;
      const GiFrame few = measured(s);
      const double all = 1e-6 * static_cast<double>(few.rays.shadow + few.rays.primary);
      const double kb = 3e-3 * s.width_px * s.height_px;
      std::printf("  %4dx%-6d %9.2f %8.2fx %12s %-16s %12.2f %-16s %10.0f\n", s.width_px,
                  s.height_px, frame.cpu_seconds, with_single / frame.cpu_seconds, kNewToOld[i], "",
                  all / few.cpu_seconds, kRates[i], kb);
      JsonObject o;
      o.add("width", s.width_px).add("height", s.height_px).add("cpu_seconds", frame.cpu_seconds);
      o.add("to_single", with_single / frame.cpu_seconds);
      o.add("mrays_16_vpls", all / few.cpu_seconds).add("kb_display8", kb);
      list += (list.size() > 1 ? "," : "") + o.text();
    }
    return list + "]";
  }

  // Returns: millions of rays per second of the core's any-hit rays one by one, on the frame's
  // structure.
  double single_rate(const FrameSettings& s) const {
    const Workload work = shadow_rays_of(scene_, s, options_.isa, options_.is_quick ? 40 : 64);
    const core::SceneTracer tracer(scene_.impl().index, core::kernels_for(options_.isa));
    const Contender single{
        "single", true, RayKind::kShadow,
        [&tracer](const RayBlock& rays, BlockHits& hits) {
          for (int i = 0; i < rays.count; ++i) {
            const core::SingleRay ray{
                {rays.origin[0][i], rays.origin[1][i], rays.origin[2][i]},
                {rays.direction[0][i], rays.direction[1][i], rays.direction[2][i]},
                0,
                rays.t_max[i]};
            hits.primitive[i] = tracer.occluded(ray) ? 0 : core::kNoPrimitive;
          }
        },
        false};
    return rate_of(single, work);
  }

  const core::PreparedScene& scene_;
  FrameSettings base_;
  const CoreSuiteOptions& options_;
  int repeats_ = 5;
  JsonObject json_;
};

}  // namespace

std::string measure_speed(const core::PreparedScene& scene, const FrameSettings& settings,
                          const CoreSuiteOptions& options) {
  return SpeedTables(scene, settings, options).run();
}

}  // namespace tessera::bench
