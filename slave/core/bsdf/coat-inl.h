// SPDX-License-Identifier: Apache-2.0
// Lookups in the table of what varnish keeps of the light below it (slave/core/bsdf/coat_table.h).
// T: float, or Floats.
// Threads. Pure functions.
#include "slave/core/bsdf/albedo_layout.h"

#if defined(TESSERA_CORE_COAT_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef TESSERA_CORE_COAT_INL_H_
#undef TESSERA_CORE_COAT_INL_H_
#else
#define TESSERA_CORE_COAT_INL_H_
#endif

#include "slave/core/bsdf/microfacet-inl.h"

TESSERA_BEFORE_TEXT();
namespace tessera::core {
namespace TESSERA_TEXT {

// One pair of roughnesses, in [0, 1].
template <class T>
class CoatLookup {
  using I = IntOf<T>;

 public:
  // As CoatMeans.
  struct Means {
    T albedo, of_missing, of_scale, of_bias, share_of_missing;
    AlbedoTerms<T> regained;
  };

  TESSERA_INLINE CoatLookup(const CoatView& table, T base_roughness, T coat_roughness)
      : table_(table),
        base_(table_step(base_roughness, table.base_count)),
        coat_(table_step(coat_roughness, table.coat_count)),
        first_(base_.node * table.coat_count + coat_.node) {}

  TESSERA_INLINE AlbedoTerms<T> regained(T cosine) const {
    const TableStep<T> i = table_step(sqrt(max(cosine, 0)), table_.cosine_count);
    const auto row = [&](I number) {
      const I node = number * table_.cosine_count + i.node;
      return mixed(pair_at<T>(table_.regained, node), pair_at<T>(table_.regained, node + 1),
                   i.weight);
    };
    const auto coats = [&](I number) { return mixed(row(number), row(number + 1), coat_.weight); };
    return mixed(coats(first_), coats(first_ + table_.coat_count), base_.weight);
  }

  TESSERA_INLINE Means means() const {
    const CoatMeans* m = table_.means;
    return {mean(&m->albedo),           mean(&m->of_missing),
            mean(&m->of_scale),         mean(&m->of_bias),
            mean(&m->share_of_missing), {mean(&m->regained_of_scale), mean(&m->regained_of_bias)}};
  }

 private:
  // member: that of the first node's means.
  TESSERA_INLINE T mean(const float* member) const {
    constexpr int32_t kStride = sizeof(CoatMeans) / sizeof(float);
    const auto at = [&](I number) { return gather(member, number * kStride); };
    const auto coats = [&](I number) {
      return at(number) * (1 - coat_.weight) + at(number + 1) * coat_.weight;
    };
    return coats(first_) * (1 - base_.weight) + coats(first_ + table_.coat_count) * base_.weight;
  }

  CoatView table_;
  TableStep<T> base_, coat_;
  I first_;  // node of the lower roughnesses
};

}  // namespace TESSERA_TEXT
}  // namespace tessera::core
TESSERA_AFTER_TEXT();

#endif  // per-target include guard
