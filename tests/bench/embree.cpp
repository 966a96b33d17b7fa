// SPDX-License-Identifier: Apache-2.0
// Embree 3 (https://www.embree.org) as a contender, held to the same instruction set as ours.
#include <embree3/rtcore.h>

#include <algorithm>
#include <cstring>
#include <vector>

#include "slave/core/ray/packet_layout.h"
#include "tests/bench/contender.h"

namespace tessera::bench {
namespace {

struct Release {
  void operator()(RTCDevice device) const { rtcReleaseDevice(device); }
  void operator()(RTCScene scene) const { rtcReleaseScene(scene); }
};

// Embree's calls for packets of N rays.
template <int N>
struct Calls;
template <>
struct Calls<4> {
  static constexpr auto intersect = rtcIntersect4;
  static constexpr auto occluded = rtcOccluded4;
  using RayHit = RTCRayHit4;
  using Ray = RTCRay4;
};
template <>
struct Calls<8> {
  static constexpr auto intersect = rtcIntersect8;
  static constexpr auto occluded = rtcOccluded8;
  using RayHit = RTCRayHit8;
  using Ray = RTCRay8;
};
template <>
struct Calls<16> {
  static constexpr auto intersect = rtcIntersect16;
  static constexpr auto occluded = rtcOccluded16;
  using RayHit = RTCRayHit16;
  using Ray = RTCRay16;
};

void set_ray(RTCRay& ray, const RayBlock& rays, int i) {
  ray.org_x = rays.origin[0][i], ray.org_y = rays.origin[1][i], ray.org_z = rays.origin[2][i];
  ray.dir_x = rays.direction[0][i], ray.dir_y = rays.direction[1][i];
  ray.dir_z = rays.direction[2][i];
  ray.tnear = 0;
  ray.tfar = rays.t_max[i];
  ray.mask = ~0u;
  ray.time = 0;
  ray.flags = 0;
}

// Sets the lanes to the rays from `first` on. Returns: how many lanes are set.
template <int N, typename Ray>
int set_rays(Ray& ray, int* valid, const RayBlock& rays, int first) {
  const int count = std::min(N, rays.count - first);
  float* const to[] = {ray.org_x, ray.org_y, ray.org_z, ray.dir_x, ray.dir_y, ray.dir_z};
  for (int a = 0; a < 3; ++a) {
    copy_rays<N>(rays.origin[a] + first, count, to[a]);
    copy_rays<N>(rays.direction[a] + first, count, to[3 + a]);
  }
  copy_rays<N>(rays.t_max + first, count, ray.tfar);
  for (int i = 0; i < N; ++i) {
    valid[i] = i < count ? -1 : 0;
    ray.tnear[i] = ray.time[i] = 0;
    ray.mask[i] = ~0u;
    ray.flags[i] = 0;
  }
  return count;
}

std::string config_of(Isa isa, int threads) {
  static constexpr const char* kConfigs[] = {"sse2", "sse4.2", "avx2", "avx512"};
  return "threads=" + std::to_string(threads) +
         ",set_affinity=0,isa=" + kConfigs[static_cast<int>(isa)];
}

bool count_bytes(void* sum, ssize_t bytes, bool) {
  *static_cast<std::int64_t*>(sum) += bytes;
  return true;
}

// Vertices are not shared here: the hierarchy is what is measured, and it copies them. Returns: the
// geometry's vertices.
float* set_triangles(RTCGeometry geometry, const core::TriangleStore& triangles) {
  const auto count = static_cast<std::size_t>(triangles.primitive_count());
  auto* vertices = static_cast<float*>(rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0,
                                                               RTC_FORMAT_FLOAT3, 12, 3 * count));
  auto* indices = static_cast<unsigned*>(
      rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, 12, count));
  std::copy(triangles.vertices.begin(), triangles.vertices.end(), vertices);
  for (std::size_t i = 0; i < 3 * count; ++i) indices[i] = static_cast<unsigned>(i);
  return vertices;
}

class Embree final : public Entrants {
 public:
  Embree(const core::TriangleStore& triangles, Isa isa, const EmbreeMode& mode, int threads) {
    open(isa, threads);
    const std::string name = std::string("embree") + (mode.is_high ? " high" : " medium") +
                             (mode.is_robust ? " robust" : "");
    build(triangles, mode, name);
    for (int kind = 0; kind < kRayKinds; ++kind) enter(static_cast<RayKind>(kind), name, mode);
  }

  // Makes an Embree scene of each mesh, and one of instances over them.
  Embree(const Scene& scene, Isa isa) {
    open(isa, 1);
    build(scene);
    for (int kind = 0; kind < kRayKinds; ++kind)
      enter(static_cast<RayKind>(kind), "embree instanced", {});
  }

 private:
  void open(Isa isa, int threads) {
    device_.reset(rtcNewDevice(config_of(isa, threads).c_str()));
    rtcSetDeviceMemoryMonitorFunction(device_.get(), count_bytes, &bytes_);
  }

  void build(const Scene& scene) {
    const std::int64_t before = bytes_;
    const double start = process_cpu_seconds(), start_wall = wall_seconds();
    for (const auto& mesh : scene.meshes) {
      RTCScene part = rtcNewScene(device_.get());
      RTCGeometry geometry = rtcNewGeometry(device_.get(), RTC_GEOMETRY_TYPE_TRIANGLE);
      void* vertices = rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0,
                                               RTC_FORMAT_FLOAT3, 12, mesh->positions.size());
      std::memcpy(vertices, mesh->positions.data(), 12 * mesh->positions.size());
      void* indices = rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3,
                                              12, mesh->triangles.size());
      std::memcpy(indices, mesh->triangles.data(), 12 * mesh->triangles.size());
      rtcCommitGeometry(geometry);
      rtcAttachGeometry(part, geometry);
      rtcReleaseGeometry(geometry);
      rtcCommitScene(part);
      parts_.emplace_back(part);
    }
    scene_.reset(rtcNewScene(device_.get()));
    std::uint32_t first = 0;
    for (const Instance& instance : scene.instances) {
      RTCGeometry geometry = rtcNewGeometry(device_.get(), RTC_GEOMETRY_TYPE_INSTANCE);
      rtcSetGeometryInstancedScene(geometry, parts_[instance.mesh].get());
      rtcSetGeometryTransform(geometry, 0, RTC_FORMAT_FLOAT3X4_ROW_MAJOR,
                              instance.object_to_world.m.data());
      rtcCommitGeometry(geometry);
      rtcAttachGeometry(scene_.get(), geometry);
      rtcReleaseGeometry(geometry);
      first_.push_back(first);
      first += static_cast<std::uint32_t>(scene.meshes[instance.mesh]->triangles.size());
    }
    rtcCommitScene(scene_.get());
    const double seconds = process_cpu_seconds() - start, wall = wall_seconds() - start_wall;
    builds.push_back(
        {"embree instanced", seconds, wall, 1e-6 * static_cast<double>(bytes_ - before)});
  }

  std::uint32_t number(unsigned instance, unsigned primitive) const {
    return instance == RTC_INVALID_GEOMETRY_ID ? primitive : first_[instance] + primitive;
  }

  void build(const core::TriangleStore& triangles, const EmbreeMode& mode,
             const std::string& name) {
    scene_.reset(rtcNewScene(device_.get()));
    if (mode.is_high) rtcSetSceneBuildQuality(scene_.get(), RTC_BUILD_QUALITY_HIGH);
    if (mode.is_robust) rtcSetSceneFlags(scene_.get(), RTC_SCENE_FLAG_ROBUST);
    RTCGeometry geometry = rtcNewGeometry(device_.get(), RTC_GEOMETRY_TYPE_TRIANGLE);
    if (mode.is_high) rtcSetGeometryBuildQuality(geometry, RTC_BUILD_QUALITY_HIGH);
    set_triangles(geometry, triangles);
    const std::int64_t before = bytes_;
    const double start = process_cpu_seconds(), start_wall = wall_seconds();
    rtcCommitGeometry(geometry);
    rtcAttachGeometry(scene_.get(), geometry);
    rtcCommitScene(scene_.get());
    const double seconds = process_cpu_seconds() - start, wall = wall_seconds() - start_wall;
    rtcReleaseGeometry(geometry);
    builds.push_back({name, seconds, wall, 1e-6 * static_cast<double>(bytes_ - before)});
  }

  void enter(RayKind kind, const std::string& name, const EmbreeMode& mode) {
    const bool is_any = kind == RayKind::kShadow, is_coherent = kind != RayKind::kBounce;
    const auto add = [&](const char* width, auto trace) {
      const Trace call = [this, trace, is_coherent](const RayBlock& rays, BlockHits& hits) {
        RTCIntersectContext context;
        rtcInitIntersectContext(&context);
        context.flags = is_coherent ? RTC_INTERSECT_CONTEXT_FLAG_COHERENT
                                    : RTC_INTERSECT_CONTEXT_FLAG_INCOHERENT;
        (this->*trace)(context, rays, hits);
      };
      contenders.push_back({name + " " + width, false, kind, call});
      contenders.back().is_reference_peer = !mode.is_high && !mode.is_robust;
    };
    add("1", is_any ? &Embree::occluded1 : &Embree::intersect1);
    add("4", is_any ? &Embree::occluded<4> : &Embree::intersect<4>);
    add("8", is_any ? &Embree::occluded<8> : &Embree::intersect<8>);
    // rtcOccluded16() and rtcOccluded1M() of 3.13.5 do not return where rays meet instances.
    if (is_any && !parts_.empty()) return;
    add("16", is_any ? &Embree::occluded<16> : &Embree::intersect<16>);
    add("stream", is_any ? &Embree::occluded_stream : &Embree::intersect_stream);
  }

  void store(const RTCRayHit& q, BlockHits& hits, int i) const {
    const bool is_hit = q.hit.geomID != RTC_INVALID_GEOMETRY_ID;
    hits.t[i] = is_hit ? q.ray.tfar : 0;
    hits.primitive[i] = is_hit ? number(q.hit.instID[0], q.hit.primID) : core::kNoPrimitive;
  }
  static void store_any(float t_far, BlockHits& hits, int i) {
    hits.t[i] = 0;
    hits.primitive[i] = t_far < 0 ? 0 : core::kNoPrimitive;
  }

  static RTCRayHit* queries_of_thread() {
    static thread_local std::vector<RTCRayHit> queries(kBlockRays);
    return queries.data();
  }

  void intersect1(RTCIntersectContext& context, const RayBlock& rays, BlockHits& hits) {
    for (int i = 0; i < rays.count; ++i) {
      RTCRayHit q;
      set_ray(q.ray, rays, i);
      q.hit.geomID = q.hit.instID[0] = RTC_INVALID_GEOMETRY_ID;
      rtcIntersect1(scene_.get(), &context, &q);
      store(q, hits, i);
    }
  }

  void occluded1(RTCIntersectContext& context, const RayBlock& rays, BlockHits& hits) {
    for (int i = 0; i < rays.count; ++i) {
      RTCRay q;
      set_ray(q, rays, i);
      rtcOccluded1(scene_.get(), &context, &q);
      store_any(q.tfar, hits, i);
    }
  }

  template <int N>
  void intersect(RTCIntersectContext& context, const RayBlock& rays, BlockHits& hits) {
    alignas(64) int valid[N];
    typename Calls<N>::RayHit q;
    for (int first = 0; first < rays.count; first += N) {
      const int count = set_rays<N>(q.ray, valid, rays, first);
      std::fill_n(q.hit.geomID, N, RTC_INVALID_GEOMETRY_ID);
      std::fill_n(q.hit.instID[0], N, RTC_INVALID_GEOMETRY_ID);
      Calls<N>::intersect(valid, scene_.get(), &context, &q);
      for (int i = 0; i < count; ++i) {
        const bool is_hit = q.hit.geomID[i] != RTC_INVALID_GEOMETRY_ID;
        hits.t[first + i] = is_hit ? q.ray.tfar[i] : 0;
        hits.primitive[first + i] =
            is_hit ? number(q.hit.instID[0][i], q.hit.primID[i]) : core::kNoPrimitive;
      }
    }
  }

  template <int N>
  void occluded(RTCIntersectContext& context, const RayBlock& rays, BlockHits& hits) {
    alignas(64) int valid[N];
    typename Calls<N>::Ray q;
    for (int first = 0; first < rays.count; first += N) {
      const int count = set_rays<N>(q, valid, rays, first);
      Calls<N>::occluded(valid, scene_.get(), &context, &q);
      for (int i = 0; i < count; ++i) store_any(q.tfar[i], hits, first + i);
    }
  }

  void intersect_stream(RTCIntersectContext& context, const RayBlock& rays, BlockHits& hits) {
    RTCRayHit* const queries = queries_of_thread();
    for (int i = 0; i < rays.count; ++i) {
      set_ray(queries[i].ray, rays, i);
      queries[i].hit.geomID = queries[i].hit.instID[0] = RTC_INVALID_GEOMETRY_ID;
    }
    rtcIntersect1M(scene_.get(), &context, queries, static_cast<unsigned>(rays.count),
                   sizeof(RTCRayHit));
    for (int i = 0; i < rays.count; ++i) store(queries[i], hits, i);
  }

  void occluded_stream(RTCIntersectContext& context, const RayBlock& rays, BlockHits& hits) {
    RTCRayHit* const queries = queries_of_thread();
    for (int i = 0; i < rays.count; ++i) set_ray(queries[i].ray, rays, i);
    rtcOccluded1M(scene_.get(), &context, &queries[0].ray, static_cast<unsigned>(rays.count),
                  sizeof(RTCRayHit));
    for (int i = 0; i < rays.count; ++i) store_any(queries[i].ray.tfar, hits, i);
  }

  std::int64_t bytes_ = 0;
  std::unique_ptr<RTCDeviceTy, Release> device_;
  std::vector<std::unique_ptr<RTCSceneTy, Release>> parts_;  // by mesh, where there are instances
  std::unique_ptr<RTCSceneTy, Release> scene_;
  std::vector<std::uint32_t> first_;  // by instance: the number of its first triangle
};

// A scene of triangles that change from frame to frame.
class EmbreeChanging {
 public:
  EmbreeChanging(const core::TriangleStore& triangles, Isa isa, RTCBuildQuality quality) {
    device_.reset(rtcNewDevice(config_of(isa, 1).c_str()));
    rtcSetDeviceMemoryMonitorFunction(device_.get(), count_bytes, &bytes_);
    scene_.reset(rtcNewScene(device_.get()));
    rtcSetSceneFlags(scene_.get(), RTC_SCENE_FLAG_DYNAMIC);
    rtcSetSceneBuildQuality(scene_.get(), RTC_BUILD_QUALITY_LOW);
    RTCGeometry geometry = rtcNewGeometry(device_.get(), RTC_GEOMETRY_TYPE_TRIANGLE);
    rtcSetGeometryBuildQuality(geometry, quality);
    vertices_ = set_triangles(geometry, triangles);
    rtcAttachGeometryByID(scene_.get(), geometry, 0);
    rtcReleaseGeometry(geometry);
  }

  void move(const core::TriangleStore& triangles) {
    std::copy(triangles.vertices.begin(), triangles.vertices.end(), vertices_);
    rtcUpdateGeometryBuffer(rtcGetGeometry(scene_.get(), 0), RTC_BUFFER_TYPE_VERTEX, 0);
  }

  Build commit(const std::string& name) {
    const double start = process_cpu_seconds(), start_wall = wall_seconds();
    rtcCommitGeometry(rtcGetGeometry(scene_.get(), 0));
    rtcCommitScene(scene_.get());
    return {name, process_cpu_seconds() - start, wall_seconds() - start_wall,
            1e-6 * static_cast<double>(bytes_)};
  }

 private:
  std::int64_t bytes_ = 0;
  std::unique_ptr<RTCDeviceTy, Release> device_;
  std::unique_ptr<RTCSceneTy, Release> scene_;
  float* vertices_ = nullptr;  // the scene's own
};

}  // namespace

std::unique_ptr<Entrants> make_embree(const core::TriangleStore& triangles, Isa isa,
                                      const EmbreeMode& mode) {
  return std::make_unique<Embree>(triangles, isa, mode, 1);
}

std::unique_ptr<Entrants> make_embree_instanced(const Scene& scene, Isa isa) {
  return std::make_unique<Embree>(scene, isa);
}

Build build_embree(const core::TriangleStore& triangles, Isa isa, const EmbreeMode& mode,
                   int threads) {
  return Embree(triangles, isa, mode, threads).builds[0];
}

Build build_embree_low(const core::TriangleStore& triangles, Isa isa) {
  return EmbreeChanging(triangles, isa, RTC_BUILD_QUALITY_LOW).commit("embree low");
}

Build refit_embree(const core::TriangleStore& before, const core::TriangleStore& after, Isa isa) {
  EmbreeChanging scene(before, isa, RTC_BUILD_QUALITY_REFIT);
  scene.commit("");
  scene.move(after);
  return scene.commit("embree refit");
}

bool has_embree() { return true; }

}  // namespace tessera::bench
