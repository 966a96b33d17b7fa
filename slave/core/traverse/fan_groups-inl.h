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
  static constexpr int kRunsMax = kFanTargetsMax / kPacketRays;
  // Where rays lie on a face of the cube: the lower ends along both axes, and the upper ends, whose
  // signs are changed.
  struct Extent {
    float end[4] = {2, 2, 2, 2};
    float width(int axis) const { return -end[2 + axis] - end[axis]; }
    float middle(int axis) const { return (end[axis] - end[2 + axis]) / 2; }
    float size() const { return width(0) + width(1); }
    void grow(const Extent& other) {
      for (int k = 0; k < 4; ++k) end[k] = min_of(end[k], other.end[k]);
    }
  };
  // Runs of 64 rays that would be packets.
  struct Runs {
    Extent all;
    float sum = 0;          // of their sizes
    bool are_apart = true;  // they hardly overlap
  };
  // A group is halved as long as that makes its runs of 64 rays smaller than this share of what
  // they were; otherwise the rays are neighbours already.
  static constexpr float kGain = 0.85f;
  // Runs that share less than this part of their areas are not halved at all. A line counts as if
  // it were so wide.
  static constexpr float kShared = 0.03f, kLineWidth = 0x1p-20f;

  // Predicates: which rays go to the front; of one ray, and, where registers are packed, of a
  // register of them.
  struct OnFace {
    const int* faces;
    int face;
    bool operator()(float, float, int number) const { return faces[number] == face; }
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
  Runs runs_of(int begin, int end);
  bool are_apart(int count) const;
  void split(int begin, int end, const Runs& runs);
  void emit(int begin, int end);
  // Moves those of [begin, end) for which is_left(u, v, number) holds to the front.
  // Returns: how many.
  template <typename IsLeft>
  HWY_INLINE int partition(int begin, int end, const IsLeft& is_left);
  void put_right(int left, int count);

  FanTargets& targets_;
  int face_of_group_ = 0;                   // that rays go through which are being split
  alignas(64) float run_end_[4][kRunsMax];  // Extent::end of runs
  alignas(64) float spare_[3][kFanTargetsRoom];
  alignas(64) int spare_order_[kFanTargetsRoom];
  alignas(64) int face_[kFanTargetsRoom];
};

inline void FanGroups::run() {
  targets_.group_count = 0;
  targets_.group[0] = 0;
  if (targets_.count == 0) return;
  if (project()) {
    split(0, targets_.count, runs_of(0, targets_.count));
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

// The rays of one face after those of another are packed into the spare arrays, and go back as a
// whole. Most registers hold rays of one or two faces.
inline void FanGroups::sort_by_face() {
  int end[kFaces], count = 0;
  for (int face = 0; face < kFaces; ++face) {
    for (int i = 0; i < targets_.count && count < targets_.count; i += kLanes) {
      const auto is_face = mask_as<V>(load<VI>(face_ + i) == face);
      const auto is_own = is_face && lanes_before(i, targets_.count);
      if (is_none<V>(is_own)) continue;
      for (int k = 0; k < 3; ++k)
        store_packed(load<V>(targets_.projected[k] + i), is_own, spare_[k] + count);
      store_packed(counting_from<VI>(i), is_own, spare_order_ + count);
      count += static_cast<int>(count_of<V>(is_own));
    }
    end[face] = count;
  }
  put_right(0, count);
  for (int face = 0, begin = 0; face < kFaces; begin = end[face++]) {
    face_of_group_ = face;
    if (begin < end[face]) split(begin, end[face], runs_of(begin, end[face]));
  }
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

inline void FanGroups::sort_by_face() {
  int begin = 0;
  for (int face = 0; face < kFaces && begin < targets_.count; ++face) {
    const int end = begin + partition(begin, targets_.count, OnFace{face_, face});
    face_of_group_ = face;
    if (begin < end) split(begin, end, runs_of(begin, end));
    begin = end;
  }
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
  V least[4] = {set<V>(2), set<V>(2), set<V>(2), set<V>(2)};
  for (int i = begin; i < end; i += kLanes) {
    const M is_here = lanes_before(i, end);
    for (int k = 0; k < 2; ++k) {
      const V at = load_unaligned<V>(targets_.projected[k] + i);
      least[k] = min(least[k], select(is_here, at, least[k]));
      least[2 + k] = min(least[2 + k], select(is_here, -at, least[2 + k]));
    }
  }
  Extent extent;
  fold_rows<4>(
      TagOf<V>(), [&](size_t r) HWY_ATTR { return least[r]; },
      [](auto a, auto b) HWY_ATTR { return min(a, b); }, extent.end);
  return extent;
}

inline FanGroups::Runs FanGroups::runs_of(int begin, int end) {
  Runs runs;
  int count = 0;
  for (int i = begin; i < end; i += kPacketRays) {
    const Extent run = extent_of(i, i + kPacketRays < end ? i + kPacketRays : end);
    for (int k = 0; k < 4; ++k) run_end_[k][count] = run.end[k];
    ++count;
    runs.sum += run.size();
    runs.all.grow(run);
  }
  if (count > 1) runs.are_apart = are_apart(count);
  return runs;
}

// Whether the first `count` of run_end_ hardly overlap. Rays that come in the order of pixels are
// mostly parted as they are.
inline bool FanGroups::are_apart(int count) const {
  V own = set<V>(0), common = own;
  for (int i = 0; i < count; ++i) {
    for (int j = 0; j < count; j += kLanes) {
      const auto overlap = [&](int axis) HWY_ATTR {
        const V low = max(load<V>(run_end_[axis] + j), run_end_[axis][i]);
        const V high = max(load<V>(run_end_[2 + axis] + j), run_end_[2 + axis][i]);
        return max(set<V>(kLineWidth) - (low + high), 0);
      };
      const M is_run = lanes_before(j, count);
      const M is_itself = mask_as<V>(counting_from<VI>(j) == i);
      const V area = zero_unless(is_run, overlap(0) * overlap(1));
      own = own + zero_unless(is_itself, area);
      common = common + zero_if(is_itself, area);
    }
  }
  const TagOf<V> d;
  // Two runs have what they share in common twice.
  return hn::GetLane(hn::SumOfLanes(d, common)) <=
         2 * kShared * hn::GetLane(hn::SumOfLanes(d, own));
}

// runs: of these rays. The recursion ends, since a step halves an extent of floats on [-1, 1], or
// emits.
inline void FanGroups::split(int begin, int end, const Runs& runs) {
  if (runs.are_apart) return emit(begin, end);
  const int axis = runs.all.width(0) >= runs.all.width(1) ? 0 : 1;
  const int left = partition(begin, end, Below{axis, runs.all.middle(axis)});
  if (left == 0 || left == end - begin) return emit(begin, end);  // all in one place, or NaN
  const int border = begin + left;
  const Runs on_left = runs_of(begin, border), on_right = runs_of(border, end);
  if (on_left.sum + on_right.sum > kGain * runs.sum) {
    emit(begin, border);
    return emit(border, end);
  }
  split(begin, border, on_left);
  split(border, end, on_right);
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
