// SPDX-License-Identifier: Apache-2.0
#include "slave/core/integrate/camera_packet.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>

#include "slave/core/sampling/dimension.h"
#include "slave/core/sampling/sample_sequence.h"
#include "slave/core/trace/fan_window.h"

namespace tessera::core {
namespace {

constexpr int kShapes = 7;

// A shape with 2^wide pixels in a row. Runs of 4, 8, 16 rays are 2x2, 4x2, 4x4 pixels as far as the
// shape allows: the bits of a ray's number belong to column and row in turns, and then to the
// longer side.
constexpr PacketShape make_shape(int wide) {
  const int high = kShapes - 1 - wide;
  PacketShape shape{};
  shape.width_px = 1 << wide;
  shape.height_px = 1 << high;
  for (int ray = 0; ray < kPacketRays; ++ray) {
    int columns = 0, rows = 0;
    for (int bit = 0; bit < kShapes - 1; ++bit) {
      const bool is_column = columns < wide && (columns <= rows || rows == high);
      const int value = ray >> bit & 1;
      if (is_column) {
        shape.column[ray] |= value << columns++;
      } else {
        shape.row[ray] |= value << rows++;
      }
    }
  }
  return shape;
}

constexpr std::array<PacketShape, kShapes> kPacketShapes{
    make_shape(0), make_shape(1), make_shape(2), make_shape(3),
    make_shape(4), make_shape(5), make_shape(6)};

// The squarest shape whose shorter side is no longer than the part needs.
const PacketShape& shape_for(const TileRect& part) {
  const auto covering = [](int px) {
    int bits = 0;
    while (bits < 3 && (1 << bits) < px) ++bits;
    return bits;
  };
  const int wide = covering(part.width_px), high = covering(part.height_px);
  return kPacketShapes[static_cast<std::size_t>(wide <= high ? wide : kShapes - 1 - high)];
}

}  // namespace

CameraPacket::CameraPacket(const RenderContext& context) : context_(context) {
  for (int a = 0; a < 3; ++a) rays.origin[a] = context.camera.origin()[a];
  rays.t_min = 0;
  std::fill_n(rays.t_max, kPacketRays, std::numeric_limits<float>::infinity());
}

RayCone CameraPacket::cone() const {
  const auto samples = static_cast<float>(context_.settings.samples_per_pixel);
  return {0, context_.camera.pixel_spread() / std::sqrt(samples)};
}

void CameraPacket::enter(const TileRect& part) {
  part_ = part;
  shape_ = shape_for(part);
  rays.entry = nullptr;
  const double left = part.x_px, right = left + part.width_px;
  const double top = part.y_px, bottom = top + part.height_px;
  const Vec3f corners[] = {
      context_.camera.direction(left, top), context_.camera.direction(right, top),
      context_.camera.direction(left, bottom), context_.camera.direction(right, bottom)};
  const std::optional<FanWindow> window = fan_window(context_.camera.origin(), corners);
  if (!window) return;
  context_.tracer.enter(*window, entry_);
  rays.entry = &entry_;
}

void CameraPacket::set(int x_px, int y_px, std::uint32_t sample) {
  const SequencePoint point(sequence_index(context_.settings, sample));
  const PixelSample one{frame_seed(context_.settings.seed),
                        {point.x_bits(), point.y_bits()},
                        dimension(Dimension::kLens),
                        dimension(Dimension::kSurface),
                        context_.settings.samples_per_pixel == 1 && context_.settings.pass == 0};
  const PacketPixels pixels{&shape_, x_px, y_px, part_.x_px + part_.width_px,
                            part_.y_px + part_.height_px};
  context_.kernels().camera_rays(context_.camera.view(), one, pixels, rays, key);
}

}  // namespace tessera::core
