// SPDX-License-Identifier: Apache-2.0
// A block of pixels with its border, rendered one sample of each pixel at a time: what the pixels
// show, and the points that gather light for them. A batch holds points with the same place in the
// K x K pattern.
//
// Threads. One object per thread; scratch memory, about a megabyte.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "common/frame/tile_border.h"
#include "common/frame/tile_grid.h"
#include "common/math/vec3.h"
#include "slave/core/kernels/kernel_table.h"

namespace tessera::core {

inline constexpr int kGiBlockEdgePx = kBorderBlockPx;
static_assert(kFilterEdgeMax == kGiBlockEdgePx + 2 * kFilterRadiusMax);

// The surface that a pixel shows, as a point that gathers light.
struct GiPoint {
  Vec3f point, normal, shading_normal;
  Vec3f albedo;        // times the path's weight
  float offset = 0;    // see surface_offset.h
  float distance = 0;  // from the eye
  std::int32_t material = 0;
  std::uint32_t key = 0;                   // pixel_key()
  std::uint32_t primitive = kNoPrimitive;  // see Surface::sound_primitive
  float horizon = kPlaneHorizon;
};

class GiBlock {
 public:
  struct Batch {
    GatherPoints points;
    std::uint16_t pixel[kGatherRoom];  // by point
  };

  // Begins a block, with no light in any pixel. Requires: region is block with its border, at most
  // kFilterEdgeMax wide and high.
  void cover(const TileRect& block, const TileRect& region, int interleave);
  // Forgets the points. Must be called before the next sample.
  void clear();

  // (x_px, y_px), here and below: a pixel of the picture, in the region.
  void add_light(int x_px, int y_px, Vec3f radiance) {
    const int at = index(x_px, y_px);
    for (int c = 0; c < 3; ++c) planes_.sum[c][at] += radiance[c];
  }
  // Requires: clear() was called, and no point was added for this pixel since.
  void add_point(int x_px, int y_px, const GiPoint& p) {
    const int at = index(x_px, y_px);
    int number = row_batch_[y_px - region_.y_px] + column_batch_[x_px - region_.x_px];
    while (batches_[static_cast<std::size_t>(number)]->points.count == kGatherMax) ++number;
    Batch& batch = *batches_[static_cast<std::size_t>(number)];
    GatherPoints& points = batch.points;
    const int i = points.count++;
    batch.pixel[i] = static_cast<std::uint16_t>(at);
    for (int c = 0; c < 3; ++c) {
      points.point[c][i] = planes_.point[c][at] = p.point[c];
      points.normal[c][i] = p.normal[c];
      points.shading[c][i] = planes_.normal[c][at] = p.shading_normal[c];
      planes_.albedo[c][at] = p.albedo[c];
    }
    points.offset[i] = p.offset;
    points.key[i] = p.key;
    points.primitive[i] = p.primitive;
    points.horizon[i] = p.horizon;
    planes_.distance[at] = p.distance;
    planes_.material[at] = p.material;
  }

  // All batches. Those of set number s are the batches_per_set() from s * batches_per_set() on.
  std::span<const std::unique_ptr<Batch>> batches() const { return {batches_.data(), used_}; }
  int batches_per_set() const { return batches_per_set_; }

  // Adds what the points reflect of their light to the block's pixels; each takes the mean of the
  // neighbours up to `radius` away that show the same surface.
  void add_reflected(const KernelTable& kernels, int radius);

  // Writes the block's pixels. rgb: the tile that the block is a part of. Shape:
  // [height][width][3].
  void write(const TileRect& tile, float scale, std::span<float> rgb) const;

 private:
  static_assert(kFilterPixels <= 65536);  // Batch::pixel

  int index(int x_px, int y_px) const {
    return filter_index(x_px - region_.x_px, y_px - region_.y_px);
  }

  TileRect block_, region_;
  FilterPlanes planes_;
  std::vector<std::unique_ptr<Batch>> batches_;
  std::size_t used_ = 0;
  int batches_per_set_ = 0;
  // Number of a pixel's first batch: the sum of its column's and its row's.
  int column_batch_[kFilterEdgeMax], row_batch_[kFilterEdgeMax];
};

}  // namespace tessera::core
