#include "slave/core/accel/spatial_index.h"

#include <utility>

#include "slave/core/accel/bvh_builder.h"

namespace tessera::core {
namespace {

template <int W>
Result<SpatialIndex> build(std::span<const Bounds3f> boxes, std::span<const float> vertices,
                           bool is_kd, const BuildControl& control) {
  if (is_kd) {
    Result<KdIndex<W>> kd = build_kd_index<W>(boxes, vertices, control);
    if (!kd.is_ok()) return kd.status();
    return SpatialIndex{std::move(*kd)};
  }
  Result<Bvh<W>> bvh = build_bvh<W>(boxes, vertices, control);
  if (!bvh.is_ok()) return bvh.status();
  return SpatialIndex{std::move(*bvh)};
}

}  // namespace

Result<SpatialIndex> build_spatial_index(std::span<const Bounds3f> boxes,
                                         std::span<const float> vertices, bool is_kd, int lanes,
                                         const BuildControl& control) {
  return lanes >= 16 ? build<16>(boxes, vertices, is_kd, control)
                     : build<8>(boxes, vertices, is_kd, control);
}

}  // namespace tessera::core
