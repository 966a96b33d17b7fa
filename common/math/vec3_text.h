// SPDX-License-Identifier: Apache-2.0
// The source text of vectors, compiled for plain numbers (vec3.h) and, once per instruction set,
// for registers of them (slave/core/simd/vec3-inl.h). It is included in a namespace that has sqrt,
// abs, max and select of T, with TESSERA_VEC3_INLINE defined, and includes nothing itself. Every
// operation is written in one order of roundings, the same on every machine.
// Threads. Plain values.

template <class T>
struct Vec3 {
  T x{}, y{}, z{};

  constexpr T operator[](int axis) const { return axis == 0 ? x : axis == 1 ? y : z; }

  friend TESSERA_VEC3_INLINE Vec3 operator+(Vec3 a, Vec3 b) {
    return {a.x + b.x, a.y + b.y, a.z + b.z};
  }
  friend TESSERA_VEC3_INLINE Vec3 operator-(Vec3 a, Vec3 b) {
    return {a.x - b.x, a.y - b.y, a.z - b.z};
  }
  friend TESSERA_VEC3_INLINE Vec3 operator-(Vec3 a) { return {-a.x, -a.y, -a.z}; }
  friend TESSERA_VEC3_INLINE Vec3 operator*(Vec3 a, T s) { return {a.x * s, a.y * s, a.z * s}; }
  friend TESSERA_VEC3_INLINE Vec3 operator*(T s, Vec3 a) { return a * s; }
  // Product by component.
  friend TESSERA_VEC3_INLINE Vec3 operator*(Vec3 a, Vec3 b) {
    return {a.x * b.x, a.y * b.y, a.z * b.z};
  }
  friend TESSERA_VEC3_INLINE T dot(Vec3 a, Vec3 b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
  friend TESSERA_VEC3_INLINE Vec3 cross(Vec3 a, Vec3 b) {
    return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
  }
  friend TESSERA_VEC3_INLINE Vec3 abs(Vec3 a) { return {abs(a.x), abs(a.y), abs(a.z)}; }
  // The largest component.
  friend TESSERA_VEC3_INLINE T largest(Vec3 a) { return max(a.x, max(a.y, a.z)); }
  friend TESSERA_VEC3_INLINE T length(Vec3 a) { return sqrt(dot(a, a)); }
  // a where the mask holds, else b.
  template <class Mask>
  friend TESSERA_VEC3_INLINE Vec3 select(Mask mask, Vec3 a, Vec3 b) {
    return {select(mask, a.x, b.x), select(mask, a.y, b.y), select(mask, a.z, b.z)};
  }
  template <class Mask>
  friend TESSERA_VEC3_INLINE Vec3 negated_if(Mask mask, Vec3 a) {
    return select(mask, -a, a);
  }
  // A zero vector stays zero.
  friend TESSERA_VEC3_INLINE Vec3 normalize(Vec3 a) {
    const T l = length(a);
    return select(l > 0, a * (1 / l), a);
  }
};
