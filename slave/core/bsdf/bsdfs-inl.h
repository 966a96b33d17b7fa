// SPDX-License-Identifier: Apache-2.0
// The table of the BSDFs' kernels by kind; a kernel takes one surface per lane. To add a BSDF that
// scatters in lobes, include its text here, and add a row to bsdf_table() and one to
// common/scene/bsdf_kinds.inc.
//
// The text of a BSDF is a class that is made of the points from `at` on:
//   Lobes(const LobeTables&, const BsdfPoints&, const LobePoints*, size_t at)
//   evaluate(to_light)   its value times pi, and the pdf with which sample() takes that direction
//   sample(x, y)         a direction, BSDF times cosine over pdf, and the pdf, from a point of the
//                        unit square
// See bsdf_layout.h for the points, and glossy-inl.h for the first such class.
//
// Threads. Pure functions.
#include "common/scene/bsdf_kind_layout.h"
#include "slave/core/bsdf/lobes_layout.h"

#if defined(TESSERA_CORE_BSDFS_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef TESSERA_CORE_BSDFS_INL_H_
#undef TESSERA_CORE_BSDFS_INL_H_
#else
#define TESSERA_CORE_BSDFS_INL_H_
#endif

#include "slave/core/bsdf/glossy-inl.h"
#include "slave/core/bsdf/layered-inl.h"
#ifdef TESSERA_MORE_BSDF_TEXTS
#include TESSERA_MORE_BSDF_TEXTS
#endif

HWY_BEFORE_NAMESPACE();
namespace tessera::core {
namespace HWY_NAMESPACE {

// Writes points.value and points.pdf.
template <class Lobes>
void evaluate_lobes(const LobeTables& tables, const LobePoints* lobes, BsdfPoints& p) {
  for (int i = 0; i < p.count; i += static_cast<int>(kLaneCount)) {
    const auto at = static_cast<size_t>(i);
    const auto v = Lobes(tables, p, lobes, at).evaluate(load3<Floats>(p.direction, at));
    store3(v.times_pi, p.value, at);
    store(v.pdf, p.pdf + at);
  }
}

// Writes points.direction, value and pdf.
template <class Lobes>
void sample_lobes(const LobeTables& tables, const LobePoints* lobes, BsdfPoints& p) {
  for (int i = 0; i < p.count; i += static_cast<int>(kLaneCount)) {
    const auto at = static_cast<size_t>(i);
    const auto s = Lobes(tables, p, lobes, at)
                       .sample(load<Floats>(p.square[0] + at), load<Floats>(p.square[1] + at));
    store3(s.direction, p.direction, at);
    store3(s.weight, p.value, at);
    store(s.pdf, p.pdf + at);
  }
}

// Writes points.direction and pdf; the value of diffuse surfaces is their albedo.
inline void sample_diffuse(const LobeTables&, const LobePoints*, BsdfPoints& p) {
  for (int i = 0; i < p.count; i += static_cast<int>(kLaneCount)) {
    const auto at = static_cast<size_t>(i);
    const auto normal = load3<Floats>(p.normal, at);
    const auto direction =
        cosine_direction(normal, load<Floats>(p.square[0] + at), load<Floats>(p.square[1] + at));
    store3(direction, p.direction, at);
    store(dot(direction, normal) * kInvPi, p.pdf + at);
  }
}

struct BsdfRow {
  BsdfKind kind;
  BsdfKernel kernel;
};

// The kernels of a BSDF whose class is Lobes.
template <class Lobes>
constexpr BsdfKernel kernel_of() {
  return {sample_lobes<Lobes>, evaluate_lobes<Lobes>};
}

constexpr BsdfKernels bsdf_table() {
  constexpr BsdfRow rows[] = {
      {BsdfKind::kDiffuse, {sample_diffuse, nullptr}},
      {BsdfKind::kGlossy, kernel_of<PlainGlossy>()},
#ifdef TESSERA_MORE_BSDF_ROWS
#include TESSERA_MORE_BSDF_ROWS
#endif
  };
  BsdfKernels table{};
  for (const BsdfRow& row : rows) table.of[static_cast<int>(row.kind)] = row.kernel;
  table.of[kLayeredSlot] = kernel_of<LayeredLobes>();
  return table;
}

}  // namespace HWY_NAMESPACE
}  // namespace tessera::core
HWY_AFTER_NAMESPACE();

#endif  // per-target include guard
