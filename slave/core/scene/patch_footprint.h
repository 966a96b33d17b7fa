// SPDX-License-Identifier: Apache-2.0
// What preparing freeform surfaces takes in memory at its peak, before it is done: found by
// preparing a sample of their patches, for how many sub-patches a patch is cut into, and how many
// stand for its borders, follows from nothing simpler. So a scene is weighed before it is sent.
//
// Method. Patches are drawn by their mixed numbers (common/scene/surface_sample.h); each surface
// has the share of its copies in what is drawn. To the mean come some standard errors, so that less
// than what is taken is said of few scenes in a hundred, and nothing where all were drawn.
//
// A surface that deforms has other points in each version; what was found of one version holds for
// the kUsesMax that follow, so that weighing takes a small part of what preparing them does.
//
// Threads. One owner. What is known of a surface is remembered by its digest.
#pragma once

#include <cstdint>
#include <map>
#include <utility>

#include "common/scene/scene_codec.h"
#include "common/scene/scene_footprint.h"

namespace tessera::core {

class PatchFootprint {
 public:
  // Surfaces of one form that are not sampled after one that was.
  static constexpr int kUsesMax = 64;

  // As SurfaceBytes (common/scene/scene_footprint.h).
  std::uint64_t bytes(const SceneBlock& surface, std::uint64_t copies, std::uint64_t patches);
  // Must not be called after this object's end.
  SurfaceBytes surface_bytes() {
    return [this](const SceneBlock& surface, std::uint64_t copies, std::uint64_t patches) {
      return bytes(surface, copies, patches);
    };
  }

 private:
  // Means of a patch of one surface.
  struct Means {
    double parts = 0, numbers = 0, trim_bytes = 0;
    double bytes_a_part = 0;
    double patches = 0;  // their number
  };
  static Means sampled(const SceneBlock& surface, std::uint64_t wanted, std::uint64_t patches);

  // What is known of a form, and how many surfaces of it were not sampled since.
  struct OfForm {
    Means means;
    int uses = kUsesMax;
  };
  Means of_form(const SceneBlock& surface, std::uint64_t copies, std::uint64_t patches);

  std::map<std::pair<Digest, double>, Means> known_;  // by digest and the splitting's radius
  std::map<std::pair<std::uint64_t, double>, OfForm> forms_;  // by form, and the same
};

}  // namespace tessera::core
