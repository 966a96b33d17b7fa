// SPDX-License-Identifier: Apache-2.0
// The top of a binary hierarchy: ranges that are too large to be one task's are split, down to
// those that are not, which stay uncut. Whether it is cut in space is decided here.
//
// Threads. Built by a call on several threads; then the splitter may be called as it says.
#pragma once

#include <cstdint>
#include <deque>

#include "slave/core/accel/build_control.h"
#include "slave/core/accel/bvh_build_config.h"
#include "slave/core/accel/primitive_refs.h"
#include "slave/core/accel/primitive_set.h"
#include "slave/core/accel/range_splitter.h"

namespace tessera::core {

class TreeTop {
 public:
  // Splits references to every step-th primitive of the set. Requires: the set and `control`
  // outlive the top. Throws: std::bad_alloc.
  TreeTop(const PrimitiveSet& set, int width, const BuildControl& control,
          const BvhBuildConfig& config, std::uint32_t step = 1);
  TreeTop(const TreeTop&) = delete;

  const RefRange& all() const { return references_.all; }
  const RangeSplitter& splitter() const { return splitter_; }
  const Branch& root() const { return root_; }
  bool has_cuts_in_space() const;
  // Area times blocks, summed over the ranges that tasks split further.
  double cost() const;

 private:
  References references_;
  RangeSplitter splitter_;
  Branch root_;
  std::deque<Halves> halves_;
};

// Returns: whether cuts near the root pay, by the tops of some of the primitives with cuts and
// without; few primitives tell that as well as all, in a fraction of the time.
// Throws: std::bad_alloc.
bool do_cuts_pay(const PrimitiveSet& set, int width, const BuildControl& control,
                 const BvhBuildConfig& config);

}  // namespace tessera::core
