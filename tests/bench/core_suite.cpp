#include "tests/bench/core_suite.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <fstream>
#include <limits>

#include "common/base/json.h"
#include "slave/core/geometry/triangle_store.h"
#include "slave/core/render/camera_rays.h"
#include "tests/bench/contender.h"
#include "tests/bench/scenes.h"
#include "tests/support/test_meshes.h"

namespace tessera::bench {
namespace {

// 8x8 pixels a packet; rows of 8 rays are 4x2 pixels, so that every power of two is a block.
std::vector<core::FanPacket> primary_rays(const Camera& camera, int size_px) {
  const core::CameraRays rays(camera, size_px, size_px);
  std::vector<core::FanPacket> packets;
  for (int y = 0; y < size_px; y += 8) {
    for (int x = 0; x < size_px; x += 8) {
      core::FanPacket& packet = packets.emplace_back();
      packet.active = ~std::uint64_t{0};
      for (int a = 0; a < 3; ++a) packet.origin[a] = rays.origin()[a];
      for (int i = 0; i < core::kPacketRays; ++i) {
        const int px = x + (i & 1) + (i >> 1 & 2) + (i >> 2 & 4);
        const int py = y + (i >> 1 & 1) + (i >> 2 & 2) + (i >> 3 & 4);
        const Vec3f d = normalize(rays.direction(px + 0.5, py + 0.5));
        for (int a = 0; a < 3; ++a) packet.direction[a][i] = d[a];
        packet.t_max[i] = std::numeric_limits<float>::infinity();
      }
    }
  }
  return packets;
}

struct Row {
  const Contender* contender = nullptr;
  std::vector<double> cpu_seconds;
  std::uint64_t hits = 0, different = 0;  // from the first row's primitives
  double sum_t = 0;
};

double median(std::vector<double> values) {
  std::sort(values.begin(), values.end());
  const std::size_t n = values.size();
  return n == 0 ? 0 : (values[n / 2] + values[(n - 1) / 2]) / 2;
}

void measure(Row& row, const std::vector<core::FanPacket>& rays, bool is_warm_up,
             std::vector<core::PacketHits>& first, std::vector<core::PacketHits>& hits) {
  const double start = thread_cpu_seconds();
  for (std::size_t p = 0; p < rays.size(); ++p) row.contender->trace(rays[p], hits[p]);
  const double seconds = thread_cpu_seconds() - start;
  if (!is_warm_up) return row.cpu_seconds.push_back(seconds);
  if (first.empty()) first = hits;
  for (std::size_t p = 0; p < rays.size(); ++p) {
    for (int i = 0; i < core::kPacketRays; ++i) {
      if (hits[p].primitive[i] != first[p].primitive[i]) ++row.different;
      if (hits[p].primitive[i] == core::kNoPrimitive) continue;
      ++row.hits;
      row.sum_t += static_cast<double>(hits[p].t[i]);
    }
  }
}

std::string report(const BenchScene& scene, const std::vector<Row>& rows, std::size_t ray_count,
                   const std::vector<Build>& builds) {
  const auto rate = [&](const Row& row) {
    return 1e-6 * static_cast<double>(ray_count) / median(row.cpu_seconds);
  };
  double best_peer = 0;
  for (const Row& row : rows) {
    if (!row.contender->is_ours) best_peer = std::max(best_peer, rate(row));
  }
  std::printf("\n%s, %zu triangles, %zu camera rays\n", scene.name.c_str(),
              scene.mesh.triangles.size(), ray_count);
  std::printf("  %-18s %12s %10s %10s %10s %16s\n", "", "Mrays/CPU-s", "to Embree", "hits",
              "differ", "sum of t");
  std::string list = "[";
  for (const Row& row : rows) {
    std::printf("  %-18s %12.2f %10.2f %10llu %10llu %16.9g\n", row.contender->name.c_str(),
                rate(row), best_peer > 0 ? rate(row) / best_peer : std::nan(""),
                static_cast<unsigned long long>(row.hits),
                static_cast<unsigned long long>(row.different), row.sum_t);
    JsonObject json;
    json.add("name", row.contender->name).add("mrays_per_cpu_second", rate(row));
    json.add("hits", row.hits).add("differ", row.different).add("sum_t", row.sum_t);
    list += (list.size() > 1 ? "," : "") + json.text();
  }
  std::string build_list = "[";
  for (const Build& build : builds) {
    std::printf("  build %-12s %12.0f ms %27.1f MB\n", build.name.c_str(), 1e3 * build.cpu_seconds,
                build.megabytes);
    JsonObject json;
    json.add("name", build.name).add("cpu_seconds", build.cpu_seconds).add("mb", build.megabytes);
    build_list += (build_list.size() > 1 ? "," : "") + json.text();
  }
  JsonObject json;
  json.add("scene", scene.name).add("rays", static_cast<std::uint64_t>(ray_count));
  json.add_raw("primary", list + "]").add_raw("builds", build_list + "]");
  return json.text();
}

std::string run_scene(const BenchScene& scene, const CoreSuiteOptions& options) {
  std::vector<Bounds3f> boxes;
  const core::TriangleStore triangles =
      core::make_triangle_store(test::make_scene(scene.mesh), boxes);
  std::vector<std::unique_ptr<Entrants>> entrants;
  entrants.push_back(make_ours(triangles, boxes, options.isa));
  if (auto embree = make_embree(triangles, options.isa)) entrants.push_back(std::move(embree));
  std::vector<Row> rows;
  std::vector<Build> builds;
  for (const auto& entrant : entrants) {
    for (const Contender& contender : entrant->contenders)
      rows.push_back({&contender, {}, 0, 0, 0});
    builds.insert(builds.end(), entrant->builds.begin(), entrant->builds.end());
  }
  const std::vector<core::FanPacket> rays = primary_rays(scene.camera, options.size_px);
  std::vector<core::PacketHits> first, hits(rays.size());
  for (int repeat = -1; repeat < options.repeats; ++repeat) {
    for (Row& row : rows) measure(row, rays, repeat < 0, first, hits);
  }
  return report(scene, rows, rays.size() * core::kPacketRays, builds);
}

}  // namespace

Status run_core_suite(const CoreSuiteOptions& options) {
  std::string list = "[";
  for (const std::string& name : options.scenes) {
    std::fprintf(stderr, "making %s\n", name.c_str());
    auto scene = make_scene(name);
    if (!scene.is_ok()) return scene.status();
    list += (list.size() > 1 ? "," : "") + run_scene(*scene, options);
  }
  if (options.json_path.empty()) return Status::ok();
  std::ofstream file(options.json_path);
  file << JsonObject().add("isa", isa_name(options.isa)).add_raw("core", list + "]").text() << "\n";
  if (!file.flush()) return Status::unavailable(options.json_path + ": cannot be written");
  return Status::ok();
}

}  // namespace tessera::bench
