// SPDX-License-Identifier: Apache-2.0
// Embree 3 (https://www.embree.org) as a contender, held to the same instruction set as ours.
#include <algorithm>
#include <cstring>
#include <vector>

#include "slave/core/ray/packet_layout.h"
#include "tests/bench/contender.h"
#include "tests/bench/embree_scene.h"

namespace tessera::bench {
namespace {

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

class Embree final : public Entrants {
 public:
  Embree(const core::TriangleStore& triangles, Isa isa, const EmbreeMode& mode, int threads) {
    open(isa, threads);
    const std::string name = std::string("embree") + (mode.is_high ? " high" : " medium") +
                             (mode.is_robust ? " robust" : "");
    build(triangles, mode, name);
    for (int kind = 0; kind < kRayKinds; ++kind) enter(static_cast<RayKind>(kind), name, mode);
  }

  // Makes a subdivision surface of the patches.
  Embree(const SplinePatches& patches, int cells, Isa isa) : cells_(static_cast<unsigned>(cells)) {
    open(isa, 1);
    build(patches);
    for (int kind = 0; kind < kRayKinds; ++kind)
      enter(static_cast<RayKind>(kind), "embree subdivision", {});
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

  // A face amid eight others is a regular one: its limit surface is the uniform bicubic B-spline
  // patch of the 16 corners. The eight, which are at the boundary, are left out.
  void build(const SplinePatches& patches) {
    scene_.reset(rtcNewScene(device_.get()));
    RTCGeometry geometry = rtcNewGeometry(device_.get(), RTC_GEOMETRY_TYPE_SUBDIVISION);
    const std::size_t count = patches.points.size() / 16;
    const auto buffer = [&](RTCBufferType type, RTCFormat format, std::size_t bytes,
                            std::size_t items) {
      return rtcSetNewGeometryBuffer(geometry, type, 0, format, bytes, items);
    };
    auto* const points = static_cast<Vec3f*>(
        buffer(RTC_BUFFER_TYPE_VERTEX, RTC_FORMAT_FLOAT3, 12, patches.points.size()));
    std::copy(patches.points.begin(), patches.points.end(), points);
    auto* corners = static_cast<unsigned*>(
        buffer(RTC_BUFFER_TYPE_INDEX, RTC_FORMAT_UINT, 4, 4 * kFaces * count));
    auto* sides =
        static_cast<unsigned*>(buffer(RTC_BUFFER_TYPE_FACE, RTC_FORMAT_UINT, 4, kFaces * count));
    for (unsigned face = 0; face < kFaces * count; ++face) {
      const unsigned i = face % kFaces / 3, j = face % 3;
      const unsigned first = 16 * (face / kFaces) + 4 * i + j;
      for (const unsigned corner : {first, first + 4, first + 5, first + 1}) *corners++ = corner;
      *sides++ = 4;
    }
    rtcSetGeometrySubdivisionMode(geometry, 0, RTC_SUBDIVISION_MODE_NO_BOUNDARY);
    rtcSetGeometryTessellationRate(geometry, static_cast<float>(cells_));
    commit(geometry, "embree subdivision");
  }

  // Commits the scene of one geometry, which it releases.
  void commit(RTCGeometry geometry, const std::string& name) {
    const std::int64_t before = bytes_;
    const double start = process_cpu_seconds(), start_wall = wall_seconds();
    rtcCommitGeometry(geometry);
    rtcAttachGeometry(scene_.get(), geometry);
    rtcCommitScene(scene_.get());
    const double seconds = process_cpu_seconds() - start, wall = wall_seconds() - start_wall;
    rtcReleaseGeometry(geometry);
    builds.push_back({name, seconds, wall, 1e-6 * static_cast<double>(bytes_ - before)});
  }

  // The number of what was hit; of a subdivision surface that of a triangle of tessellated().
  std::uint32_t number(unsigned instance, unsigned primitive, float u, float v) const {
    if (cells_ == 0) return number(instance, primitive);
    const auto cell = [&](float x) {
      return std::min(static_cast<unsigned>(x * static_cast<float>(cells_)), cells_ - 1);
    };
    return 2 * ((primitive / kFaces * cells_ + cell(u)) * cells_ + cell(v));
  }

  void build(const core::TriangleStore& triangles, const EmbreeMode& mode,
             const std::string& name) {
    scene_.reset(rtcNewScene(device_.get()));
    if (mode.is_high) rtcSetSceneBuildQuality(scene_.get(), RTC_BUILD_QUALITY_HIGH);
    if (mode.is_robust) rtcSetSceneFlags(scene_.get(), RTC_SCENE_FLAG_ROBUST);
    RTCGeometry geometry = rtcNewGeometry(device_.get(), RTC_GEOMETRY_TYPE_TRIANGLE);
    if (mode.is_high) rtcSetGeometryBuildQuality(geometry, RTC_BUILD_QUALITY_HIGH);
    set_triangles(geometry, triangles);
    commit(geometry, name);
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
    hits.primitive[i] =
        is_hit ? number(q.hit.instID[0], q.hit.primID, q.hit.u, q.hit.v) : core::kNoPrimitive;
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
            is_hit ? number(q.hit.instID[0][i], q.hit.primID[i], q.hit.u[i], q.hit.v[i])
                   : core::kNoPrimitive;
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

  static constexpr unsigned kFaces = 9;  // of a patch

  const unsigned cells_ = 0;  // along a side of a patch; 0: no subdivision surface
  std::int64_t bytes_ = 0;
  std::unique_ptr<RTCDeviceTy, ReleaseEmbree> device_;
  std::vector<std::unique_ptr<RTCSceneTy, ReleaseEmbree>>
      parts_;  // by mesh, where there are instances
  std::unique_ptr<RTCSceneTy, ReleaseEmbree> scene_;
  std::vector<std::uint32_t> first_;  // by instance: the number of its first triangle
};

}  // namespace

std::unique_ptr<Entrants> make_embree(const core::TriangleStore& triangles, Isa isa,
                                      const EmbreeMode& mode) {
  return std::make_unique<Embree>(triangles, isa, mode, 1);
}

std::unique_ptr<Entrants> make_embree_subdivided(const SplinePatches& patches, int cells, Isa isa) {
  return std::make_unique<Embree>(patches, cells, isa);
}

std::unique_ptr<Entrants> make_embree_instanced(const Scene& scene, Isa isa) {
  return std::make_unique<Embree>(scene, isa);
}

Build build_embree(const core::TriangleStore& triangles, Isa isa, const EmbreeMode& mode,
                   int threads) {
  return Embree(triangles, isa, mode, threads).builds[0];
}

bool has_embree() { return true; }

}  // namespace tessera::bench
