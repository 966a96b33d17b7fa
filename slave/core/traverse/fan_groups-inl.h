// SPDX-License-Identifier: Apache-2.0
// Rays from one point, grouped by where they go.
//
// Threads. Works on the caller's memory.
#include "slave/core/ray/packet_layout.h"

#if defined(TESSERA_CORE_FAN_GROUPS_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef TESSERA_CORE_FAN_GROUPS_INL_H_
#undef TESSERA_CORE_FAN_GROUPS_INL_H_
#else
#define TESSERA_CORE_FAN_GROUPS_INL_H_
#endif

#include "slave/core/simd/real-inl.h"

HWY_BEFORE_NAMESPACE();
namespace tessera::core {
namespace HWY_NAMESPACE {

class FanGroups {
  using V = Floats;
  using VI = Ints;
  using M = MaskOf<V>;
  static constexpr int kLanes = static_cast<int>(kLaneCount);
  static constexpr int kFaces = 6;

 public:
  explicit FanGroups(FanTargets& targets) : targets_(targets) {}
  void run();

 private:
  // Where rays lie on a face of the cube.
  struct Extent {
    float low[2] = {2, 2}, high[2] = {-2, -2};
    float size() const { return high[0] - low[0] + (high[1] - low[1]); }
    void grow(const Extent& other) {
      for (int k = 0; k < 2; ++k) {
        low[k] = other.low[k] < low[k] ? other.low[k] : low[k];
        high[k] = max_of(high[k], other.high[k]);
      }
    }
  };
  // A group is halved as long as that makes its runs of 64 rays smaller than this share of what
  // they were; otherwise the rays are neighbours already.
  static constexpr float kGain = 0.85f;

  // Predicates: which rays go to the front; of one ray, and of a register of them.
  struct OnFace {
    const int* faces;
    int face;
    bool operator()(float, float, int number) const { return faces[number] == face; }
    M operator()(V, V, VI number) const { return mask_as<V>(gather(faces, number) == face); }
  };
  struct Below {
    int axis;
    float at;
    bool operator()(float u, float v, int) const { return (axis == 0 ? u : v) <= at; }
    M operator()(V u, V v, VI) const { return (axis == 0 ? u : v) <= at; }
  };

  // Rays `first` to `first + kLanes - 1` that exist.
  static M lanes_before(int first, int end) { return first_lanes<V>(room(first, end)); }
  static size_t room(int first, int end) {
    return static_cast<size_t>(end - first < kLanes ? end - first : kLanes);
  }
  bool project();
  void sort_by_face();
  Extent extent_of(int begin, int end) const;
  Extent extent_of_runs(int begin, int end, float& sum) const;
  void start(int begin, int end);
  void split(int begin, int end, const Extent& all, float sum);
  void emit(int begin, int end);
  // Moves those of [begin, end) for which is_left(u, v, number) holds to the front.
  // Returns: how many.
  template <typename IsLeft>
  HWY_INLINE int partition(int begin, int end, const IsLeft& is_left);
  void put_right(int left, int count);

  FanTargets& targets_;
  int face_of_group_ = 0;  // that rays go through which are being split
  alignas(64) float spare_[3][kFanTargetsRoom];
  alignas(64) int spare_order_[kFanTargetsRoom];
  alignas(64) int face_[kFanTargetsRoom];
};

inline void FanGroups::run() {
  targets_.group_count = 0;
  targets_.group[0] = 0;
  if (targets_.count == 0) return;
  if (project()) {
    start(0, targets_.count);
  } else {
    sort_by_face();
  }
}

// Finds where each ray meets its face of the cube. `order` holds numbers of rays behind the last
// one, too, for registers that are read whole. Returns: whether all leave through one face.
inline bool FanGroups::project() {
  auto first_face = set<VI>(0), number = counting_from<VI>(0);
  bool is_one = true;
  for (int i = 0; i < targets_.count; i += kLanes) {
    const auto x = load<V>(targets_.direction[0] + i), y = load<V>(targets_.direction[1] + i),
               z = load<V>(targets_.direction[2] + i);
    const auto ax = abs(x), ay = abs(y), az = abs(z);
    const auto is_x = ax >= ay && ax >= az, is_y = ay >= az;
    const auto main = select(is_x, x, select(is_y, y, z));
    const auto scale = 1 / abs(main);
    const auto u = select(is_x, y, select(is_y, z, x));
    const auto v = select(is_x, z, select(is_y, x, y));
    store(u * scale, targets_.projected[0] + i);
    store(v * scale, targets_.projected[1] + i);
    store(scale, targets_.projected[2] + i);
    const auto axis = select(is_x, set<VI>(0), select(is_y, set<VI>(2), set<VI>(4)));
    const auto face = axis + zero_unless(main < 0, set<VI>(1));
    store(face, face_ + i);
    store(number, targets_.order + i);
    number = number + kLanes;
    if (i == 0) {
      face_of_group_ = face_[0];
      first_face = set<VI>(face_of_group_);
    }
    const auto differs = face != first_face;
    is_one = is_one && is_none<V>(mask_as<V>(differs) && lanes_before(i, targets_.count));
  }
  return is_one;
}

inline void FanGroups::sort_by_face() {
  int begin = 0;
  for (int face = 0; face < kFaces && begin < targets_.count; ++face) {
    const int count = partition(begin, targets_.count, OnFace{face_, face});
    face_of_group_ = face;
    if (count > 0) start(begin, begin + count);
    begin += count;
  }
}

#if HWY_TARGET == HWY_AVX3
// Registers of either side are packed and stored whole: what they overwrite on the left has been
// read, since left <= i.
template <typename IsLeft>
int FanGroups::partition(int begin, int end, const IsLeft& is_left) {
  int* const order = targets_.order;
  int left = begin, right = 0;
  for (int i = begin; i < end; i += kLanes) {
    V values[3];
    for (int k = 0; k < 3; ++k) values[k] = load_unaligned<V>(targets_.projected[k] + i);
    const auto number = load_unaligned<VI>(order + i);
    const auto is_here = lanes_before(i, end);
    const auto goes_left = is_left(values[0], values[1], number) && is_here;
    const auto goes_right = and_not(goes_left, is_here);
    for (int k = 0; k < 3; ++k) store_packed(values[k], goes_right, spare_[k] + right);
    store_packed(number, goes_right, spare_order_ + right);
    right += static_cast<int>(count_of<V>(goes_right));
    // What stands behind the end belongs to another group.
    const size_t count = count_of<V>(goes_left);
    const auto is_kept = first_lanes<V>(i + kLanes <= end ? kLaneCount : count);
    for (int k = 0; k < 3; ++k) {
      hn::BlendedStore(hn::Compress(values[k], goes_left), is_kept, TagOf<V>(),
                       targets_.projected[k] + left);
    }
    hn::BlendedStore(hn::Compress(number, mask_as<VI>(goes_left)), mask_as<VI>(is_kept),
                     TagOf<VI>(), order + left);
    left += static_cast<int>(count);
  }
  put_right(left, right);
  return left - begin;
}
#else
// This version has no branches, since they cannot be predicted, and does not work in lanes, since
// packing a register is slow before AVX-512.
template <typename IsLeft>
int FanGroups::partition(int begin, int end, const IsLeft& is_left) {
  float* const us = targets_.projected[0];
  float* const vs = targets_.projected[1];
  float* const per_depths = targets_.projected[2];
  int* const order = targets_.order;
  int left = begin, right = 0;
  for (int i = begin; i < end; ++i) {
    const float u = us[i], v = vs[i], per_depth = per_depths[i];
    const int number = order[i];
    const bool goes_left = is_left(u, v, number);
    us[left] = u;  // has been read: left <= i
    vs[left] = v;
    per_depths[left] = per_depth;
    order[left] = number;
    left += goes_left ? 1 : 0;
    spare_[0][right] = u;
    spare_[1][right] = v;
    spare_[2][right] = per_depth;
    spare_order_[right] = number;
    right += goes_left ? 0 : 1;
  }
  put_right(left, right);
  return left - begin;
}
#endif

// Puts the rays in `spare_` behind those that went left.
inline void FanGroups::put_right(int left, int count) {
  const auto size = static_cast<size_t>(count);
  for (int k = 0; k < 3; ++k)
    __builtin_memcpy(targets_.projected[k] + left, spare_[k], size * sizeof(float));
  __builtin_memcpy(targets_.order + left, spare_order_, size * sizeof(int));
}

inline FanGroups::Extent FanGroups::extent_of(int begin, int end) const {
  auto u_low = set<V>(2), u_high = set<V>(-2), v_low = u_low, v_high = u_high;
  const auto grow = [&](auto u, auto v) {
    u_low = min(u_low, u);
    u_high = max(u_high, u);
    v_low = min(v_low, v);
    v_high = max(v_high, v);
  };
  int i = begin;
  for (; i + kLanes <= end; i += kLanes)
    grow(load_unaligned<V>(targets_.projected[0] + i),
         load_unaligned<V>(targets_.projected[1] + i));
  for (; i < end; ++i) grow(set<V>(targets_.projected[0][i]), set<V>(targets_.projected[1][i]));
  return {{least_lane(u_low), least_lane(v_low)}, {greatest_lane(u_high), greatest_lane(v_high)}};
}

inline void FanGroups::start(int begin, int end) {
  float sum = 0;
  const Extent all = extent_of_runs(begin, end, sum);
  split(begin, end, all, sum);
}

// Returns: the extent of all rays. sum: the sizes of the runs of 64 that would be packets are added
// to it.
inline FanGroups::Extent FanGroups::extent_of_runs(int begin, int end, float& sum) const {
  Extent all;
  for (int i = begin; i < end; i += kPacketRays) {
    const Extent run = extent_of(i, i + kPacketRays < end ? i + kPacketRays : end);
    sum += run.size();
    all.grow(run);
  }
  return all;
}

// all, sum: see extent_of_runs(). The recursion ends, since a step halves an extent of floats on
// [-1, 1], or emits.
inline void FanGroups::split(int begin, int end, const Extent& all, float sum) {
  if (end - begin <= kPacketRays) return emit(begin, end);
  const int axis = all.high[0] - all.low[0] >= all.high[1] - all.low[1] ? 0 : 1;
  const int left = partition(begin, end, Below{axis, (all.low[axis] + all.high[axis]) / 2});
  if (left == 0 || left == end - begin) return emit(begin, end);  // all in one place, or NaN
  const int border = begin + left;
  float left_sum = 0, right_sum = 0;
  const Extent left_all = extent_of_runs(begin, border, left_sum);
  const Extent right_all = extent_of_runs(border, end, right_sum);
  if (left_sum + right_sum > kGain * sum) {
    emit(begin, border);
    return emit(border, end);
  }
  split(begin, border, left_all, left_sum);
  split(border, end, right_all, right_sum);
}

inline void FanGroups::emit(int begin, int end) {
  for (; begin < end; begin += kPacketRays) {
    const int last = begin + kPacketRays < end ? begin + kPacketRays : end;
    targets_.face[targets_.group_count] = face_of_group_;
    targets_.group[++targets_.group_count] = last;
  }
}

}  // namespace HWY_NAMESPACE
}  // namespace tessera::core
HWY_AFTER_NAMESPACE();

#endif  // per-target include guard
