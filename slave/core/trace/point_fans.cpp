#include "slave/core/trace/point_fans.h"

#include <algorithm>
#include <cmath>

#include "common/base/check.h"

namespace tessera::core {
namespace {

constexpr int kFaces = 6;

}  // namespace

struct PointFans::Memory {
  float direction[3][kRaysMax];
  float t_max[kRaysMax];
  float across[2][kRaysMax];  // where a ray meets its face of the cube
  std::uint8_t face[kRaysMax];
  std::uint16_t order[kRaysMax], spare[kRaysMax];
  Range groups[kRaysMax];  // of order; none is empty
};

PointFans::PointFans() : memory_(std::make_unique<Memory>()) {}
PointFans::~PointFans() = default;

void PointFans::begin(Vec3f origin, float t_min) {
  origin_ = origin;
  t_min_ = t_min;
  count_ = group_count_ = 0;
}

int PointFans::add(Vec3f direction, float t_max) {
  TESSERA_CHECK_LT(count_, kRaysMax);
  Memory& m = *memory_;
  for (int a = 0; a < 3; ++a) m.direction[a][count_] = direction[a];
  m.t_max[count_] = t_max;
  return count_++;
}

int PointFans::form() {
  Memory& m = *memory_;
  int counts[kFaces + 1] = {};
  for (int i = 0; i < count_; ++i) {
    const float x = m.direction[0][i], y = m.direction[1][i], z = m.direction[2][i];
    const float ax = std::fabs(x), ay = std::fabs(y), az = std::fabs(z);
    const int axis = ax >= ay && ax >= az ? 0 : ay >= az ? 1 : 2;
    const float main = axis == 0 ? x : axis == 1 ? y : z;
    const float scale = 1 / main;
    m.across[0][i] = (axis == 0 ? y : axis == 1 ? z : x) * scale;
    m.across[1][i] = (axis == 0 ? z : axis == 1 ? x : y) * scale;
    m.face[i] = static_cast<std::uint8_t>(2 * axis + (main < 0 ? 1 : 0));
    ++counts[m.face[i] + 1];
  }
  for (int f = 0; f < kFaces; ++f) counts[f + 1] += counts[f];
  int next[kFaces];
  std::copy_n(counts, kFaces, next);
  for (int i = 0; i < count_; ++i) m.order[next[m.face[i]]++] = static_cast<std::uint16_t>(i);
  group_count_ = 0;
  for (int f = 0; f < kFaces; ++f) split({counts[f], counts[f + 1]});
  return group_count_;
}

// Recursion ends: a step halves an extent of floats on [-1, 1], or emits.
void PointFans::split(Range range) {
  if (range.end - range.begin <= kPacketRays) return emit(range);
  Memory& m = *memory_;
  float low[2] = {2, 2}, high[2] = {-2, -2};
  for (int i = range.begin; i < range.end; ++i) {
    for (int k = 0; k < 2; ++k) {
      low[k] = std::min(low[k], m.across[k][m.order[i]]);
      high[k] = std::max(high[k], m.across[k][m.order[i]]);
    }
  }
  const float* const across = m.across[high[0] - low[0] >= high[1] - low[1] ? 0 : 1];
  const int k = across == m.across[0] ? 0 : 1;
  const float middle = (low[k] + high[k]) / 2;
  int left = range.begin, right = 0;
  for (int i = range.begin; i < range.end; ++i) {
    const std::uint16_t ray = m.order[i];
    const bool is_left = across[ray] <= middle;
    m.order[left] = ray;
    m.spare[right] = ray;
    left += is_left ? 1 : 0;
    right += is_left ? 0 : 1;
  }
  std::copy_n(m.spare, right, m.order + left);
  if (left == range.begin || right == 0) return emit(range);  // all in one place, or not a number
  split({range.begin, left});
  split({left, range.end});
}

void PointFans::emit(Range range) {
  for (int first = range.begin; first < range.end; first += kPacketRays) {
    memory_->groups[group_count_++] = {first, std::min(first + kPacketRays, range.end)};
  }
}

const std::uint16_t* PointFans::fill(int i, FanPacket& packet) const {
  const Memory& m = *memory_;
  const Range group = m.groups[i];
  const int count = group.end - group.begin;
  for (int a = 0; a < 3; ++a) packet.origin[a] = origin_[a];
  packet.t_min = t_min_;
  packet.active = ~std::uint64_t{0} >> (kPacketRays - count);
  for (int k = 0; k < count; ++k) {
    const std::uint16_t ray = m.order[group.begin + k];
    for (int a = 0; a < 3; ++a) packet.direction[a][k] = m.direction[a][ray];
    packet.t_max[k] = m.t_max[ray];
  }
  return m.order + group.begin;
}

}  // namespace tessera::core
