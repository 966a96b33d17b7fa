// Rays from one point to many, such as shadow rays of a point light: taken together by where they
// go, seen from that point, since neighbours on the picture need not be neighbours there.
//
// Method. Rays are told apart by the face of a cube around the point that they leave through, then the
// longer extent of a group on its face is halved until at most 64 rays are left. The order of add() is
// kept within a group, so what was coherent stays so.
//
// Threads. One object per thread; scratch memory, reused.
#pragma once

#include <cstdint>
#include <memory>

#include "common/math/vec3.h"
#include "slave/core/kernel/packet_layout.h"

namespace tessera::core {

class PointFans {
 public:
  static constexpr int kRaysMax = 1024;

  PointFans();
  ~PointFans();

  // Starts with no rays. Requires: t_min >= 0.
  void begin(Vec3f origin, float t_min);
  // A hit counts for t_min <= t <= t_max. Requires: count() < kRaysMax. Returns: the ray's number,
  // from 0.
  int add(Vec3f direction, float t_max);
  int count() const { return count_; }

  // Returns: how many packets hold the rays; each ray is in exactly one.
  int form();
  // Writes packet i, less than what form() returned. Returns: the numbers of its rays, as far as they
  // are active.
  const std::uint16_t* fill(int i, FanPacket& packet) const;

 private:
  struct Range {
    int begin, end;
  };
  void split(Range range);
  void emit(Range range);

  struct Memory;
  std::unique_ptr<Memory> memory_;
  Vec3f origin_;
  float t_min_ = 0;
  int count_ = 0, group_count_ = 0;
};

}  // namespace tessera::core
