// SPDX-License-Identifier: Apache-2.0
#include "common/frame/frame_image.h"

#include <bit>
#include <cmath>
#include <cstring>

namespace tessera {
namespace {

// IEEE 754 binary16, rounded to nearest even; too large becomes infinity, NaN stays NaN.
std::uint16_t half_from_float(float value) {
  const std::uint32_t bits = std::bit_cast<std::uint32_t>(value);
  const std::uint16_t sign = static_cast<std::uint16_t>(bits >> 16 & 0x8000u);
  const std::uint32_t magnitude = bits & 0x7fffffffu;
  if (magnitude > 0x7f800000u) return static_cast<std::uint16_t>(sign | 0x7e00u);
  if (magnitude >= 0x47800000u)
    return static_cast<std::uint16_t>(sign | 0x7c00u);  // >= 65536, infinity
  if (magnitude <
      0x38800000u) {  // below 2^-14: a multiple of 2^-24, by one exact scaling and one rounding
    const float scaled = std::bit_cast<float>(magnitude) * 16777216.0f;
    return static_cast<std::uint16_t>(sign | static_cast<std::uint32_t>(std::nearbyint(scaled)));
  }
  const std::uint32_t rounded = magnitude + 0xfffu + (magnitude >> 13 & 1u);
  return static_cast<std::uint16_t>(sign | ((rounded - 0x38000000u) >> 13));
}

float float_from_half(std::uint16_t half) {
  const std::uint32_t sign = static_cast<std::uint32_t>(half & 0x8000u) << 16;
  const std::uint32_t exponent = half >> 10 & 31u;
  const std::uint32_t fraction = half & 0x3ffu;
  if (exponent == 0) {
    const float magnitude = static_cast<float>(fraction) * 0x1p-24f;
    return sign != 0 ? -magnitude : magnitude;
  }
  const std::uint32_t magnitude =
      exponent == 31 ? 0x7f800000u | fraction << 13 : (exponent + 112) << 23 | fraction << 13;
  return std::bit_cast<float>(sign | magnitude);
}

std::byte display_from_linear(float linear) {
  return static_cast<std::byte>(static_cast<std::uint8_t>(255 * srgb_encode(linear) + 0.5f));
}

void encode_displayed(std::span<const float> rgb, const DisplayTransform& display,
                      std::span<std::byte> out) {
  for (std::size_t i = 0; i + 2 < rgb.size(); i += 3) {
    const Vec3f light = displayed({rgb[i], rgb[i + 1], rgb[i + 2]}, display);
    out[i] = display_from_linear(light.x);
    out[i + 1] = display_from_linear(light.y);
    out[i + 2] = display_from_linear(light.z);
  }
}

}  // namespace

std::vector<float> FrameImage::plane_values(Plane plane) const {
  TESSERA_CHECK(planes.has(plane));
  std::vector<float> values(pixel_count() * plane_row(plane).channel_count());
  layout().for_each_plane([&](Plane one, std::size_t before_bytes, std::size_t) {
    if (one == plane)
      std::memcpy(values.data(), bytes.data() + pixel_count() * before_bytes,
                  values.size() * sizeof(float));
  });
  return values;
}

// IEC 61966-2-1.
float srgb_encode(float linear) {
  if (!(linear > 0)) return 0;  // NaN as well
  if (linear >= 1) return 1;
  return linear <= 0.0031308f ? 12.92f * linear : 1.055f * std::pow(linear, 1 / 2.4f) - 0.055f;
}

float srgb_decode(float encoded) {
  if (!(encoded > 0)) return 0;
  if (encoded >= 1) return 1;
  return encoded <= 0.04045f ? encoded / 12.92f : std::pow((encoded + 0.055f) / 1.055f, 2.4f);
}

void encode_pixels(std::span<const float> rgb, PixelFormat format, std::span<std::byte> out,
                   const DisplayTransform& display) {
  TESSERA_CHECK_EQ(rgb.size() * static_cast<std::size_t>(bytes_per_pixel(format)), 3 * out.size());
  switch (format) {
    case PixelFormat::kFloat:
      std::memcpy(out.data(), rgb.data(), out.size());
      return;
    case PixelFormat::kHalf:
      for (std::size_t i = 0; i < rgb.size(); ++i) {
        const std::uint16_t half = half_from_float(rgb[i]);
        std::memcpy(out.data() + 2 * i, &half, 2);
      }
      return;
    case PixelFormat::kDisplay8:
      if (!display.is_plain()) return encode_displayed(rgb, display, out);
      for (std::size_t i = 0; i < rgb.size(); ++i) out[i] = display_from_linear(rgb[i]);
      return;
  }
}

void decode_pixels(std::span<const std::byte> bytes, PixelFormat format, std::span<float> rgb) {
  TESSERA_CHECK_EQ(rgb.size() * static_cast<std::size_t>(bytes_per_pixel(format)),
                   3 * bytes.size());
  switch (format) {
    case PixelFormat::kFloat:
      std::memcpy(rgb.data(), bytes.data(), bytes.size());
      return;
    case PixelFormat::kHalf:
      for (std::size_t i = 0; i < rgb.size(); ++i) {
        std::uint16_t half = 0;
        std::memcpy(&half, bytes.data() + 2 * i, 2);
        rgb[i] = float_from_half(half);
      }
      return;
    case PixelFormat::kDisplay8:
      for (std::size_t i = 0; i < rgb.size(); ++i)
        rgb[i] = srgb_decode(static_cast<float>(bytes[i]) / 255);
      return;
  }
}

}  // namespace tessera
