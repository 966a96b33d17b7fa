// SPDX-License-Identifier: Apache-2.0
#include "common/frame/frame_settings.h"

#include <cmath>
#include <iterator>
#include <string>

#include "common/base/limits.h"
#include "common/base/near_word.h"
#include "common/scene/validate.h"

namespace tessera {
namespace {

constexpr std::string_view kRendererNames[] = {"primary", "direct", "path", "igi"};
constexpr std::string_view kPixelNames[] = {"float", "half", "display8"};

Status check_range(const char* field, int value, int low, int high) {
  if (value >= low && value <= high) return Status::ok();
  return Status::invalid_argument(std::string(field) + " is " + std::to_string(value) +
                                  "; it must be " + std::to_string(low) + " to " +
                                  std::to_string(high));
}

std::uint64_t bytes_with_planes(const FrameSettings& s) {
  return static_cast<std::uint64_t>(bytes_per_pixel(s.pixel_format)) +
         sizeof(float) * channel_count(s.planes);
}

}  // namespace

Status validate_planes(const FrameSettings& s) {
  if (s.planes.is_empty()) return Status::ok();
  if ((s.planes.bits() & ~PlaneSet::all().bits()) != 0)
    return Status::invalid_argument("planes are asked for that there are not");
  const std::uint64_t bytes = static_cast<std::uint64_t>(s.width_px) *
                              static_cast<std::uint64_t>(s.height_px) * bytes_with_planes(s);
  if (bytes > kFrameBytesMax) {
    return Status::invalid_argument("a frame with its planes has " + std::to_string(bytes >> 20) +
                                    " MiB, and " + std::to_string(kFrameBytesMax >> 20) +
                                    " are the most: ask for fewer planes or pixels");
  }
  if (s.tile_edge_px == kTileEdgeAuto) return Status::ok();
  return check_range("tile edge of a frame with these planes", s.tile_edge_px, kTileEdgeMinPx,
                     tile_edge_max_px(s));
}

int bytes_per_pixel(PixelFormat format) {
  return format == PixelFormat::kFloat ? 12 : format == PixelFormat::kHalf ? 6 : 3;
}

std::string_view renderer_name(Renderer renderer) {
  return kRendererNames[static_cast<int>(renderer)];
}
std::string_view pixel_format_name(PixelFormat format) {
  return kPixelNames[static_cast<int>(format)];
}

Result<Renderer> parse_renderer(std::string_view text) {
  for (int i = 0; i < 4; ++i) {
    if (text == kRendererNames[i]) return static_cast<Renderer>(i);
  }
  return Status::invalid_argument(
      "--renderer " + std::string(text) + ": give primary, direct, igi or path" +
      did_you_mean(text, {std::begin(kRendererNames), std::end(kRendererNames)}));
}

Result<PixelFormat> parse_pixel_format(std::string_view text) {
  for (int i = 0; i < 3; ++i) {
    if (text == kPixelNames[i]) return static_cast<PixelFormat>(i);
  }
  return Status::invalid_argument("--pixels " + std::string(text) +
                                  ": give float, half or display8");
}

int tile_edge_max_px(const FrameSettings& s) {
  const std::uint64_t pixels = kTilePayloadBytesMax / bytes_with_planes(s);
  int edge = kTileEdgeMaxPx;
  while (static_cast<std::uint64_t>(edge) * static_cast<std::uint64_t>(edge) > pixels) edge -= 8;
  return edge;
}

Status validate_frame_settings(const FrameSettings& s) {
  TESSERA_RETURN_IF_ERROR(check_range("frame width", s.width_px, 1, kImageSideMaxPx));
  TESSERA_RETURN_IF_ERROR(check_range("frame height", s.height_px, 1, kImageSideMaxPx));
  if (s.tile_edge_px != kTileEdgeAuto) {
    TESSERA_RETURN_IF_ERROR(
        check_range("tile edge", s.tile_edge_px, kTileEdgeMinPx, kTileEdgeMaxPx));
  }
  TESSERA_RETURN_IF_ERROR(
      check_range("samples per pixel", s.samples_per_pixel, 1, kSamplesPerPixelMax));
  TESSERA_RETURN_IF_ERROR(check_range("light samples", s.light_samples, 1, kLightSamplesMax));
  TESSERA_RETURN_IF_ERROR(check_range("bounces", s.bounces, 0, kBouncesMax));
  TESSERA_RETURN_IF_ERROR(check_range("vpls", s.vpls, 1, kVplsMax));
  TESSERA_RETURN_IF_ERROR(
      check_range("pass", static_cast<int>(s.pass), 0, static_cast<int>(kPassesMax) - 1));
  if (!(s.time_seconds >= 0 && s.time_seconds <= kFrameTimeMaxSeconds))
    return Status::invalid_argument("the frame's time must be from 0 to a year");
  if (s.interleave != 1 && s.interleave != 3 && s.interleave != 5)
    return Status::invalid_argument("interleave is " + std::to_string(s.interleave) +
                                    "; it must be 1, 3 or 5");
  if (s.clamp != kClampAuto && (!(s.clamp >= 0) || !std::isfinite(s.clamp)))
    return Status::invalid_argument("clamp must be -1 (automatic), 0 (none) or a positive number");
  if (!(std::fabs(s.display.exposure_ev) <= kExposureEvMax))
    return Status::invalid_argument("exposure must be -64 to 64 stops");
  if (s.display.tone > ToneCurve::kAgx) return Status::invalid_argument("unknown tone curve");
  if (s.patch_method > PatchMethod::kClip)
    return Status::invalid_argument("unknown method for patches");
  TESSERA_RETURN_IF_ERROR(validate_planes(s));
  return validate_camera(s.camera);
}

}  // namespace tessera
