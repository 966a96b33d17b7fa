// Camera rays of 8x8 pixels as a fan, and where the fans of a larger part of the picture begin.
//
// Threads. One object per thread.
#pragma once

#include "common/frame/frame_settings.h"
#include "common/frame/tile_grid.h"
#include "slave/core/render/camera_rays.h"
#include "slave/core/trace/scene_tracer.h"

namespace tessera::core {

inline constexpr int kPacketEdgePx = 8;
static_assert(kPacketEdgePx * kPacketEdgePx == kPacketRays);

// Where a ray stands in its packet: runs of 4, 8, 16 rays are 2x2, 4x2, 4x4 pixels.
constexpr int column_of(int ray) { return (ray & 1) | (ray >> 1 & 2) | (ray >> 2 & 4); }
constexpr int row_of(int ray) { return (ray >> 1 & 1) | (ray >> 2 & 2) | (ray >> 3 & 4); }

class CameraPacket {
 public:
  FanPacket rays;

  void begin(const FrameSettings& settings, const CameraRays& camera);
  // Finds where the packets of a part of the picture begin, all samples of them. One of 32 x 32
  // pixels has measured best.
  void enter(const SceneTracer& tracer, const TileRect& part);
  // Rays through the pixels of the 8x8 block at (x, y) that lie in the part.
  void set(const TileRect& part, int x_px, int y_px, std::uint32_t sample);

 private:
  const FrameSettings* settings_ = nullptr;
  const CameraRays* camera_ = nullptr;
  FanEntry entry_;
};

// Number of a pixel's sample in its sequence: passes go on where the one before has ended.
inline std::uint32_t sequence_index(const FrameSettings& settings, std::uint32_t sample) {
  return settings.pass * static_cast<std::uint32_t>(settings.samples_per_pixel) + sample;
}

}  // namespace tessera::core
