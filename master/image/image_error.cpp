// SPDX-License-Identifier: Apache-2.0
#include "master/image/image_error.h"

#include <cmath>

#include "common/base/check.h"
#include "master/image/flip.h"

namespace tessera::master {

ImageError image_error(std::span<const float> image, std::span<const float> reference, int width_px,
                       int height_px) {
  const std::size_t count = 3 * static_cast<std::size_t>(width_px * height_px);
  TESSERA_CHECK_EQ(image.size(), count);
  TESSERA_CHECK_EQ(reference.size(), count);
  const auto n = static_cast<double>(count);
  double mean = 0, wanted = 0;
  for (std::size_t i = 0; i < count; ++i) {
    mean += static_cast<double>(image[i]) / n;
    wanted += static_cast<double>(reference[i]) / n;
  }
  ImageError error;
  const double floor = 0.01 * wanted * wanted;
  for (std::size_t i = 0; i < count; ++i) {
    const double a = static_cast<double>(image[i]), b = static_cast<double>(reference[i]);
    const double square = (a - b) * (a - b);
    error.rmse += square / n;
    if (square > 0) error.rel_mse += square / (b * b + floor) / n;
  }
  error.rmse = std::sqrt(error.rmse);
  error.mean_off = wanted > 0 ? mean / wanted - 1 : mean > 0 ? INFINITY : 0;
  double sum = 0;
  const std::vector<float> map = flip_map(image, reference, width_px, height_px);
  for (const float x : map) sum += static_cast<double>(x);
  error.flip = sum / static_cast<double>(map.size());
  return error;
}

}  // namespace tessera::master
