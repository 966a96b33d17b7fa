#include "slave/core/accel/spatial_index.h"

#include <utility>

#include "slave/core/accel/bvh_builder.h"
#include "slave/core/primitive/triangle/triangle_clipper.h"

namespace tessera::core {
namespace {

template <int W>
Result<SpatialIndex> build(std::span<const Bounds3f> boxes, std::span<const float> vertices,
                           Structure structure, const BuildControl& control) {
  if (structure == Structure::kKd || structure == Structure::kKdQuality) {
    const TriangleClipper clipper(vertices);
    const bool is_quality = structure == Structure::kKdQuality;
    Result<KdIndex<W>> kd = build_kd_index<W>(
        boxes, vertices, control, is_quality ? quality_build(clipper) : KdBuildConfig{});
    if (!kd.is_ok()) return kd.status();
    return SpatialIndex{std::move(*kd)};
  }
  Result<Bvh<W>> bvh = build_bvh<W>(boxes, vertices, control);
  if (!bvh.is_ok()) return bvh.status();
  return SpatialIndex{std::move(*bvh)};
}

}  // namespace

Result<SpatialIndex> build_spatial_index(std::span<const Bounds3f> boxes,
                                         std::span<const float> vertices, Structure structure,
                                         int lanes, const BuildControl& control) {
  return lanes >= 16 ? build<16>(boxes, vertices, structure, control)
                     : build<8>(boxes, vertices, structure, control);
}

}  // namespace tessera::core
