// SPDX-License-Identifier: Apache-2.0
#include "slave/core/scene/flat_geometry.h"

#include <utility>

#include "slave/core/accel/bvh_fit.h"

namespace tessera::core {
namespace {

bool has_same_triangles(const Geometry& a, const Geometry& b) {
  const MeshList &of_a = a.meshes(), &of_b = b.meshes();
  if (of_a.size() != of_b.size() || a.instances.size() != b.instances.size()) return false;
  for (std::size_t m = 0; m < of_a.size(); ++m) {
    if (of_a[m] != of_b[m] && of_a[m]->triangles != of_b[m]->triangles) return false;
  }
  for (std::size_t i = 0; i < a.instances.size(); ++i) {
    if (a.instances[i].mesh != b.instances[i].mesh) return false;
  }
  return true;
}

// Returns: the structure of the other version if it holds the same triangles, wherever they are;
// null if there is none. Triangles that were cut stand in several leaves, whose boxes hold parts of
// them and, fitted, the whole. Whether the few cuts of the usual hierarchy make that too dear is
// found as for all that moves; one with cuts everywhere is not fitted.
template <int W>
const IndexedBvh<W>* structure_to_fit(const Geometry* other, const Geometry& geometry) {
  if (other == nullptr || geometry.structure == Structure::kBvhQuality) return nullptr;
  const bool is_same = other->structure == geometry.structure && other->patches == nullptr &&
                       other->triangles.is_flat() && has_same_triangles(geometry, *other);
  return is_same ? std::get_if<IndexedBvh<W>>(&other->index.any) : nullptr;
}

// Returns: whether the structure was fitted, and rays in it cost little more than when it was
// built.
template <int W>
Result<bool> fit(const Geometry& other, const IndexedBvh<W>& built, const BuildControl& control,
                 Geometry& geometry) {
  geometry.left_out = without_box(geometry.triangles.vertices);
  if (geometry.left_out != other.left_out) return false;
  auto fitted = fit_index<W>(built, geometry.triangles.vertices, control);
  if (!fitted.is_ok()) return fitted.status();
  geometry.built_cost = other.built_cost > 0 ? other.built_cost : sah_cost(built.structure);
  if (sah_cost(fitted->structure) > kFittedCostMax * geometry.built_cost) return false;
  geometry.index.any = std::move(*fitted);
  geometry.fitted_primitives = geometry.triangles.primitive_count();
  return true;
}

// Returns: whether the version takes the place of one of as many objects, all or most of them other
// ones: such a scene changes with each frame, and the build has to be paid for by its rays. A scene
// that has nothing to do with the one before stays for longer.
bool is_frame_of_many(const Geometry* other, const Geometry& geometry) {
  if (geometry.structure != Structure::kAuto && geometry.structure != Structure::kBvh) return false;
  return other != nullptr && other->meshes().size() == geometry.meshes().size() &&
         other->instances.size() == geometry.instances.size();
}

template <int W>
Result<PrimitiveIndex> build(const Geometry* other, const std::vector<Bounds3f>& boxes,
                             const BuildControl& control, const Geometry& geometry) {
  const std::span<const float> vertices = geometry.triangles.vertices;
  if (!is_frame_of_many(other, geometry))
    return build_primitive_index(boxes, vertices, geometry.structure, W, control);
  Result<IndexedBvh<W>> fast = index_fast<W>(boxes, vertices, control);
  if (!fast.is_ok()) return fast.status();
  return PrimitiveIndex{std::move(*fast)};
}

}  // namespace

void leave_out(const std::vector<Bounds3f>& boxes, std::span<const std::uint32_t> numbers,
               Geometry& geometry) {
  for (std::size_t i = 0; i < boxes.size(); ++i) {
    if (boxes[i].is_empty()) geometry.left_out.push_back(numbers.empty() ? i : numbers[i]);
  }
}

template <int W>
Status build_flat_geometry(const Geometry* other, const BuildControl& control, Geometry& geometry) {
  TriangleStore& store = geometry.triangles;
  store = make_triangle_store(TriangleSource{geometry.meshes(), geometry.instances, {}});
  if (const IndexedBvh<W>* const built = structure_to_fit<W>(other, geometry)) {
    const Result<bool> is_fitted = fit<W>(*other, *built, control, geometry);
    if (!is_fitted.is_ok()) return is_fitted.status();
    store.degenerate_count = geometry.left_out.size();
    if (*is_fitted) return Status::ok();
  }
  geometry.left_out.clear();
  geometry.built_cost = 0;
  const std::vector<Bounds3f> boxes = boxes_of(store.vertices);
  leave_out(boxes, {}, geometry);
  store.degenerate_count = geometry.left_out.size();
  auto index = build<W>(other, boxes, control, geometry);
  if (!index.is_ok()) return index.status();
  geometry.index = std::move(*index);
  geometry.built_primitives = store.primitive_count();
  return Status::ok();
}

template Status build_flat_geometry<8>(const Geometry*, const BuildControl&, Geometry&);
template Status build_flat_geometry<16>(const Geometry*, const BuildControl&, Geometry&);

}  // namespace tessera::core
