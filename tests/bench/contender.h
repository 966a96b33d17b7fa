// What is measured: something that takes packets of rays and says where each hits.
//
// Threads. One at a time.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "common/base/isa.h"
#include "slave/core/geometry/triangle_store.h"
#include "slave/core/kernel/bundle_layout.h"
#include "slave/core/kernel/packet_layout.h"

namespace tessera::bench {

using Trace = std::function<void(const core::FanPacket& rays, core::PacketHits& hits)>;

struct Contender {
  std::string name;
  bool is_ours = false;
  Trace trace;
};

struct Build {
  std::string name;
  double cpu_seconds = 0;
  double megabytes = 0;  // structure and copies of triangles; 0 where not known
};

// A set of contenders over one scene, and what building them took. The scene outlives it.
class Entrants {
 public:
  virtual ~Entrants() = default;
  std::vector<Contender> contenders;
  std::vector<Build> builds;
};

std::unique_ptr<Entrants> make_ours(const core::TriangleStore& triangles,
                                    const std::vector<Bounds3f>& boxes, Isa isa);
// Null where the benchmark was built without Embree.
std::unique_ptr<Entrants> make_embree(const core::TriangleStore& triangles, Isa isa);

// Of the calling thread, and of the process, so far.
double thread_cpu_seconds();
double process_cpu_seconds();

}  // namespace tessera::bench
