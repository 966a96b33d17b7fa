// SPDX-License-Identifier: Apache-2.0
#include "master/commands/picture_attributes.h"

#include <charconv>
#include <cmath>
#include <cstdio>

#include "common/base/version.h"
#include "common/scene_io/camera_file.h"

namespace tessera::master {
namespace {

constexpr const char* kExposure = "tessera:exposure";
constexpr const char* kTone = "tessera:tone";

// The shortest text that reads back as the same number.
std::string text_of(double number) {
  char text[40];
  const auto end = std::to_chars(text, text + sizeof(text), number).ptr;
  return {text, end};
}
std::string text_of(float number) {
  char text[40];
  const auto end = std::to_chars(text, text + sizeof(text), number).ptr;
  return {text, end};
}

std::string clamp_text(float clamp) {
  return clamp == kClampAuto ? "auto" : clamp == 0 ? "off" : text_of(clamp);
}

std::string option_texts(const FrameSettings& s) {
  std::string text = "--renderer " + std::string(renderer_name(s.renderer)) + " --size " +
                     std::to_string(s.width_px) + "x" + std::to_string(s.height_px) + " --aa " +
                     std::to_string(s.samples_per_pixel) + " --light-samples " +
                     std::to_string(s.light_samples) + " --bounces " + std::to_string(s.bounces);
  if (s.patch_method != PatchMethod::kAuto)
    text += " --patch-method " + std::string(patch_method_name(s.patch_method));
  if (s.renderer != Renderer::kIgi) return text;
  return text + " --vpls " + std::to_string(s.vpls) + " --interleave " +
         std::to_string(s.interleave) + " --filter " + (s.is_filtered ? "on" : "off") +
         " --clamp " + clamp_text(s.clamp) + " --compensate " + (s.is_compensated ? "on" : "off");
}

std::string attribute(const FloatImage& image, const char* name) {
  const auto found = image.attributes.find(name);
  return found == image.attributes.end() ? "" : found->second;
}

}  // namespace

std::vector<std::pair<std::string, std::string>> picture_attributes(const std::string& scene,
                                                                    const FrameSettings& settings,
                                                                    int passes,
                                                                    double render_seconds) {
  const std::string exposure = text_of(settings.display.exposure_ev);
  const std::string tone(tone_curve_name(settings.display.tone));
  std::vector<std::pair<std::string, std::string>> all{
      {"Software", std::string("Tessera ") + kBuildId},
      {"tessera:scene", scene},
      {"tessera:camera", camera_text(settings.camera)},
      {"tessera:settings", option_texts(settings)},
      {"tessera:seed", std::to_string(settings.seed)},
      {"tessera:samples", std::to_string(settings.samples_per_pixel * passes)},
      {"tessera:passes", std::to_string(passes)},
      {"tessera:render_seconds", text_of(render_seconds)},
      {kExposure, exposure},
      {kTone, tone}};
  if (settings.time_seconds > 0)
    all.emplace_back("tessera:time_seconds", text_of(settings.time_seconds));
  if (settings.patch_method != PatchMethod::kAuto)
    all.emplace_back("tessera:patch_error", patch_method_error(settings.patch_method));
  return all;
}

std::vector<float> seen_like(const FloatImage& reference, std::span<const float> rgb) {
  std::vector<float> seen(rgb.begin(), rgb.end());
  const std::string exposure = attribute(reference, kExposure), tone = attribute(reference, kTone);
  if (!reference.is_display || exposure.empty() || tone.empty()) return seen;
  const auto curve = parse_tone_curve(tone);
  DisplayTransform display;
  const auto read =
      std::from_chars(exposure.data(), exposure.data() + exposure.size(), display.exposure_ev);
  if (!curve.is_ok() || read.ec != std::errc() ||
      !(std::fabs(display.exposure_ev) <= kExposureEvMax))
    return seen;
  display.tone = *curve;
  for (std::size_t i = 0; i + 2 < seen.size(); i += 3) {
    const Vec3f shown = displayed({seen[i], seen[i + 1], seen[i + 2]}, display);
    for (std::size_t c = 0; c < 3; ++c) seen[i + c] = shown[static_cast<int>(c)];
  }
  return seen;
}

}  // namespace tessera::master
