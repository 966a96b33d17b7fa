// SPDX-License-Identifier: Apache-2.0
#include "slave/core/integrate/igi/gi_block.h"

#include <algorithm>
#include <limits>

namespace tessera::core {
namespace {

constexpr float kNowhere =
    std::numeric_limits<float>::quiet_NaN();  // distance of pixels without surface

}  // namespace

void GiBlock::cover(const TileRect& block, const TileRect& region, int interleave) {
  block_ = block;
  region_ = region;
  const int edge = (kFilterEdgeMax + interleave - 1) / interleave;
  batches_per_set_ = (edge * edge + kGatherMax - 1) / kGatherMax;
  used_ = static_cast<std::size_t>(interleave * interleave * batches_per_set_);
  while (batches_.size() < used_) batches_.push_back(std::make_unique<Batch>());
  for (int x = 0; x < region.width_px; ++x)
    column_batch_[x] = (region.x_px + x) % interleave * batches_per_set_;
  for (int y = 0; y < region.height_px; ++y)
    row_batch_[y] = (region.y_px + y) % interleave * interleave * batches_per_set_;
  for (auto& plane : planes_.sum) std::fill(std::begin(plane), std::end(plane), 0.0f);
}

void GiBlock::clear() {
  for (const auto& batch : batches()) batch->points.count = 0;
  // The whole plane is filled, border included, and what the filter's registers read behind the
  // last pixel.
  std::fill(std::begin(planes_.distance), std::end(planes_.distance), kNowhere);
}

void GiBlock::add_reflected(const KernelTable& kernels, int radius) {
  for (const auto& batch : batches()) {
    const GatherPoints& points = batch->points;
    for (int c = 0; c < 3; ++c) {
      for (int i = 0; i < points.count; ++i) planes_.light[c][batch->pixel[i]] = points.light[c][i];
    }
  }
  kernels.filter(planes_, radius, block_.x_px - region_.x_px, block_.y_px - region_.y_px,
                 block_.width_px, block_.height_px);
}

void GiBlock::write(const TileRect& tile, float scale, std::span<float> rgb) const {
  for (int y = block_.y_px; y < block_.y_px + block_.height_px; ++y) {
    for (int x = block_.x_px; x < block_.x_px + block_.width_px; ++x) {
      const auto at = 3 * static_cast<std::size_t>((y - tile.y_px) * tile.width_px + x - tile.x_px);
      for (std::size_t c = 0; c < 3; ++c) rgb[at + c] = planes_.sum[c][index(x, y)] * scale;
    }
  }
}

}  // namespace tessera::core
