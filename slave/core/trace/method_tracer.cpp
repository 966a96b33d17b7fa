// SPDX-License-Identifier: Apache-2.0
#include "slave/core/trace/method_tracer.h"

#include "slave/core/primitive/freeform/patch_store.h"

namespace tessera::core {

std::optional<MethodTracer> MethodTracer::make(const PrimitiveIndex& index,
                                               const PatchMethodCall& call, Isa isa) {
  const MethodTables tables = method_kernels(isa);
  const auto way = [&]<int W>(const PatchedBvh<W>& bvh,
                              const MethodKernels<MethodView<W>>& kernels) {
    const MethodView<W> view{bvh.structure.nodes.data(),
                             {bvh.blocks.data(), bvh.triangles.data(), bvh.patches->parts.data(),
                              bvh.patches->patches.data(), call},
                             scene_box(bvh.structure.bounds)};
    return MethodTracer(Way<MethodView<W>>{view, kernels});
  };
  const auto placed_way = [&]<int W>(const PlacedBvh<W>& bvh,
                                     const MethodKernels<MethodPlacesView<W>>& kernels) {
    const MethodPlacesView<W> view{
        bvh.structure.nodes.data(), {bvh.kernel_shapes(), call}, scene_box(bvh.structure.bounds)};
    return MethodTracer(Way<MethodPlacesView<W>>{view, kernels});
  };
  if (const auto* const by8 = std::get_if<PatchedBvh<8>>(&index.any)) return way(*by8, tables.by8);
  if (const auto* const by16 = std::get_if<PatchedBvh<16>>(&index.any))
    return way(*by16, tables.by16);
  if (const auto* const by8 = std::get_if<PlacedBvh<8>>(&index.any))
    return placed_way(*by8, tables.placed8);
  if (const auto* const by16 = std::get_if<PlacedBvh<16>>(&index.any))
    return placed_way(*by16, tables.placed16);
  return std::nullopt;
}

SingleHit MethodTracer::closest(const SingleRay& ray) const {
  SingleHit hit;
  std::visit([&](const auto& way) { way.kernels.closest_ray(way.view, ray, hit); }, way_);
  return hit;
}

bool MethodTracer::occluded(const SingleRay& ray) const {
  return std::visit([&](const auto& way) { return way.kernels.occluded_ray(way.view, ray); }, way_);
}

}  // namespace tessera::core
