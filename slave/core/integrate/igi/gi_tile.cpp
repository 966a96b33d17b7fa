// SPDX-License-Identifier: Apache-2.0
#include "slave/core/integrate/igi/gi_tile.h"

#include <algorithm>
#include <bit>
#include <optional>

#include "common/frame/tile_border.h"
#include "slave/core/integrate/camera_packet.h"
#include "slave/core/integrate/direct/direct_integrator.h"
#include "slave/core/integrate/frame_light.h"
#include "slave/core/integrate/igi/bias_compensation.h"
#include "slave/core/integrate/igi/gi_block.h"
#include "slave/core/integrate/igi/vpl_gather.h"
#include "slave/core/integrate/open_sky.h"
#include "slave/core/integrate/path/path_tracer.h"
#include "slave/core/integrate/specular_chain.h"
#include "slave/core/integrate/tile_parts.h"
#include "slave/core/ray/ray_bits.h"
#include "slave/core/scene/met_surfaces.h"

namespace tessera::core {
namespace {

constexpr int kSquareEdgePx = 8;  // of a packet

// Edge of the next part of `left_px` pixels. What is over at the end is a part of its own, whose
// packets are strips.
int part_edge(int left_px) {
  if (left_px >= kPartEdgePx) return kPartEdgePx;
  const int whole = left_px - left_px % kSquareEdgePx;
  return whole > 0 ? whole : left_px;
}

// The rectangle with `by` pixels more on each side, within the picture.
TileRect grown(const TileRect& r, int by, int width_px, int height_px) {
  const int left = std::max(0, r.x_px - by), top = std::max(0, r.y_px - by);
  return {left, top, std::min(width_px, r.x_px + r.width_px + by) - left,
          std::min(height_px, r.y_px + r.height_px + by) - top};
}

// VPLs on an area light are spread over it so evenly that they need no bound except where the light
// is nearer than its own size; rays that have to find a small lamp by chance are worse.
GeometryBounds bounds_of(const FrameSettings& settings, const LightSet& lights,
                         const Bounds3f& scene) {
  if (settings.clamp == 0 || scene.is_empty()) return {};
  const Vec3f extent = scene.extent();
  GeometryBounds bounds;
  bounds.vpl = settings.clamp == kClampAuto ? 8 / dot(extent, extent) : settings.clamp;
  float area = 0;
  for (const Emitter& e : lights.emitters) area += e.area;
  bounds.emitter = area > 0 ? std::max(bounds.vpl, 4 / area) : bounds.vpl;
  return bounds;
}

}  // namespace

struct GiTile::Memory {
  PacketHits hits;
  MetSurfaces::Memory met;
  SkyPoints sky{};
  GiBlock pixels;
  GatherRays gather;
  SpecularChain::Memory chain;
  PathTracer::Memory paths;
  SurfaceBatch surfaces, glossy;                       // of a part, where the scene is rich
  float distance[kBatchMax];                           // likewise, by pixel: from the eye
  Vec3f radiance[kBatchMax];                           // likewise, by pixel: light without VPLs
  std::unique_ptr<BiasCompensation::Memory> residual;  // made where it is asked for
};

// The work on one tile.
class GiTile::Work {
 public:
  Work(const RenderContext& context, Memory& memory)
      : context_(context),
        memory_(memory),
        vpls_(context.frame_light.vpls(context, counts_.secondary)),
        bounds_(bounds_of(context.settings, context.scene.lights, context.tracer.bounds())),
        camera_(context),
        met_(context.scene, context.tracer, memory.met),
        sky_(context.scene.lights, context.kernels(), memory.sky),
        gather_(context, memory.gather, bounds_),
        chain_(context, memory.chain),
        paths_(context, memory.paths, context.settings.bounces) {
    memory.surfaces.make_room_for_lobes(context.scene.features.has_lobes);
    memory.glossy.make_room_for_lobes(context.scene.features.has_lobes);
    std::fill_n(cones_, kPacketRays, camera_.cone());
    if (!context.settings.is_compensated || !bounds_.has_any()) return;
    if (memory.residual == nullptr) memory.residual = std::make_unique<BiasCompensation::Memory>();
    residual_.emplace(context, *memory.residual, bounds_);
  }

  RayCounts render(const TileRect& tile, std::span<float> rgb);

 private:
  int radius() const { return tile_border_px(context_.settings); }
  std::int32_t number_of(const Material* material) const {
    return static_cast<std::int32_t>(material - context_.scene.materials.data());
  }

  void trace_camera(const TileRect& region, std::uint32_t sample);
  void add_hits(const TileRect& part, int x_px, int y_px);
  void keep_surfaces(const TileRect& part, int x_px, int y_px);
  void shade_part(const TileRect& part);
  void gather_sample(std::uint32_t sample);

  const RenderContext& context_;
  Memory& memory_;
  RayCounts counts_;  // declared before the VPLs, whose rays it counts
  const VplSets& vpls_;
  const GeometryBounds bounds_;
  CameraPacket camera_;
  MetSurfaces met_;
  OpenSky sky_;
  RayCone cones_[kPacketRays];  // of camera rays
  VplGather gather_;
  SpecularChain chain_;
  PathTracer paths_;
  std::optional<BiasCompensation> residual_;
};

void GiTile::Work::trace_camera(const TileRect& region, std::uint32_t sample) {
  memory_.surfaces.count = 0;
  memory_.surfaces.sample_index = sequence_index(context_.settings, sample);
  const int right = region.x_px + region.width_px, bottom = region.y_px + region.height_px;
  for (int top = region.y_px, height = 0; top < bottom; top += height) {
    height = part_edge(bottom - top);
    for (int left = region.x_px, width = 0; left < right; left += width) {
      width = part_edge(right - left);
      const TileRect part{left, top, width, height};
      camera_.enter(part);
      for (int y = top; y < top + height; y += camera_.height_px()) {
        for (int x = left; x < left + width; x += camera_.width_px()) {
          if (context_.is_over()) return;
          camera_.set(x, y, sample);
          context_.tracer.closest(camera_.rays, memory_.hits);
          counts_.primary += static_cast<std::uint64_t>(std::popcount(camera_.rays.active));
          add_hits(part, x, y);
        }
      }
      if (context_.scene.features.is_rich) shade_part(part);
    }
  }
}

// Adds what the packet shows whose corner is (x_px, y_px).
void GiTile::Work::add_hits(const TileRect& part, int x_px, int y_px) {
  met_.find(camera_.rays, memory_.hits);
  const PacketPoints& at = met_.points();
  if (context_.scene.lights.is_background_lit()) {
    const std::uint64_t open = camera_.rays.active & ~at.met;
    sky_.look_out(camera_.rays.direction, open);
    for_each_ray(open, [&](int i) {
      memory_.pixels.add_light(x_px + camera_.column(i), y_px + camera_.row(i), sky_.background(i));
    });
  }
  if (context_.scene.features.is_rich) return keep_surfaces(part, x_px, y_px);
  for (std::uint64_t left = at.met; left != 0; left &= left - 1) {
    const int i = std::countr_zero(left);
    const int x = x_px + camera_.column(i), y = y_px + camera_.row(i);
    const Material& material = met_.material(memory_.hits.primitive[i]);
    const Vec3f normal{at.normal[0][i], at.normal[1][i], at.normal[2][i]};
    const bool is_shining = (at.front >> i & 1u) != 0 || material.is_double_sided;
    if (is_shining && !is_black(material.emission))
      memory_.pixels.add_light(x, y, material.emission);
    memory_.pixels.add_point(x, y,
                             {.point = {at.point[0][i], at.point[1][i], at.point[2][i]},
                              .normal = normal,
                              .shading_normal = normal,
                              .albedo = material.albedo,
                              .offset = at.offset[i],
                              .distance = at.distance[i],
                              .material = number_of(&material),
                              .key = camera_.key[i],
                              .primitive = met_.sound_primitive(memory_.hits.primitive[i], i),
                              .horizon = met_.horizon(i)});
  }
}

void GiTile::Work::keep_surfaces(const TileRect& part, int x_px, int y_px) {
  Surface* to[kPacketRays];
  const int first = memory_.surfaces.count;
  for (std::uint64_t left = met_.points().met; left != 0; left &= left - 1) {
    const int i = std::countr_zero(left), n = memory_.surfaces.count++;
    const int pixel =
        (y_px + camera_.row(i) - part.y_px) * kPartEdgePx + x_px + camera_.column(i) - part.x_px;
    to[i] = &memory_.surfaces.surface[n];
    memory_.surfaces.key[n] = camera_.key[i];
    memory_.surfaces.pixel[n] = static_cast<std::uint16_t>(pixel);
    memory_.distance[pixel] = met_.points().distance[i];
  }
  met_.make_seen(camera_.rays, memory_.hits, met_.points().met, cones_, to, &memory_.surfaces);
  for (int n = first; n < memory_.surfaces.count; ++n) {
    const int pixel = memory_.surfaces.pixel[n];
    memory_.pixels.add_light(part.x_px + pixel % kPartEdgePx, part.y_px + pixel / kPartEdgePx,
                             memory_.surfaces.surface[n].emission);
  }
}

// Shades a part of a rich scene: follows chains, then adds gathering points, or paths for glossy
// surfaces.
void GiTile::Work::shade_part(const TileRect& part) {
  std::fill(std::begin(memory_.radiance), std::end(memory_.radiance), Vec3f{});
  if (context_.scene.features.has_specular)
    counts_.secondary += chain_.follow(memory_.surfaces, memory_.radiance);
  memory_.glossy.count = 0;
  memory_.glossy.sample_index = memory_.surfaces.sample_index;
  for (int i = 0; i < memory_.surfaces.count; ++i) {
    const Surface& s = memory_.surfaces.surface[i];
    const int pixel = memory_.surfaces.pixel[i];
    if (scattering_of(s.bsdf) == Scattering::kLobes) {  // shares nothing with its neighbours
      memory_.glossy.add(memory_.surfaces, i);
    } else {
      memory_.pixels.add_point(part.x_px + pixel % kPartEdgePx, part.y_px + pixel / kPartEdgePx,
                               {.point = s.point,
                                .normal = s.normal,
                                .shading_normal = s.shading_normal,
                                .albedo = s.albedo * s.weight,
                                .offset = s.offset,
                                .distance = memory_.distance[pixel],
                                .material = number_of(s.material),
                                .key = memory_.surfaces.key[i],
                                .primitive = s.sound_primitive,
                                .horizon = s.horizon});
    }
  }
  if (memory_.glossy.count > 0) counts_ += paths_.add(memory_.glossy, memory_.radiance);
  for (int y = 0; y < part.height_px && !context_.scene.features.is_diffuse(); ++y) {
    for (int x = 0; x < part.width_px; ++x)
      memory_.pixels.add_light(part.x_px + x, part.y_px + y, memory_.radiance[y * kPartEdgePx + x]);
  }
  memory_.surfaces.count = 0;
}

void GiTile::Work::gather_sample(std::uint32_t sample) {
  const auto samples = static_cast<std::size_t>(context_.settings.samples_per_pixel);
  for (std::size_t number = 0; number < memory_.pixels.batches().size(); ++number) {
    GatherPoints& points = memory_.pixels.batches()[number]->points;
    if (points.count == 0) continue;
    for (auto& light : points.light) std::fill_n(light, points.count, 0.0f);
    context_.kernels().bound_points(points);
    const int set = static_cast<int>(number) / memory_.pixels.batches_per_set();
    counts_.shadow += gather_.add(vpls_.each(), 0, 1, 1, points);
    counts_.shadow +=
        gather_.add(vpls_.set(set), sample, samples, static_cast<float>(samples), points);
    if (residual_) counts_ += residual_->add(points, sequence_index(context_.settings, sample));
    if (context_.is_over()) return;
  }
}

RayCounts GiTile::Work::render(const TileRect& tile, std::span<float> rgb) {
  const FrameSettings& settings = context_.settings;
  const auto samples = static_cast<std::uint32_t>(settings.samples_per_pixel);
  for (int y = 0; y < tile.height_px; y += kGiBlockEdgePx) {
    for (int x = 0; x < tile.width_px; x += kGiBlockEdgePx) {
      const TileRect block{tile.x_px + x, tile.y_px + y,
                           std::min(kGiBlockEdgePx, tile.width_px - x),
                           std::min(kGiBlockEdgePx, tile.height_px - y)};
      const TileRect region = grown(block, radius(), settings.width_px, settings.height_px);
      memory_.pixels.cover(block, region, settings.interleave);
      for (std::uint32_t sample = 0; sample < samples; ++sample) {
        memory_.pixels.clear();
        trace_camera(region, sample);
        gather_sample(sample);
        if (context_.is_over()) return counts_;
        memory_.pixels.add_reflected(context_.kernels(), radius());
      }
      memory_.pixels.write(tile, 1 / static_cast<float>(samples), rgb);
    }
  }
  return counts_;
}

GiTile::GiTile() = default;
GiTile::~GiTile() = default;

RayCounts GiTile::render(const RenderContext& context, const TileRect& tile, std::span<float> rgb) {
  if (context.scene.lights.is_empty()) {
    if (in_the_dark_ == nullptr) in_the_dark_ = std::make_unique<DirectIntegrator>();
    return in_the_dark_->render(context, tile, rgb);
  }
  if (memory_ == nullptr) memory_ = std::make_unique<Memory>();
  return Work(context, *memory_).render(tile, rgb);
}

}  // namespace tessera::core
