#include "slave/core/render/camera_packet.h"

#include <algorithm>
#include <limits>
#include <optional>

#include "slave/core/render/sample_dimensions.h"
#include "slave/core/sampling/sample_sequence.h"
#include "slave/core/trace/fan_window.h"

namespace tessera::core {

void CameraPacket::begin(const FrameSettings& settings, const CameraRays& camera) {
  settings_ = &settings;
  camera_ = &camera;
  for (int a = 0; a < 3; ++a) rays.origin[a] = camera.origin()[a];
  rays.t_min = 0;
  std::fill_n(rays.t_max, kPacketRays, std::numeric_limits<float>::infinity());
}

void CameraPacket::enter(const SceneTracer& tracer, const TileRect& part) {
  rays.entry = nullptr;
  const double left = part.x_px, right = left + part.width_px;
  const double top = part.y_px, bottom = top + part.height_px;
  const Vec3f corners[] = {camera_->direction(left, top), camera_->direction(right, top),
                           camera_->direction(left, bottom), camera_->direction(right, bottom)};
  const std::optional<FanWindow> window = fan_window(camera_->origin(), corners);
  if (!window) return;
  tracer.enter(*window, entry_);
  rays.entry = &entry_;
}

void CameraPacket::set(const TileRect& part, int x_px, int y_px, std::uint32_t sample) {
  const bool is_centre = settings_->samples_per_pixel == 1 && settings_->pass == 0;
  const SequencePoint point(sequence_index(*settings_, sample));
  rays.active = 0;
  for (int i = 0; i < kPacketRays; ++i) {
    const int x = x_px + column_of(i), y = y_px + row_of(i);
    if (x >= part.x_px + part.width_px || y >= part.y_px + part.height_px) continue;
    const Vec2f at = is_centre ? Vec2f{0.5f, 0.5f}
                               : point.scrambled(pixel_key(settings_->seed, x, y, kDimensionLens));
    const Vec3f direction = camera_->direction(double{at.x} + x, double{at.y} + y);
    for (int a = 0; a < 3; ++a) rays.direction[a][i] = direction[a];
    rays.active |= std::uint64_t{1} << i;
  }
}

}  // namespace tessera::core
