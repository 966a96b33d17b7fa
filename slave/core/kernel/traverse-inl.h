// Traversal of a kd-tree by a bundle of 16 rays with masks, for any number of lanes; closest and
// any hit.
//
// After Wald, "Realtime Ray Tracing and Interactive Global Illumination", 2004, chapter 7, and
// Benthin, "Realtime Ray Tracing on Current CPU Architectures", 2006, chapter 4. Every ray keeps
// its own interval [t_near, t_far]; a ray takes part in a voxel while its interval there is not
// empty. All decisions about a ray are made from its own numbers, so its answer cannot depend on
// its companions. A bundle is run once for each group of rays that share the signs of the direction
// (order of children) and the main axis (triangle test); a coherent bundle is one group.
//
// Units. The direction is first scaled by a power of two, exactly, so that its largest component
// lies in [1, 2) (denormal ones: at least 2^-22); t is scaled back at the end. So neither 1/d nor
// the sheared coordinates overflow or lose digits to the length of the direction.
//
// Tolerance, for an origin whose greatest distance to a face of the scene's box, by axis, is s, and
// u = 2^-24. A plane is reached at t = (split - origin) * inv; the voxel must keep every ray that
// the triangle test could accept inside it. In units of length along the axis:
//   3 u s  roundings of t: subtract, reciprocal, multiply, each of at most s
//   6 u s  shift of a vertex in the triangle test: subtract the origin (1), shear = quotient times
//          product (2 and 1), difference (2, as its operands may both be s)
//   2 u s  zero counted as inside: an edge value may round to zero up to that distance of the edge
//   1 u s  the clamp below: a component under 2^-26 of the largest is replaced by that; the main
//          axis leaves the box within s, so the ray is moved by at most 2^-26 s there
//   4 u s  roundings of this bound itself, of the padding and of the sum with it
// together 16 u s; times |inv| that is the padding of t. The clamp keeps inv finite for zero, -0.0
// and denormal components: there is no 0 * inf, hence no NaN in any comparison of the traversal.
#include "slave/core/kernel/bundle_layout.h"
#include "slave/core/kernel/scene_view_layout.h"

#if defined(TESSERA_CORE_TRAVERSE_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef TESSERA_CORE_TRAVERSE_INL_H_
#undef TESSERA_CORE_TRAVERSE_INL_H_
#else
#define TESSERA_CORE_TRAVERSE_INL_H_
#endif

#include "hwy/highway.h"
#include "slave/core/kernel/triangle-inl.h"

HWY_BEFORE_NAMESPACE();
namespace tessera::core {
namespace HWY_NAMESPACE {

// kAny: stop at the first hit of each ray.
template <bool kAny>
class Tracer {
 public:
  Tracer(const SceneView& scene, const RayBundle& rays) : scene_(scene), rays_(rays) {}

  void run() {
    for (size_t r = 0; r < kRows; ++r) setup_row(r);
    uint32_t open = valid_;
    uint32_t keys[kBundleRays] = {};
    for (uint32_t i = 0; i < kBundleRays; ++i) {
      if (open >> i & 1u) keys[i] = group_key(i);
    }
    if (!(scene_.lower[0] <= scene_.upper[0])) open = 0;
    while (open != 0) {
      const uint32_t key = keys[__builtin_ctz(open)];
      uint32_t group = 0;
      for (uint32_t i = 0; i < kBundleRays; ++i) {
        if ((open >> i & 1u) && keys[i] == key) group |= 1u << i;
      }
      open &= ~group;
      trace_group(group, key);
    }
  }

  void store(HitBundle& hits) const {
    const D d;
    const DI di;
    for (size_t r = 0; r < kRows; ++r) {
      const auto miss_i = hn::Eq(best_.primitive[r], hn::Set(di, kPrimitiveNone));
      const M miss = hn::RebindMask(d, miss_i);
      hn::Store(zero_if(miss, hn::Mul(best_.t[r], scale_[r])), d, hits.t + r * kLanes);
      hn::Store(zero_if(miss, best_.u[r]), d, hits.u + r * kLanes);
      hn::Store(zero_if(miss, best_.v[r]), d, hits.v + r * kLanes);
      const VI none = hn::Set(di, -1);  // kNoPrimitive
      hn::Store(hn::IfThenElse(miss_i, none, best_.primitive[r]), di,
                reinterpret_cast<int32_t*>(hits.primitive) + r * kLanes);
    }
  }

  uint32_t blocked() const {
    const DI di;
    const D d;
    uint32_t bits = 0;
    for (size_t r = 0; r < kRows; ++r) {
      const auto hit = hn::Ne(best_.primitive[r], hn::Set(di, kPrimitiveNone));
      bits |= bits_of(d, hn::RebindMask(d, hit)) << (r * kLanes);
    }
    return bits;
  }

 private:
  struct Entry {
    uint32_t node;
    V t_near[kRows], t_far[kRows];
  };

  static V zero_if(M mask, V v) { return hn::IfThenElse(mask, hn::Zero(D()), v); }

  uint32_t group_key(uint32_t i) const {
    const float x = rays_.direction[0][i], y = rays_.direction[1][i], z = rays_.direction[2][i];
    const float ax = x < 0 ? -x : x, ay = y < 0 ? -y : y, az = z < 0 ? -z : z;
    const uint32_t main_axis = ax >= ay && ax >= az ? 0u : ay >= az ? 1u : 2u;
    return (x < 0 ? 1u : 0u) | (y < 0 ? 2u : 0u) | (z < 0 ? 4u : 0u) | main_axis << 3;
  }

  // Validity, scale, reciprocals and paddings of one row of rays.
  void setup_row(size_t r) {
    const D d;
    const DI di;
    const V inf = hn::Set(d, __builtin_inff());
    V largest = hn::Zero(d);
    M valid = mask_of(d, rays_.active >> (r * kLanes));
    for (int a = 0; a < 3; ++a) {
      ray_.origin[a][r] = hn::Load(d, rays_.origin[a] + r * kLanes);
      ray_.direction[a][r] = hn::Load(d, rays_.direction[a] + r * kLanes);
      const V size = hn::Abs(ray_.direction[a][r]);
      valid = hn::And(valid, hn::And(hn::Lt(size, inf), hn::Lt(hn::Abs(ray_.origin[a][r]), inf)));
      largest = hn::IfThenElse(hn::Gt(size, largest), size, largest);
    }
    const V t_min = hn::Load(d, rays_.t_min + r * kLanes),
            t_max = hn::Load(d, rays_.t_max + r * kLanes);
    valid = hn::And(valid, hn::And(hn::Gt(largest, hn::Zero(d)), hn::Le(t_min, t_max)));
    valid_ |= bits_of(d, valid) << (r * kLanes);

    // 2^-k from the exponent of `largest`; the last binade is left at 4 so that 2^-k stays normal.
    const VI exponent =
        hn::Min(hn::And(hn::BitCast(di, largest), hn::Set(di, 0x7f800000)), hn::Set(di, 253 << 23));
    scale_[r] = hn::BitCast(d, hn::Sub(hn::Set(di, 254 << 23), exponent));
    best_.t_min[r] = hn::Div(t_min, scale_[r]);
    best_.t[r] = hn::Div(t_max, scale_[r]);
    best_.u[r] = best_.v[r] = hn::Zero(d);
    best_.primitive[r] = hn::Set(di, kPrimitiveNone);

    V reach = hn::Zero(d);  // s of the file's comment
    for (int a = 0; a < 3; ++a) {
      const V lower = hn::Abs(hn::Sub(hn::Set(d, scene_.lower[a]), ray_.origin[a][r]));
      const V upper = hn::Abs(hn::Sub(hn::Set(d, scene_.upper[a]), ray_.origin[a][r]));
      reach = hn::Max(reach, hn::Max(lower, upper));
    }
    const V slack = hn::Mul(reach, hn::Set(d, 16 * 0x1p-24f));
    slack_[r] = slack;
    const V size_min = hn::Mul(hn::Mul(largest, scale_[r]), hn::Set(d, 0x1p-26f));
    for (int a = 0; a < 3; ++a) {
      // The sign is taken before scaling, as in group_key(): a tiny one may become -0.0.
      const M is_negative = hn::Lt(ray_.direction[a][r], hn::Zero(d));
      const V component = hn::Mul(ray_.direction[a][r], scale_[r]);
      ray_.direction[a][r] = component;
      const V size = hn::Max(hn::Abs(component), size_min);
      const V inv = hn::Div(hn::Set(d, 1.0f), size);
      pad_[a][r] = hn::Mul(slack, inv);
      inverse_[a][r] = hn::IfThenElse(is_negative, hn::Neg(inv), inv);
    }
  }

  // Intervals within the scene's box; rays outside the group get empty ones. Returns: is any ray
  // left.
  bool enter(uint32_t group, uint32_t signs, V* t_near, V* t_far) const {
    const D d;
    bool any = false;
    for (size_t r = 0; r < kRows; ++r) {
      V first = hn::Sub(best_.t_min[r], slack_[r]);
      V last = hn::Add(best_.t[r], slack_[r]);
      for (int a = 0; a < 3; ++a) {
        const bool is_negative = signs >> a & 1u;
        const V in = hn::Set(d, is_negative ? scene_.upper[a] : scene_.lower[a]);
        const V out = hn::Set(d, is_negative ? scene_.lower[a] : scene_.upper[a]);
        const V t_in = hn::Mul(hn::Sub(in, ray_.origin[a][r]), inverse_[a][r]);
        const V t_out = hn::Mul(hn::Sub(out, ray_.origin[a][r]), inverse_[a][r]);
        first = hn::Max(first, hn::Sub(t_in, pad_[a][r]));
        last = hn::Min(last, hn::Add(t_out, pad_[a][r]));
      }
      const M in_group = mask_of(d, group >> (r * kLanes));
      t_near[r] = first;
      t_far[r] = hn::IfThenElse(in_group, last, hn::Set(d, -__builtin_inff()));
      any |= !hn::AllFalse(d, hn::Le(t_near[r], t_far[r]));
    }
    return any;
  }

  void trace_group(uint32_t group, uint32_t key) {
    const D d;
    const uint32_t signs = key & 7u;
    ray_.set_main_axis(static_cast<int>(key >> 3));
    Entry stack[kKdDepthMax];
    int stack_size = 0;
    V t_near[kRows], t_far[kRows];
    if (!enter(group, signs, t_near, t_far)) return;
    uint32_t node_index = 0;
    for (;;) {
      const KdNode node = scene_.nodes[node_index];
      const uint32_t axis = node.tag_and_index & 3u, index = node.tag_and_index >> 2;
      if (axis != kKdLeafTag) {
        const uint32_t side =
            signs >> axis & 1u;  // of the near child: 1 when the ray comes from above
        const V split = hn::Set(d, node.split);
        V near_far[kRows], far_near[kRows];
        M near_any = hn::MaskFromVec(hn::Zero(d)), far_any = near_any;
        for (size_t r = 0; r < kRows; ++r) {
          const V t = hn::Mul(hn::Sub(split, ray_.origin[axis][r]), inverse_[axis][r]);
          near_far[r] = hn::Min(t_far[r], hn::Add(t, pad_[axis][r]));
          far_near[r] = hn::Max(t_near[r], hn::Sub(t, pad_[axis][r]));
          near_any = hn::Or(near_any, hn::Le(t_near[r], near_far[r]));
          far_any = hn::Or(far_any, hn::Le(far_near[r], t_far[r]));
        }
        const bool to_near = !hn::AllFalse(d, near_any), to_far = !hn::AllFalse(d, far_any);
        if (to_near) {
          if (to_far) {
            Entry& entry = stack[stack_size++];
            entry.node = index + (side ^ 1u);
            for (size_t r = 0; r < kRows; ++r) {
              entry.t_near[r] = far_near[r];
              entry.t_far[r] = t_far[r];
            }
          }
          for (size_t r = 0; r < kRows; ++r) t_far[r] = near_far[r];
          node_index = index + side;
        } else {
          for (size_t r = 0; r < kRows; ++r) t_near[r] = far_near[r];
          node_index = index + (side ^ 1u);
        }
        continue;
      }
      if (node.count != 0) {
        test_triangles<kAny>(scene_, index, node.count, ray_, t_near, t_far, best_);
      }
      if (!pop(stack, stack_size, node_index, t_near, t_far)) return;
    }
  }

  // Takes the next voxel that some ray has still to see: behind its best hit, plus slack, it need
  // not look. For any hit a blocked ray has best t = -inf.
  bool pop(const Entry* stack, int& stack_size, uint32_t& node, V* t_near, V* t_far) const {
    const D d;
    while (stack_size > 0) {
      const Entry& entry = stack[--stack_size];
      M any = hn::MaskFromVec(hn::Zero(d));
      for (size_t r = 0; r < kRows; ++r) {
        t_near[r] = entry.t_near[r];
        t_far[r] = hn::Min(entry.t_far[r], hn::Add(best_.t[r], slack_[r]));
        any = hn::Or(any, hn::Le(t_near[r], t_far[r]));
      }
      if (hn::AllFalse(d, any)) continue;
      node = entry.node;
      return true;
    }
    return false;
  }

  const SceneView& scene_;
  const RayBundle& rays_;
  uint32_t valid_ = 0;
  RayRows ray_;
  BestRows best_;
  V inverse_[3][kRows], pad_[3][kRows];
  V slack_[kRows];  // 16 u s in units of t: the largest component of the direction is at least 1
  V scale_[kRows];
};

}  // namespace HWY_NAMESPACE
}  // namespace tessera::core
HWY_AFTER_NAMESPACE();

#endif  // per-target include guard
