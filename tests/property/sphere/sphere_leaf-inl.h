// SPDX-License-Identifier: Apache-2.0
// Leaves of balls, for single rays, fans and bundles.
// Threads. One traversal owns one.
#include "tests/property/sphere/sphere_layout.h"

#if defined(TESSERA_TEST_SPHERE_LEAF_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef TESSERA_TEST_SPHERE_LEAF_INL_H_
#undef TESSERA_TEST_SPHERE_LEAF_INL_H_
#else
#define TESSERA_TEST_SPHERE_LEAF_INL_H_
#endif

#include "slave/core/primitive/leaf-inl.h"

HWY_BEFORE_NAMESPACE();
namespace tessera::core {
namespace HWY_NAMESPACE {

template <int W, class Visit>
HWY_INLINE void for_each_sphere(const SpheresOnly<W>& shapes, uint32_t first, uint32_t count,
                                const Visit& visit) {
  for (uint32_t b = first; b < first + count; ++b) {
    const SphereBlock<W>& block = shapes.spheres[b];
    for (int lane = 0; lane < W && block.radius[lane] == block.radius[lane]; ++lane) {
      const float center[3] = {block.center[0][lane], block.center[1][lane], block.center[2][lane]};
      visit(center, block.radius[lane], block.primitive[lane], b);
    }
  }
}

template <int W, bool kAny, class Rays>
class SpherePacketLeaf {
 public:
  static constexpr bool kIsAny = kAny;
  explicit SpherePacketLeaf(Rays& rays) : rays_(rays) {}
  void prepare() {}
  void finish() {}

  bool test(const SpheresOnly<W>& shapes, uint32_t first, uint32_t count) {
    bool has_hit = false;
    for_each_sphere(shapes, first, count,
                    [&](const float* center, float radius, uint32_t primitive, uint32_t) {
                      for (size_t ray = 0; ray < kPacketRays; ++ray)
                        has_hit |= test_ray(ray, center, radius, primitive);
                      rays_.work_left -= 4;
                    });
    return has_hit;
  }

 private:
  bool test_ray(size_t ray, const float* center, float radius, uint32_t primitive) {
    float from[3], along[3];
    for (int a = 0; a < 3; ++a) from[a] = origin(rays_, a, ray);
    rays_.direction_of(ray, along);
    const float t_min = near(rays_, ray);
    const float t = sphere_t(from, along, center, radius, t_min, rays_.best_t[ray]);
    return t < __builtin_inff() && rays_.template take<kAny>(ray, t, t_min, primitive);
  }
  static float origin(const FanRays& fan, int a, size_t) { return fan.origin[a]; }
  static float origin(const BundleRays& bundle, int a, size_t ray) { return bundle.from[a][ray]; }
  static float near(const FanRays& fan, size_t) { return fan.t_min; }
  static float near(const BundleRays& bundle, size_t ray) { return bundle.t_min[ray]; }

  Rays& rays_;
};

template <int W, bool kAny>
class SphereRayLeaf {
 public:
  static constexpr bool kIsAny = kAny;
  explicit SphereRayLeaf(OneRay& ray) : ray_(ray) {}
  void prepare() {}

  uint32_t test(const SpheresOnly<W>& shapes, uint32_t first, uint32_t count) {
    uint32_t where = kNoBlock;
    for_each_sphere(shapes, first, count,
                    [&](const float* center, float radius, uint32_t primitive, uint32_t block) {
                      const float t = sphere_t(ray_.origin, ray_.direction, center, radius,
                                               ray_.t_min, ray_.best_t);
                      const auto number = static_cast<int32_t>(primitive);
                      if (!(t < __builtin_inff()) || !ray_.is_nearer(t, number)) return;
                      ray_.accept<kAny>(t, number);
                      where = block;
                    });
    return kAny ? where : kNoBlock;
  }

 private:
  OneRay& ray_;
};

template <int W>
struct LeafTests<SpheresOnly<W>> {
  static constexpr size_t kBlockBytes = sizeof(*SpheresOnly<W>::spheres);
  static HWY_INLINE const char* address(const SpheresOnly<W>& shapes, uint32_t block) {
    return reinterpret_cast<const char*>(shapes.spheres + block);
  }
  template <bool kAny>
  using Ray = SphereRayLeaf<W, kAny>;
  template <bool kAny>
  using Fan = SpherePacketLeaf<W, kAny, FanRays>;
  template <bool kAny>
  using Bundle = SpherePacketLeaf<W, kAny, BundleRays>;
};

}  // namespace HWY_NAMESPACE
}  // namespace tessera::core
HWY_AFTER_NAMESPACE();

#endif  // per-target include guard
