// SPDX-License-Identifier: Apache-2.0
// Everything that decides the bits of a frame, next to the scene version and the instruction set.
// Threads. Plain values. Settings that came from outside pass validate_frame_settings() once, at
// the border, and are trusted behind it.
#pragma once

#include <cstdint>
#include <string_view>

#include "common/base/isa.h"
#include "common/base/status.h"
#include "common/frame/patch_method.h"
#include "common/frame/picture_plane.h"
#include "common/frame/tone_curve.h"
#include "common/scene/camera.h"

namespace tessera {

// Values travel on the wire.
enum class Renderer : std::uint8_t {
  kPrimary = 0,  // distance along the normalised ray as linear grey, miss 0
  kDirect = 1,   // lights and shadows
  kPath = 2,     // light over any number of surfaces, without bias: the reference
  kIgi = 3,      // instant global illumination: the light of VPLs, made anew for each frame
};

enum class PixelFormat : std::uint8_t {
  kFloat = 0,     // 3 x float32, linear
  kHalf = 1,      // 3 x float16, linear, rounded to nearest even
  kDisplay8 = 2,  // 3 x uint8: FrameSettings::display, then sRGB-encoded
};

int bytes_per_pixel(PixelFormat format);  // 12, 6, 3
std::string_view renderer_name(Renderer renderer);
std::string_view pixel_format_name(PixelFormat format);
Result<Renderer> parse_renderer(std::string_view text);
Result<PixelFormat> parse_pixel_format(std::string_view text);

// Automatic bound of a VPL's geometry term: 8 over the square of the scene's diagonal, so that VPLs
// within about a third of the diagonal are clamped. Of the factors 256, 64, 16, 4 and 1, with bias
// compensation, 16 has the least error for its time on the Cornell box, and 1 on a room under a
// sky, where 4 is as good (slave/core/README.md).
inline constexpr float kClampAuto = -1;

struct FrameSettings {
  int width_px = 640;   // in [1, kImageSideMaxPx]
  int height_px = 480;  // in [1, kImageSideMaxPx]
  Camera camera;
  Renderer renderer = Renderer::kDirect;
  PixelFormat pixel_format = PixelFormat::kFloat;
  // In [kTileEdgeMinPx, kTileEdgeMaxPx], or kTileEdgeAuto until a master takes up the frame.
  int tile_edge_px = 32;
  int samples_per_pixel = 1;  // in [1, kSamplesPerPixelMax]
  int light_samples = 4;      // per area light, in [1, kLightSamplesMax]
  // path, igi: surfaces after the first that light may meet, in [0, kBouncesMax]
  int bounces = 4;
  int vpls = 64;            // igi: VPLs that a pixel gathers from, in [1, kVplsMax]
  int interleave = 3;       // igi: edge of the interleaving pattern, pixels: 1, 3 or 5
  bool is_filtered = true;  // igi: pixels take the mean over the sets where they show one surface
  float clamp = 0;          // igi: bound of a VPL's geometry term, 1 / area; 0: none; or kClampAuto
  bool is_compensated = false;  // igi: bias compensation traces what the bound cuts off
  // Number of the pass of a picture that is the mean of several, in [0, kPassesMax). Each pass
  // makes other random choices.
  std::uint32_t pass = 0;
  std::uint32_t seed = 0;
  PatchMethod patch_method = PatchMethod::kAuto;  // scenes without patches: of no effect
  double time_seconds = 0;  // of the scene's animation, in [0, kFrameTimeMaxSeconds]
  // Planes besides colour. picture_plane.h says what they are, kFrameBytesMax how many fit.
  PlaneSet planes;
  // How the picture is shown. Only display8 pixels depend on this; the other formats stay linear.
  DisplayTransform display;
  bool operator==(const FrameSettings&) const = default;
};

// Edge, a multiple of 8, of the largest tile whose pixels fit into kTilePayloadBytesMax, planes
// included.
int tile_edge_max_px(const FrameSettings& settings);

// Checks that the planes exist and fit into a frame of this size and into its tiles. Returns: as
// validate_frame_settings().
Status validate_planes(const FrameSettings& settings);
// Returns: kInvalidArgument naming the field and its range. Also checks the camera.
Status validate_frame_settings(const FrameSettings& settings);

}  // namespace tessera
