// SPDX-License-Identifier: Apache-2.0
// Figures that say how far two pictures are apart.
#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "master/image/flip.h"
#include "master/image/image_error.h"
#include "master/image/pass_mean.h"

namespace tessera::master {
namespace {

using Pixels = std::vector<float>;
constexpr int kEdge = 48;
constexpr std::size_t kFloats = 3 * kEdge * kEdge;

TEST(ImageError, OfAPictureToItselfIsNothing) {
  Pixels picture(kFloats);
  for (std::size_t i = 0; i < kFloats; ++i) picture[i] = static_cast<float>(i % 97) / 97;
  const ImageError error = image_error(picture, picture, kEdge, kEdge);
  EXPECT_EQ(error.rmse, 0);
  EXPECT_EQ(error.rel_mse, 0);
  EXPECT_EQ(error.flip, 0);
  EXPECT_NEAR(error.mean_off, 0, 1e-12);
}

TEST(ImageError, OfASteadyDifferenceHasItsClosedForm) {
  const Pixels reference(kFloats, 0.5f), brighter(kFloats, 0.6f);
  const ImageError error = image_error(brighter, reference, kEdge, kEdge);
  EXPECT_NEAR(error.rmse, 0.1, 1e-6);
  EXPECT_NEAR(error.rel_mse, 0.01 / (0.25 * 1.01), 1e-6);
  EXPECT_NEAR(error.mean_off, 0.2, 1e-6);
}

// Black against white is most of the scale and no more than it, and the same either way round.
TEST(Flip, BlackToWhiteIsNearTheEndOfTheScale) {
  const Pixels black(kFloats, 0.0f), white(kFloats, 1.0f);
  const std::vector<float> there = flip_map(white, black, kEdge, kEdge);
  const std::vector<float> back = flip_map(black, white, kEdge, kEdge);
  for (std::size_t i = 0; i < there.size(); ++i) {
    EXPECT_GT(there[i], 0.9f);
    EXPECT_LE(there[i], 1.0f);
    EXPECT_NEAR(there[i], back[i], 1e-6f);
  }
}

TEST(Flip, PureGreenToPureBlueIsTheScalesEnd) {
  Pixels green(kFloats, 0.0f), blue(kFloats, 0.0f);
  for (std::size_t i = 0; i < kFloats; i += 3) green[i + 1] = blue[i + 2] = 1;
  for (const float x : flip_map(green, blue, kEdge, kEdge)) EXPECT_NEAR(x, 1, 1e-3f);
}

// Fine noise is seen less than the same difference over an area.
TEST(Flip, WeighsWhatAPersonSees) {
  const Pixels grey(kFloats, 0.5f);
  Pixels noise = grey, patch = grey;
  for (std::size_t y = 0; y < kEdge; ++y) {
    for (std::size_t x = 0; x < kEdge; ++x) {
      for (std::size_t c = 0; c < 3; ++c) {
        noise[3 * (kEdge * y + x) + c] += (x + y) % 2 == 0 ? 0.1f : -0.1f;
        patch[3 * (kEdge * y + x) + c] += y < kEdge / 2 ? 0.1f : -0.1f;
      }
    }
  }
  const auto flip = [&](const Pixels& p) { return image_error(p, grey, kEdge, kEdge).flip; };
  EXPECT_GT(flip(noise), 0);
  EXPECT_LT(flip(noise), 0.8 * flip(patch));
}

TEST(PassMean, IsTheMeanOfItsPictures) {
  PassMean mean;
  FrameImage image;
  image.width_px = image.height_px = 2;
  for (const float value : {1.0f, 2.0f, 6.0f}) {
    const Pixels pixels(12, value);
    image.bytes.resize(48);
    encode_pixels(pixels, image.format, image.bytes);
    mean.add(image);
  }
  EXPECT_EQ(mean.count(), 3);
  for (const float x : mean.mean()) EXPECT_EQ(x, 3.0f);
  mean.reset();
  mean.add(image);
  for (const float x : mean.mean()) EXPECT_EQ(x, 6.0f);
}

TEST(PassMean, PlanesAreMergedAsTheirRowsSay) {
  PassMean mean;
  FrameImage image;
  image.width_px = 3;
  image.height_px = 1;
  image.planes = {Plane::kAlpha, Plane::kObject, Plane::kSamples};
  image.bytes.resize(3 * image.layout().pixel_bytes());
  const auto add = [&](Pixels alpha, Pixels object, Pixels samples) {
    encode_pixels(Pixels(9, 1.0f), image.format, std::span(image.bytes).first(36));
    std::byte* at = image.bytes.data() + 36;
    for (const Pixels& plane : {alpha, object, samples})
      at = std::copy_n(reinterpret_cast<const std::byte*>(plane.data()), 12, at);
    mean.add(image);
  };
  add({0, 1, 0.5f}, {0, 7, 8}, {4, 4, 4});
  add({1, 1, 0}, {5, 6, 0}, {4, 4, 4});
  const FrameImage merged = mean.image();
  EXPECT_EQ(merged.plane_values(Plane::kAlpha), (std::vector<float>{0.5f, 1, 0.25f}));
  EXPECT_EQ(merged.plane_values(Plane::kObject), (std::vector<float>{0, 7, 8})) << "of the first";
  EXPECT_EQ(merged.plane_values(Plane::kSamples), (std::vector<float>{8, 8, 8})) << "of both";
  image.planes = {};
  image.bytes.resize(36);
  mean.add(image);
  EXPECT_EQ(mean.count(), 1) << "another set of planes begins anew";
  EXPECT_EQ(mean.image().bytes.size(), 36u);
}

}  // namespace
}  // namespace tessera::master
