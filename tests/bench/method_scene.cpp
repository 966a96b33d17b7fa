// SPDX-License-Identifier: Apache-2.0
#include "tests/bench/method_scene.h"

#include <algorithm>
#include <limits>
#include <numeric>

#include "common/base/check.h"
#include "slave/core/primitive/freeform/patched_index.h"
#include "slave/core/primitive/patch/sub_patch_range.h"
#include "tests/bench/method_variants.h"

namespace tessera::bench {

MethodScene::MethodScene(const Scene& scene, const core::PatchSplitting* splitting, int lanes) {
  store_ = std::make_shared<core::PatchStore>(core::make_patch_store(scene, boxes_));
  if (splitting != nullptr) {
    core::SubPatches split;
    for (std::size_t p = 0; p < store_->patches.size(); ++p)
      core::split_patch(store_->patches[p], static_cast<std::uint32_t>(p), *splitting, split);
    store_->parts.assign(split.parts.begin(), split.parts.end());
    boxes_ = std::move(split.boxes);
    store_->first_part = {0, store_->parts.size()};
  }
  for (std::size_t p = 0; p < store_->parts.size(); ++p)
    store_->parts[p].primitive = static_cast<std::uint32_t>(p);
  const core::PatchedParts parts{{}, {}, {}, boxes_};
  const core::BuildControl alone{1, nullptr};
  if (lanes >= 16) {
    index_.any = core::index_patches<16>(parts, store_, alone).value();
  } else {
    index_.any = core::index_patches<8>(parts, store_, alone).value();
  }
}

LaneParts::LaneParts(const MethodScene& scene, Vec3f eye) : scene_(scene), eye_(eye) {
  for (const core::Patch& patch : scene.store().patches) add_patch(patch);
  for (const core::SubPatch& part : scene.store().parts) {
    const core::SubPatchRange range(part);
    parts_.push_back({part.patch,
                      {static_cast<float>(range.middle_u - range.half_u),
                       static_cast<float>(range.middle_v - range.half_v)},
                      {static_cast<float>(range.middle_u + range.half_u),
                       static_cast<float>(range.middle_v + range.half_v)}});
  }
  std::vector<std::uint32_t> numbers(parts_.size());
  std::iota(numbers.begin(), numbers.end(), 0u);
  nodes_.resize(1);
  build(numbers, 0, numbers.size(), 0);
  last_.resize(2 * parts_.size());
  forget();
  view_ = {nodes_.data(), parts_.data(), patches_.data(), this, &LaneParts::starts, last_.data()};
}

void LaneParts::forget() {
  std::fill(last_.begin(), last_.end(), std::numeric_limits<float>::quiet_NaN());
}

// Halves at the middle of the boxes' middles. Returns: the node.
std::uint32_t LaneParts::build(std::vector<std::uint32_t>& parts, std::size_t first,
                               std::size_t count, std::size_t node) {
  Bounds3f all, middles;
  for (std::size_t i = first; i < first + count; ++i) {
    const Bounds3f& box = scene_.boxes()[parts[i]];
    all.grow(box);
    middles.grow(0.5f * (box.lower + box.upper));
  }
  for (int a = 0; a < 3; ++a) {
    nodes_[node].low[a] = all.lower[a] - eye_[a];
    nodes_[node].high[a] = all.upper[a] - eye_[a];
  }
  if (count == 1) {
    nodes_[node].child_or_part = parts[first];
    nodes_[node].is_leaf = 1;
    return static_cast<std::uint32_t>(node);
  }
  int axis = 0;
  for (int a = 1; a < 3; ++a)
    if (middles.extent()[a] > middles.extent()[axis]) axis = a;
  const auto begin = parts.begin() + static_cast<std::ptrdiff_t>(first);
  const auto middle_of = [&](std::uint32_t p) {
    return scene_.boxes()[p].lower[axis] + scene_.boxes()[p].upper[axis];
  };
  std::nth_element(begin, begin + static_cast<std::ptrdiff_t>(count / 2),
                   begin + static_cast<std::ptrdiff_t>(count),
                   [&](std::uint32_t a, std::uint32_t b) { return middle_of(a) < middle_of(b); });
  const std::size_t child = nodes_.size();
  nodes_.resize(child + 2);
  nodes_[node].child_or_part = static_cast<std::uint32_t>(child);
  nodes_[node].is_leaf = 0;
  build(parts, first, count / 2, child);
  build(parts, first + count / 2, count - count / 2, child + 1);
  return static_cast<std::uint32_t>(node);
}

void LaneParts::add_patch(const core::Patch& patch) {
  TESSERA_CHECK(patch.degree_u == 3 && patch.degree_v == 3 && !patch.is_rational);
  static constexpr float kPowers[4][4] = {
      {-1, 3, -3, 1}, {3, -6, 3, 0}, {-3, 3, 0, 0}, {1, 0, 0, 0}};
  LanePatch& to = patches_.emplace_back();
  to.extent = static_cast<float>(patch.extent);
  for (int a = 0; a < 3; ++a) {
    for (int k = 0; k < 16; ++k) to.points[a][k] = patch.numbers[3 * k + a] - eye_[a];
    for (int r = 0; r < 4; ++r)
      for (int c = 0; c < 4; ++c) {
        double sum = 0;
        for (int i = 0; i < 4; ++i)
          for (int j = 0; j < 4; ++j)
            sum += double{kPowers[r][i]} * double{to.points[a][4 * i + j]} * double{kPowers[c][j]};
        to.powers[a][4 * r + c] = static_cast<float>(sum);
      }
  }
}

int LaneParts::starts(const void* owner, std::uint32_t patch, const float* direction, float* u,
                      float* v) {
  const auto& self = *static_cast<const LaneParts*>(owner);
  core::SubPatch whole{};
  whole.patch = patch;
  return safe_starts(self.scene_.store().patches[patch], whole, &self.eye_.x, direction,
                     kLaneStartsMax, u, v);
}

}  // namespace tessera::bench
