// SPDX-License-Identifier: Apache-2.0
#include "slave/core/accel/primitive_refs.h"

#include <algorithm>
#include <vector>

#include "slave/core/accel/run_tasks.h"

namespace tessera::core {
namespace {

// References are made in parts of this many steps.
constexpr std::size_t kReferPart = 8192;

// A run of primitives that one task refers to.
struct Part {
  std::size_t begin = 0, end = 0;
  std::uint32_t count = 0;  // of those with a box
  RefRange range;
};

}  // namespace

void share_room(std::span<PrimitiveRef> refs, RefRange& left, RefRange& right,
                std::uint32_t limit) {
  const std::uint64_t room = limit - right.end, size = left.size(), all = right.end - left.begin;
  const auto of_left = static_cast<std::uint32_t>(room * size / all);
  left.limit = left.end + of_left;
  // The first references of the right range move behind its last.
  const std::uint32_t moved = std::min(of_left, right.size());
  const auto first = refs.begin() + right.begin;
  std::copy(first, first + moved, refs.begin() + std::max(right.end, left.limit));
  right.begin += of_left;
  right.end += of_left;
  right.limit = limit;
}

References refer_to(std::span<const Bounds3f> boxes, float cuts_max, int thread_count,
                    std::uint32_t step) {
  const std::size_t part_size = kReferPart * step;
  const auto part_count = static_cast<int>(boxes.size() / part_size) + 1;
  std::vector<Part> parts(static_cast<std::size_t>(part_count));
  run_tasks(part_count, thread_count, [&](int i) {
    Part& part = parts[static_cast<std::size_t>(i)];
    part.begin = static_cast<std::size_t>(i) * part_size;
    part.end = std::min(part.begin + part_size, boxes.size());
    for (std::size_t p = part.begin; p < part.end; p += step)
      part.count += boxes[p].is_empty() ? 0u : 1u;
  });
  References result;
  std::uint32_t count = 0;
  for (Part& part : parts) {
    part.range.begin = part.range.end = count;
    count += part.count;
  }
  if (count == 0) return result;
  const auto room = static_cast<std::uint32_t>(cuts_max * static_cast<float>(count));
  result.refs.resize(std::size_t{count} + room);
  run_tasks(part_count, thread_count, [&](int i) {
    Part& part = parts[static_cast<std::size_t>(i)];
    for (std::size_t p = part.begin; p < part.end; p += step) {
      if (boxes[p].is_empty()) continue;
      PrimitiveRef& ref = result.refs[part.range.end++];
      ref = ref_of(boxes[p], static_cast<std::uint32_t>(p));
      part.range.grow(ref);
    }
  });
  for (const Part& part : parts) {
    result.all.bounds.grow(part.range.bounds);
    result.all.centroids.grow(part.range.centroids);
  }
  result.all.end = count;
  result.all.limit = count + room;
  return result;
}

}  // namespace tessera::core
