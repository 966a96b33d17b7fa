// SPDX-License-Identifier: Apache-2.0
// Light that reaches a batch of surface points straight from the scene's lights.
//
// Shadow rays are traced in groups that look alike from the light, whatever pixels they belong to.
// On a glossy surface a light sample counts with its MIS weight (balance heuristic); the rest of
// that light comes with the next ray of the path, or with GlossyLight. Within longer paths the same
// holds for diffuse surfaces; without it a lamp next to a corner would have unbounded variance.
//
// Sums run over lights, then emitters, then samples, in that order and per pixel alone: a pixel
// does not depend on its neighbours.
//
// Threads. One object per thread, over memory of its own.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>

#include "slave/core/integrate/glossy_light.h"
#include "slave/core/integrate/light_samples.h"
#include "slave/core/ray/ray_list.h"
#include "slave/core/scene/surface_batch.h"

namespace tessera::core {

class DirectLight {
 public:
  struct Memory {
    LightSamples::Memory samples;
    RayGroups groups;
    int surface[kBatchMax];                      // by ray of `groups`
    std::uint64_t blocked[RayGroups::kRaysMax];  // by group, or by packet of `rays`
    RayList rays;
    int lit[RayList::kRaysMax];                     // surface, by ray of `rays`
    std::unique_ptr<ScatteredRays::Memory> glossy;  // made where a scene has glossy surfaces
  };

  // kPartOfPath takes one sample of one emitter, picked by power, and no sample of an even sky,
  // which the paths' own rays meet.
  enum class Kind { kWhole, kPartOfPath };

  // Requires: context and memory outlive it.
  DirectLight(const RenderContext& context, Memory& memory, Kind kind);

  // Adds reflected direct light to radiance [pixel]. Requires: no surface is specular. Returns:
  // rays traced towards lights. Stops at the next light or sample once the context is over.
  std::uint64_t add(const SurfaceBatch& batch, Vec3f* radiance);

 private:
  std::uint64_t add_directional(const SurfaceBatch& batch, const Light& light, Vec3f* radiance);
  std::uint64_t add_point(const SurfaceBatch& batch, const Light& light, Vec3f* radiance);
  std::uint64_t add_emitters(const SurfaceBatch& batch, Vec3f* radiance);
  std::uint64_t add_environment(const SurfaceBatch& batch, Vec3f* radiance);
  bool samples_environment() const {
    const LightSet& lights = context_.scene.lights;
    return lights.has_environment && (kind_ == Kind::kWhole || lights.sky_map != nullptr);
  }
  // Asks for a shadow ray of a surface. `seen_from_light`: where the surface stands as seen from
  // the light; rays are grouped by it.
  void ask(int surface, Vec3f seen_from_light) {
    memory_.surface[memory_.groups.count()] = surface;
    memory_.groups.add(seen_from_light);
  }
  void put_group(const SurfaceBatch& batch, int group, float t_max);
  // Traces the active rays of the groups that have been formed.
  std::uint64_t trace_groups(const SurfaceBatch& batch, float t_max, Vec3f* radiance);
  void add_open(const SurfaceBatch& batch, int surface, Vec3f* radiance) const;

  const RenderContext& context_;
  Memory& memory_;
  const Kind kind_;
  const int light_samples_;
  const bool picks_emitters_;
  LightSamples samples_;
  std::optional<GlossyLight> glossy_;  // where glossy surfaces send out rays of their own
};

}  // namespace tessera::core
