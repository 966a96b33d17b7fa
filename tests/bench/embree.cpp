// Embree 3 (https://www.embree.org) beside us: quality "medium", which is its default, its fast, not
// watertight tests, one thread, held to the same instruction set.
#include <embree3/rtcore.h>

#include <vector>

#include "tests/bench/contender.h"

namespace tessera::bench {
namespace {

struct Release {
  void operator()(RTCDevice device) const { rtcReleaseDevice(device); }
  void operator()(RTCScene scene) const { rtcReleaseScene(scene); }
};

class Embree final : public Entrants {
 public:
  Embree(const core::TriangleStore& triangles, Isa isa) {
    static constexpr const char* kConfigs[] = {"sse2", "sse4.2", "avx2", "avx512"};
    const std::string config =
        std::string("threads=1,set_affinity=0,isa=") + kConfigs[static_cast<int>(isa)];
    device_.reset(rtcNewDevice(config.c_str()));
    rtcSetDeviceMemoryMonitorFunction(device_.get(), count_bytes, &bytes_);
    scene_.reset(rtcNewScene(device_.get()));
    RTCGeometry geometry = rtcNewGeometry(device_.get(), RTC_GEOMETRY_TYPE_TRIANGLE);
    const auto count = static_cast<std::size_t>(triangles.triangle_count());
    // Vertices are not shared here: the hierarchy is what is measured, and it copies them.
    auto* vertices = static_cast<float*>(rtcSetNewGeometryBuffer(
        geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, 12, 3 * count));
    auto* indices = static_cast<unsigned*>(
        rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, 12, count));
    std::copy(triangles.vertices.begin(), triangles.vertices.end(), vertices);
    for (std::size_t i = 0; i < 3 * count; ++i) indices[i] = static_cast<unsigned>(i);
    const std::int64_t before = bytes_;
    const double start = process_cpu_seconds();
    rtcCommitGeometry(geometry);
    rtcAttachGeometry(scene_.get(), geometry);
    rtcCommitScene(scene_.get());
    const double seconds = process_cpu_seconds() - start;
    rtcReleaseGeometry(geometry);
    builds.push_back({"embree medium", seconds, 1e-6 * static_cast<double>(bytes_ - before)});
    contenders.push_back({"embree 1", false, [this](const auto& r, auto& h) { trace1(r, h); }});
    contenders.push_back({"embree 8", false, [this](const auto& r, auto& h) { trace8(r, h); }});
    contenders.push_back(
        {"embree stream", false, [this](const auto& r, auto& h) { stream(r, h); }});
  }

 private:
  static bool count_bytes(void* sum, ssize_t bytes, bool) {
    *static_cast<std::int64_t*>(sum) += bytes;
    return true;
  }

  static RTCIntersectContext coherent() {
    RTCIntersectContext context;
    rtcInitIntersectContext(&context);
    context.flags = RTC_INTERSECT_CONTEXT_FLAG_COHERENT;
    return context;
  }

  static RTCRayHit query(const core::FanPacket& rays, int i) {
    RTCRayHit q{};
    q.ray.org_x = rays.origin[0], q.ray.org_y = rays.origin[1], q.ray.org_z = rays.origin[2];
    q.ray.dir_x = rays.direction[0][i], q.ray.dir_y = rays.direction[1][i];
    q.ray.dir_z = rays.direction[2][i];
    q.ray.tfar = rays.t_max[i];
    q.ray.mask = ~0u;
    q.hit.geomID = q.hit.instID[0] = RTC_INVALID_GEOMETRY_ID;
    return q;
  }

  static void store(const RTCRayHit& q, core::PacketHits& hits, int i) {
    const bool is_hit = q.hit.geomID != RTC_INVALID_GEOMETRY_ID;
    hits.t[i] = is_hit ? q.ray.tfar : 0;
    hits.primitive[i] = is_hit ? q.hit.primID : core::kNoPrimitive;
  }

  void trace1(const core::FanPacket& rays, core::PacketHits& hits) {
    RTCIntersectContext context = coherent();
    for (int i = 0; i < core::kPacketRays; ++i) {
      RTCRayHit q = query(rays, i);
      rtcIntersect1(scene_.get(), &context, &q);
      store(q, hits, i);
    }
  }

  void stream(const core::FanPacket& rays, core::PacketHits& hits) {
    RTCIntersectContext context = coherent();
    RTCRayHit queries[core::kPacketRays];
    for (int i = 0; i < core::kPacketRays; ++i) queries[i] = query(rays, i);
    rtcIntersect1M(scene_.get(), &context, queries, core::kPacketRays, sizeof(RTCRayHit));
    for (int i = 0; i < core::kPacketRays; ++i) store(queries[i], hits, i);
  }

  void trace8(const core::FanPacket& rays, core::PacketHits& hits) {
    RTCIntersectContext context = coherent();
    alignas(32) int valid[8];
    std::fill_n(valid, 8, -1);
    for (int first = 0; first < core::kPacketRays; first += 8) {
      RTCRayHit8 q{};
      for (int i = 0; i < 8; ++i) {
        q.ray.org_x[i] = rays.origin[0], q.ray.org_y[i] = rays.origin[1];
        q.ray.org_z[i] = rays.origin[2];
        q.ray.dir_x[i] = rays.direction[0][first + i];
        q.ray.dir_y[i] = rays.direction[1][first + i];
        q.ray.dir_z[i] = rays.direction[2][first + i];
        q.ray.tfar[i] = rays.t_max[first + i];
        q.ray.mask[i] = ~0u;
        q.hit.geomID[i] = q.hit.instID[0][i] = RTC_INVALID_GEOMETRY_ID;
      }
      rtcIntersect8(valid, scene_.get(), &context, &q);
      for (int i = 0; i < 8; ++i) {
        const bool is_hit = q.hit.geomID[i] != RTC_INVALID_GEOMETRY_ID;
        hits.t[first + i] = is_hit ? q.ray.tfar[i] : 0;
        hits.primitive[first + i] = is_hit ? q.hit.primID[i] : core::kNoPrimitive;
      }
    }
  }

  std::int64_t bytes_ = 0;
  std::unique_ptr<RTCDeviceTy, Release> device_;
  std::unique_ptr<RTCSceneTy, Release> scene_;
};

}  // namespace

std::unique_ptr<Entrants> make_embree(const core::TriangleStore& triangles, Isa isa) {
  return std::make_unique<Embree>(triangles, isa);
}

}  // namespace tessera::bench
