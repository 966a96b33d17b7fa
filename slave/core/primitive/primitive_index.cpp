// SPDX-License-Identifier: Apache-2.0
#include "slave/core/primitive/primitive_index.h"

#include <utility>

#include "slave/core/accel/bvh_fast_builder.h"
#include "slave/core/primitive/triangle/triangle_clipper.h"
#include "slave/core/primitive/triangle/triangle_fitter.h"
#include "slave/core/primitive/triangle/triangle_writer.h"

namespace tessera::core {
namespace {

template <int W>
Result<PrimitiveIndex> build(std::span<const Bounds3f> boxes, std::span<const float> vertices,
                             Structure structure, const BuildControl& control) {
  const TriangleClipper clipper(vertices);
  if (structure == Structure::kKd || structure == Structure::kKdQuality) {
    const bool is_quality = structure == Structure::kKdQuality;
    Result<IndexedKd<W>> kd = index_by_kd<W>(boxes, vertices, control,
                                             is_quality ? quality_build(clipper) : KdBuildConfig{});
    if (!kd.is_ok()) return kd.status();
    return PrimitiveIndex{std::move(*kd)};
  }
  const bool is_cut = structure == Structure::kBvhQuality;
  Result<IndexedBvh<W>> bvh = index_by_bvh<W>(
      boxes, vertices, control, is_cut ? spatial_build(clipper) : usual_build(clipper));
  if (!bvh.is_ok()) return bvh.status();
  return PrimitiveIndex{std::move(*bvh)};
}

}  // namespace

template <int W>
Result<IndexedBvh<W>> index_by_bvh(std::span<const Bounds3f> boxes, std::span<const float> vertices,
                                   const BuildControl& control, const BvhBuildConfig& config) {
  TriangleWriter<W> writer(vertices);
  Result<Bvh<W>> bvh = build_bvh<W>({boxes, writer}, control, config);
  if (!bvh.is_ok()) return bvh.status();
  return IndexedBvh<W>{std::move(*bvh), writer.take()};
}

template <int W>
Result<IndexedBvh<W>> index_fast(std::span<const Bounds3f> boxes, std::span<const float> vertices,
                                 const BuildControl& control) {
  TriangleWriter<W> writer(vertices);
  Result<Bvh<W>> bvh = build_bvh_fast<W>({boxes, writer}, control);
  if (!bvh.is_ok()) return bvh.status();
  return IndexedBvh<W>{std::move(*bvh), writer.take()};
}

template <int W>
Result<IndexedBvh<W>> fit_index(const IndexedBvh<W>& built, std::span<const float> vertices,
                                const BuildControl& control) {
  TriangleBlocks<W> triangles = built.triangles;
  const TriangleFitter<W> fitter(vertices, triangles);
  Result<Bvh<W>> bvh = fit_bvh<W>(built.structure, fitter, control);
  if (!bvh.is_ok()) return bvh.status();
  return IndexedBvh<W>{std::move(*bvh), std::move(triangles)};
}

template <int W>
Result<IndexedKd<W>> index_by_kd(std::span<const Bounds3f> boxes, std::span<const float> vertices,
                                 const BuildControl& control, const KdBuildConfig& config) {
  TriangleWriter<W> writer(vertices);
  Result<KdIndex<W>> kd = build_kd_index<W>({boxes, writer}, control, config);
  if (!kd.is_ok()) return kd.status();
  return IndexedKd<W>{std::move(*kd), writer.take()};
}

template Result<IndexedBvh<8>> index_by_bvh<8>(std::span<const Bounds3f>, std::span<const float>,
                                               const BuildControl&, const BvhBuildConfig&);
template Result<IndexedBvh<16>> index_by_bvh<16>(std::span<const Bounds3f>, std::span<const float>,
                                                 const BuildControl&, const BvhBuildConfig&);
template Result<IndexedBvh<8>> index_fast<8>(std::span<const Bounds3f>, std::span<const float>,
                                             const BuildControl&);
template Result<IndexedBvh<16>> index_fast<16>(std::span<const Bounds3f>, std::span<const float>,
                                               const BuildControl&);
template Result<IndexedBvh<8>> fit_index<8>(const IndexedBvh<8>&, std::span<const float>,
                                            const BuildControl&);
template Result<IndexedBvh<16>> fit_index<16>(const IndexedBvh<16>&, std::span<const float>,
                                              const BuildControl&);
template Result<IndexedKd<8>> index_by_kd<8>(std::span<const Bounds3f>, std::span<const float>,
                                             const BuildControl&, const KdBuildConfig&);
template Result<IndexedKd<16>> index_by_kd<16>(std::span<const Bounds3f>, std::span<const float>,
                                               const BuildControl&, const KdBuildConfig&);

Result<PrimitiveIndex> build_primitive_index(std::span<const Bounds3f> boxes,
                                             std::span<const float> vertices, Structure structure,
                                             int lanes, const BuildControl& control) {
  return lanes >= 16 ? build<16>(boxes, vertices, structure, control)
                     : build<8>(boxes, vertices, structure, control);
}

}  // namespace tessera::core
