// SPDX-License-Identifier: Apache-2.0
// What Embree takes to build a scene that changes, and to fit it to the next frame.
#include <memory>

#include "tests/bench/contender.h"
#include "tests/bench/embree_scene.h"

namespace tessera::bench {
namespace {

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
  std::unique_ptr<RTCDeviceTy, ReleaseEmbree> device_;
  std::unique_ptr<RTCSceneTy, ReleaseEmbree> scene_;
  float* vertices_ = nullptr;  // the scene's own
};

}  // namespace

Build build_embree_low(const core::TriangleStore& triangles, Isa isa) {
  return EmbreeChanging(triangles, isa, RTC_BUILD_QUALITY_LOW).commit("embree low");
}

Build refit_embree(const core::TriangleStore& before, const core::TriangleStore& after, Isa isa) {
  EmbreeChanging scene(before, isa, RTC_BUILD_QUALITY_REFIT);
  scene.commit("");
  scene.move(after);
  return scene.commit("embree refit");
}

}  // namespace tessera::bench
