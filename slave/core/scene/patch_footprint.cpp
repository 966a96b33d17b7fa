// SPDX-License-Identifier: Apache-2.0
#include "slave/core/scene/patch_footprint.h"

#include <algorithm>
#include <cmath>
#include <memory>
#include <vector>

#include "common/scene/surface_sample.h"
#include "slave/core/primitive/freeform/patch_store.h"

namespace tessera::core {
namespace {

constexpr std::size_t kKnownMax = 4096;  // surfaces that are remembered
constexpr std::uint64_t kSampledLeast = 16;
constexpr double kErrors = 2;  // standard errors that come on top of a mean

// Of a copy's sub-patch: its record, its box twice, the builder's references, binary tree and wide
// nodes, once in fragments and once joined. Before these are there, a surface that stands once has
// its sub-patches twice, which is less. Borders are long, so that their boxes fill nodes less well,
// and are known as spans, too. A fifteenth is for what the heaps of threads keep: up to a tenth
// more than usual was seen where others used the processors.
constexpr double kBytesPerPart = 540, kBytesPerTrimmedPart = 565;
constexpr double kBytesPerPatch = sizeof(Patch) + 120;  // beside its numbers
// Of what decides trims, while that is made and nothing else of the surface is there yet: arrays
// grow by doubling, and are copied when they are cut to their length.
constexpr double kTrimsAtThePeak = 4;

// Patches that are enough. Those of small scenes are cut into more parts, so fewer have to do.
std::uint64_t wanted_of(std::uint64_t patches) {
  return patches <= 1024 ? 160 : patches <= 4096 ? 384 : 1024;
}

}  // namespace

PatchFootprint::Means PatchFootprint::sampled(const SceneBlock& surface, std::uint64_t wanted,
                                              std::uint64_t patches) {
  std::optional<SurfaceSample> sample = sample_surface(*surface.bytes, wanted);
  if (!sample) return {};
  const double count = static_cast<double>(sample->surface.patches.size());
  const double numbers = static_cast<double>(sample->surface.numbers.size());
  Scene scene;
  scene.materials.resize(1);
  scene.surfaces = {std::make_shared<const PatchSurface>(std::move(sample->surface))};
  scene.instances = {{0, Transform{}, ObjectKind::kPatchSurface}};
  std::vector<Bounds3f> boxes;
  const PatchStore store = make_patch_store(scene, splitting_for(patches), boxes);
  std::vector<double> parts(store.patches.size());
  for (const SubPatch& part : store.parts) ++parts[part.patch];
  const double mean = static_cast<double>(store.parts.size()) / count;
  double square = 0;
  for (const double n : parts) square += (n - mean) * (n - mean);
  const double all = static_cast<double>(sample->patch_count);
  // The error of a mean of `count` of `all`, drawn without putting back.
  const double error = std::sqrt(square / count / count * std::max(0.0, 1 - count / all));
  Means means{mean + kErrors * error, numbers / count, 0, kBytesPerPart, all};
  if (store.trims[0]) {
    const std::size_t bytes = store.trims[0]->loops().bytes() + store.trims[0]->borders().bytes();
    means.trim_bytes = static_cast<double>(bytes) / count;
    means.bytes_a_part = kBytesPerTrimmedPart;
  }
  return means;
}

PatchFootprint::Means PatchFootprint::of_form(const SceneBlock& surface, std::uint64_t copies,
                                              std::uint64_t patches) {
  if (forms_.size() > kKnownMax) forms_.clear();
  OfForm& form = forms_[{form_of_surface(*surface.bytes), splitting_for(patches).radius}];
  if (form.uses < kUsesMax) {
    ++form.uses;
    return form.means;
  }
  form.uses = 0;
  const std::uint64_t all_copies = patches_of_surface(*surface.bytes) * copies;
  const double share = static_cast<double>(all_copies) / static_cast<double>(patches);
  const double wanted = static_cast<double>(wanted_of(patches)) * share;
  form.means =
      sampled(surface, std::max(kSampledLeast, static_cast<std::uint64_t>(wanted)), patches);
  return form.means;
}

std::uint64_t PatchFootprint::bytes(const SceneBlock& surface, std::uint64_t copies,
                                    std::uint64_t patches) {
  if (known_.size() > kKnownMax) known_.clear();
  const auto [entry, is_new] = known_.try_emplace({surface.digest, splitting_for(patches).radius});
  Means& of = entry->second;
  if (is_new) of = of_form(surface, copies, patches);
  const double of_copy = of.parts * of.bytes_a_part + of.numbers * sizeof(float) + kBytesPerPatch;
  const double done = of_copy * static_cast<double>(copies) + of.trim_bytes;
  const double all = of.patches * std::max(done, kTrimsAtThePeak * of.trim_bytes);
  return static_cast<std::uint64_t>(all);
}

}  // namespace tessera::core
