// SPDX-License-Identifier: Apache-2.0
#include "slave/core/accel/kd_voxel.h"

#include <algorithm>
#include <limits>
#include <utility>

#include "slave/core/accel/run_tasks.h"

namespace tessera::core {
namespace {

// Each thread that splits a voxel along with others takes at least so many primitives at a time.
constexpr std::size_t kPartRefs = 8192;

// A voxel of at least two threads' share of all primitives, or half of them, is split by several
// threads, since there are too few voxels for all. That costs: what one thread has written comes
// out of its core's caches into another's.
std::size_t shared_min(std::size_t primitives, int thread_count) {
  if (thread_count == 1) return std::numeric_limits<std::size_t>::max();
  const auto shares = static_cast<std::size_t>(std::max(2, thread_count / 2));
  return std::max(2 * kPartRefs, primitives / shares);
}

void set_axis(Vec3f& v, int axis, float value) {
  (axis == 0 ? v.x : axis == 1 ? v.y : v.z) = value;
}

// What a voxel, or a part of it, hands down to its halves. Threads that fill those of neighbouring
// parts share no line of the cache.
struct alignas(128) HandedDown {
  VoxelContent half[2];
  std::size_t room = 0;  // for so many entries
};

// Hands primitives down to the halves of their voxel.
class HandDown {
 public:
  HandDown(const KdBuildConfig& config, const SahSplit& split, const Voxel (&child)[2])
      : clipper_(config.clipper), split_(split), child_(child) {}

  // Makes room for all that touches a half.
  template <class Boxes>
  void reserve(const Boxes& boxes, HandedDown& out) const {
    std::size_t count[2] = {0, 0};
    for (std::size_t i = 0; i < boxes.size(); ++i) {
      count[0] += is_in(boxes[i], 0) ? 1u : 0u;
      count[1] += is_in(boxes[i], 1) ? 1u : 0u;
    }
    out.room = count[0] + count[1];
    for (int side = 0; side < 2; ++side) {
      out.half[side].refs.reserve(count[side]);
      if (clipper_ != nullptr) out.half[side].parts.reserve(count[side]);
    }
  }

  template <class Boxes>
  void fill(const Boxes& boxes, std::span<const std::uint32_t> primitives, HandedDown& out) const {
    for (std::size_t i = 0; i < boxes.size(); ++i) {
      const bool is_there[2] = {is_in(boxes[i], 0), is_in(boxes[i], 1)};
      for (int side = 0; side < 2; ++side) {
        if (!is_there[side]) continue;
        VoxelContent& half = out.half[side];
        if (clipper_ != nullptr && is_there[1 - side]) {
          add_part(primitives[i], boxes[i], side, half);
          continue;
        }
        half.refs.push_back(primitives[i]);
        if (clipper_ != nullptr) half.parts.push_back(boxes[i]);
      }
    }
  }

 private:
  bool is_in(const Bounds3f& box, int side) const {
    const float lower = box.lower[split_.axis], upper = box.upper[split_.axis];
    return side == 0 ? goes_below(lower, split_.plane, upper) : goes_above(split_.plane, upper);
  }
  // Adds to one half the part that lies in it of a primitive that is in both.
  void add_part(std::uint32_t primitive, const Bounds3f& box, int side, VoxelContent& half) const {
    const Bounds3f part = clipper_->clip(primitive, child_[side].bounds);
    const Bounds3f cut{max(part.lower, box.lower), min(part.upper, box.upper)};
    if (cut.is_empty()) return;
    half.refs.push_back(primitive);
    half.parts.push_back(cut);
  }

  const PrimitiveClipper* const clipper_;
  const SahSplit& split_;
  const Voxel (&child_)[2];
};

// Puts together what a half is handed down.
void gather(std::span<const HandedDown> from, int side, VoxelContent& half) {
  std::size_t count = 0;
  for (const HandedDown& part : from) count += part.half[side].refs.size();
  half.refs.reserve(count);
  if (!from[0].half[side].parts.empty()) half.parts.reserve(count);
  for (const HandedDown& part : from) {
    const VoxelContent& some = part.half[side];
    half.refs.insert(half.refs.end(), some.refs.begin(), some.refs.end());
    half.parts.insert(half.parts.end(), some.parts.begin(), some.parts.end());
  }
}

}  // namespace

VoxelSplitter::VoxelSplitter(std::span<const Bounds3f> boxes, const KdBuildConfig& config,
                             int thread_count)
    : boxes_(boxes),
      config_(config),
      thread_count_(thread_count),
      shared_min_(shared_min(boxes.size(), thread_count)) {}

Voxel VoxelSplitter::root() const {
  const std::size_t parts = boxes_.size() / kPartRefs + 1;
  std::vector<Voxel> some(parts);  // each is made on the stack of the thread that fills it
  in_parts(PartBoxes(boxes_), parts, thread_count_, [&](std::size_t part, const PartBoxes& its) {
    const auto first = static_cast<std::size_t>(its.data() - boxes_.data());
    Voxel voxel;
    voxel.content.refs.reserve(its.size());
    for (std::size_t i = 0; i < its.size(); ++i) {
      if (its[i].is_empty()) continue;
      voxel.bounds.grow(its[i]);
      voxel.content.refs.push_back(static_cast<std::uint32_t>(first + i));
    }
    some[part] = std::move(voxel);
  });
  Voxel root = std::move(some[0]);
  root.content.refs.reserve(boxes_.size());
  for (std::size_t part = 1; part < parts; ++part) {
    const VoxelContent& its = some[part].content;
    root.bounds.grow(some[part].bounds);
    root.content.refs.insert(root.content.refs.end(), its.refs.begin(), its.refs.end());
  }
  root.budget = std::uint64_t{config_.refs_per_primitive_max} * root.size() + 64;
  return root;
}

template <class Boxes>
bool VoxelSplitter::split_by(const Boxes& boxes, const Voxel& voxel, SahScratch& scratch,
                             SahSplit& split, Voxel (&child)[2]) const {
  const std::size_t parts = is_shared(voxel) ? boxes.size() / kPartRefs : 1;
  split = choose_split(boxes, voxel.bounds, config_, scratch, parts, thread_count_);
  if (split.axis < 0) return false;
  Voxel half[2];
  for (Voxel& side : half) {
    side.bounds = voxel.bounds;
    side.depth = voxel.depth + 1;
  }
  set_axis(half[0].bounds.upper, split.axis, split.plane);
  set_axis(half[1].bounds.lower, split.axis, split.plane);
  const HandDown hand_down(config_, split, half);
  HandedDown whole;
  std::vector<HandedDown> many(parts > 1 ? parts : 0);
  const std::span<HandedDown> all = parts > 1 ? std::span(many) : std::span(&whole, 1);
  in_parts(boxes, parts, thread_count_,
           [&](std::size_t part, const Boxes& its) { hand_down.reserve(its, all[part]); });
  std::size_t count = 0;
  for (const HandedDown& part : all) count += part.room;
  if (count > voxel.budget) return false;
  const std::span<const std::uint32_t> refs = voxel.content.refs;
  const std::size_t part_size = (boxes.size() + parts - 1) / parts;
  in_parts(boxes, parts, thread_count_, [&](std::size_t part, const Boxes& its) {
    const std::size_t first = std::min(part * part_size, refs.size());
    hand_down.fill(its, refs.subspan(first, its.size()), all[part]);
  });
  for (int side = 0; side < 2; ++side) child[side] = std::move(half[side]);
  if (parts == 1) {
    for (int side = 0; side < 2; ++side) child[side].content = std::move(whole.half[side]);
    return true;
  }
  run_tasks(2, thread_count_, [&](int side) { gather(all, side, child[side].content); });
  return true;
}

bool VoxelSplitter::split(Voxel& voxel, SahScratch& scratch, SahSplit& split,
                          Voxel (&child)[2]) const {
  const bool has_parts = !voxel.content.parts.empty();
  const bool is_split =
      has_parts
          ? split_by(PartBoxes(voxel.content.parts), voxel, scratch, split, child)
          : split_by(WholeBoxes{boxes_.data(), voxel.content.refs}, voxel, scratch, split, child);
  if (!is_split) return false;
  const std::uint64_t n0 = child[0].size(), n1 = child[1].size();
  const std::uint64_t spare = voxel.budget - (n0 + n1);
  const std::uint64_t spare0 = n0 + n1 == 0 ? 0 : spare / (n0 + n1) * n0;
  child[0].budget = n0 + spare0;
  child[1].budget = n1 + (spare - spare0);
  voxel.content = {};
  return true;
}

}  // namespace tessera::core
