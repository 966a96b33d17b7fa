// SPDX-License-Identifier: Apache-2.0
// Rays through both structures over balls, and the writer of their leaves.
// Threads. Pure functions; a writer has one owner.
#pragma once

#include <algorithm>
#include <cstdint>
#include <limits>
#include <memory>
#include <span>
#include <vector>

#include "common/base/isa.h"
#include "common/math/vec3.h"
#include "slave/core/accel/primitive_set.h"
#include "slave/core/kernels/view_tables_layout.h"
#include "tests/property/sphere/sphere_layout.h"

namespace tessera::core {

template <int W>
using SphereBvh = BvhView<W, SpheresOnly<W>>;
template <int W>
using SphereKd = KdView<W, SpheresOnly<W>>;

ViewTables<SphereBvh> sphere_bvh_kernels(Isa isa);
ViewTables<SphereKd> sphere_kd_kernels(Isa isa);

struct Ball {
  Vec3f center;
  float radius;
};

template <int W>
class SphereWriter final : public LeafWriter {
 public:
  explicit SphereWriter(std::span<const Ball> balls) : balls_(balls) {}

  LeafRange append(std::span<const std::uint32_t> primitives) override {
    const std::uint32_t first = block_count();
    for (std::size_t i = 0; i < primitives.size(); ++i) {
      if (i % W == 0) {
        blocks_.emplace_back();
        for (float& radius : blocks_.back().radius)
          radius = std::numeric_limits<float>::quiet_NaN();
      }
      const Ball& ball = balls_[primitives[i]];
      for (int a = 0; a < 3; ++a) blocks_.back().center[a][i % W] = ball.center[a];
      blocks_.back().radius[i % W] = ball.radius;
      blocks_.back().primitive[i % W] = primitives[i];
    }
    return {first, block_count() - first};
  }
  std::unique_ptr<LeafWriter> fresh() const override {
    return std::make_unique<SphereWriter>(balls_);
  }
  std::vector<std::uint32_t> make_room(std::span<LeafWriter* const> parts) override {
    std::vector<std::uint32_t> bases;
    for (LeafWriter* const part : parts) {
      static_cast<SphereWriter*>(part)->room_ = blocks_.size();
      bases.push_back(block_count());
      blocks_.resize(blocks_.size() + part->block_count());
    }
    return bases;
  }
  void move_in(LeafWriter& part) override {
    const auto& other = static_cast<SphereWriter&>(part);
    std::copy(other.blocks_.begin(), other.blocks_.end(), blocks_.data() + other.room_);
  }
  void reserve(std::size_t block_count) override { blocks_.reserve(block_count); }
  std::uint32_t block_count() const override { return static_cast<std::uint32_t>(blocks_.size()); }
  std::span<const std::uint32_t> primitives_of(std::uint32_t block) const override {
    std::size_t count = 0;
    while (count < W && blocks_[block].radius[count] >= 0) ++count;
    return std::span<const std::uint32_t>(blocks_[block].primitive).first(count);
  }

  const SphereBlock<W>* blocks() const { return blocks_.data(); }

 private:
  std::span<const Ball> balls_;
  std::vector<SphereBlock<W>> blocks_;
  std::size_t room_ = 0;
};

}  // namespace tessera::core
