// SPDX-License-Identifier: Apache-2.0
#include "slave/core/integrate/igi/gi_tile.h"

#include <algorithm>
#include <bit>

#include "slave/core/integrate/camera_packet.h"
#include "slave/core/integrate/igi/bias_compensation.h"
#include "slave/core/integrate/igi/gi_block.h"
#include "slave/core/integrate/igi/vpl_gather.h"
#include "slave/core/integrate/open_sky.h"
#include "slave/core/integrate/path_tracer.h"
#include "slave/core/integrate/specular_chain.h"
#include "slave/core/ray/ray_bits.h"
#include "slave/core/scene/met_surfaces.h"

namespace tessera::core {
namespace {

constexpr int kEntryEdgePx = 32;
constexpr int kSquareEdgePx = 8;  // of a packet
static_assert(kEntryEdgePx * kEntryEdgePx <= kBatchMax);

// Of the parts that `left_px` pixels are traced in: what is over at the end is a part of its own, whose
// packets are strips.
int part_edge(int left_px) {
  if (left_px >= kEntryEdgePx) return kEntryEdgePx;
  const int whole = left_px - left_px % kSquareEdgePx;
  return whole > 0 ? whole : left_px;
}

// Within the picture.
TileRect grown(const TileRect& r, int by, int width_px, int height_px) {
  const int left = std::max(0, r.x_px - by), top = std::max(0, r.y_px - by);
  return {left, top, std::min(width_px, r.x_px + r.width_px + by) - left,
          std::min(height_px, r.y_px + r.height_px + by) - top};
}

// Points of an area light are spread over it so evenly that they need no bound but where it is
// nearer than its own size; a ray that has to find a small lamp by chance is worse.
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

struct GiTile::Scratch {
  CameraPacket camera;
  PacketHits hits;
  MetSurfaces met;
  OpenSky sky;
  RayCone cones[kPacketRays];  // of camera rays
  GiBlock pixels;
  VplGather gather;
  BiasCompensation residual;
  SpecularChain chain;
  PathTracer paths;
  SurfaceBatch surfaces, glossy;  // of a part of the block, where the scene is rich
  float distance[kBatchMax];      // likewise, by pixel of the part: from the eye
  Vec3f radiance[kBatchMax];      // likewise: what VPLs have no part in

  // Of the call in progress.
  const PreparedScene::Impl* scene = nullptr;
  const SceneTracer* tracer = nullptr;
  const FrameSettings* settings = nullptr;
  const VplSets* vpls = nullptr;
  const std::atomic<bool>* is_cancelled = nullptr;
  RayCounts counts;
  GeometryBounds bounds;

  bool is_over() const {
    return is_cancelled != nullptr && is_cancelled->load(std::memory_order_relaxed);
  }
  bool has_residual() const { return settings->is_compensated && bounds.has_any(); }
  int radius() const {
    const bool is_filtered = settings->is_filtered && settings->pass < kFilteredPasses;
    return is_filtered ? settings->interleave / 2 : 0;
  }
  std::int32_t number_of(const Material* material) const {
    return static_cast<std::int32_t>(material - scene->materials.data());
  }

  void trace_camera(const TileRect& region, std::uint32_t sample);
  void add_hits(const TileRect& part, int x_px, int y_px);
  void keep_surfaces(const TileRect& part, int x_px, int y_px);
  void shade_part(const TileRect& part);
  void gather_sample(std::uint32_t sample);
};

void GiTile::Scratch::trace_camera(const TileRect& region, std::uint32_t sample) {
  surfaces.count = 0;
  surfaces.sample_index = sequence_index(*settings, sample);
  const int right = region.x_px + region.width_px, bottom = region.y_px + region.height_px;
  for (int top = region.y_px, height = 0; top < bottom; top += height) {
    height = part_edge(bottom - top);
    for (int left = region.x_px, width = 0; left < right; left += width) {
      width = part_edge(right - left);
      const TileRect part{left, top, width, height};
      camera.enter(part);
      for (int y = top; y < top + height; y += camera.height_px()) {
        for (int x = left; x < left + width; x += camera.width_px()) {
          if (is_over()) return;
          camera.set(x, y, sample);
          tracer->closest(camera.rays, hits);
          counts.primary += static_cast<std::uint64_t>(std::popcount(camera.rays.active));
          add_hits(part, x, y);
        }
      }
      if (scene->features.is_rich) shade_part(part);
    }
  }
}

// What a packet shows whose corner is (x_px, y_px).
void GiTile::Scratch::add_hits(const TileRect& part, int x_px, int y_px) {
  met.find(camera.rays, hits);
  const PacketPoints& at = met.points();
  if (scene->lights.is_background_lit()) {
    const std::uint64_t open = camera.rays.active & ~at.met;
    sky.look_out(camera.rays.direction, open);
    for_each_ray(open, [&](int i) {
      pixels.add_light(x_px + camera.column(i), y_px + camera.row(i), sky.background(i));
    });
  }
  if (scene->features.is_rich) return keep_surfaces(part, x_px, y_px);
  for (std::uint64_t left = at.met; left != 0; left &= left - 1) {
    const int i = std::countr_zero(left);
    const int x = x_px + camera.column(i), y = y_px + camera.row(i);
    const Material& material = met.material(i);
    const Vec3f normal{at.normal[0][i], at.normal[1][i], at.normal[2][i]};
    const bool is_shining = (at.front >> i & 1u) != 0 || material.is_double_sided;
    if (is_shining && !is_black(material.emission)) pixels.add_light(x, y, material.emission);
    pixels.add_point(x, y,
                     {.point = {at.point[0][i], at.point[1][i], at.point[2][i]},
                      .normal = normal,
                      .shading_normal = normal,
                      .albedo = material.albedo,
                      .offset = at.offset[i],
                      .distance = at.distance[i],
                      .material = number_of(&material),
                      .key = camera.key[i],
                      .triangle = met.sound_triangle(i)});
  }
}

void GiTile::Scratch::keep_surfaces(const TileRect& part, int x_px, int y_px) {
  Surface* to[kPacketRays];
  const int first = surfaces.count;
  for (std::uint64_t left = met.points().met; left != 0; left &= left - 1) {
    const int i = std::countr_zero(left), n = surfaces.count++;
    const int pixel =
        (y_px + camera.row(i) - part.y_px) * kEntryEdgePx + x_px + camera.column(i) - part.x_px;
    to[i] = &surfaces.surface[n];
    surfaces.key[n] = camera.key[i];
    surfaces.pixel[n] = static_cast<std::uint16_t>(pixel);
    distance[pixel] = met.points().distance[i];
  }
  met.make_seen(met.points().met, cones, to, &surfaces);
  for (int n = first; n < surfaces.count; ++n) {
    const int pixel = surfaces.pixel[n];
    pixels.add_light(part.x_px + pixel % kEntryEdgePx, part.y_px + pixel / kEntryEdgePx,
                     surfaces.surface[n].emission);
  }
}

// Of a part of a rich scene: chains, then gathering points or paths.
void GiTile::Scratch::shade_part(const TileRect& part) {
  std::fill(std::begin(radiance), std::end(radiance), Vec3f{});
  if (scene->features.has_specular) counts.secondary += chain.follow(surfaces, radiance);
  glossy.count = 0;
  glossy.sample_index = surfaces.sample_index;
  for (int i = 0; i < surfaces.count; ++i) {
    const Surface& s = surfaces.surface[i];
    const int pixel = surfaces.pixel[i];
    if (s.bsdf == BsdfKind::kGlossy) {  // has nothing to share with its neighbours
      glossy.add(surfaces, i);
    } else {
      pixels.add_point(part.x_px + pixel % kEntryEdgePx, part.y_px + pixel / kEntryEdgePx,
                       {.point = s.point,
                        .normal = s.normal,
                        .shading_normal = s.shading_normal,
                        .albedo = s.albedo * s.weight,
                        .offset = s.offset,
                        .distance = distance[pixel],
                        .material = number_of(s.material),
                        .key = surfaces.key[i],
                        .triangle = s.sound_triangle});
    }
  }
  if (glossy.count > 0) counts += paths.add(glossy, radiance);
  for (int y = 0; y < part.height_px && !scene->features.is_diffuse(); ++y) {
    for (int x = 0; x < part.width_px; ++x)
      pixels.add_light(part.x_px + x, part.y_px + y, radiance[y * kEntryEdgePx + x]);
  }
  surfaces.count = 0;
}

void GiTile::Scratch::gather_sample(std::uint32_t sample) {
  const auto samples = static_cast<std::size_t>(settings->samples_per_pixel);
  for (std::size_t number = 0; number < pixels.batches().size(); ++number) {
    GatherPoints& points = pixels.batches()[number]->points;
    if (points.count == 0) continue;
    for (auto& light : points.light) std::fill_n(light, points.count, 0.0f);
    tracer->kernels().bound_points(points);
    const int set = static_cast<int>(number) / pixels.batches_per_set();
    counts.shadow += gather.add(vpls->each(), 0, 1, 1, points);
    counts.shadow +=
        gather.add(vpls->set(set), sample, samples, static_cast<float>(samples), points);
    if (has_residual()) counts += residual.add(points, sequence_index(*settings, sample));
    if (is_over()) return;
  }
}

GiTile::GiTile() = default;
GiTile::~GiTile() = default;

RayCounts GiTile::render(const PreparedScene::Impl& scene, const SceneTracer& tracer,
                         const FrameSettings& settings, const VplSets& vpls,
                         const CameraRays& camera, const TileRect& tile, std::span<float> rgb,
                         const std::atomic<bool>* is_cancelled) {
  if (scratch_ == nullptr) scratch_ = std::make_unique<Scratch>();
  Scratch& s = *scratch_;
  s.scene = &scene;
  s.tracer = &tracer;
  s.settings = &settings;
  s.vpls = &vpls;
  s.is_cancelled = is_cancelled;
  s.counts = {};
  s.camera.begin(settings, camera, tracer);
  s.met.begin(scene, tracer.kernels());
  s.surfaces.begin(scene.features.has_lobes);
  s.glossy.begin(scene.features.has_lobes);
  s.sky.begin(scene.lights, tracer.kernels());
  std::fill_n(s.cones, kPacketRays, s.camera.cone());
  s.chain.begin(scene, tracer, is_cancelled);
  s.paths.begin(scene, tracer, settings.bounces, is_cancelled);
  s.bounds = bounds_of(settings, scene.lights, tracer.bounds());
  s.gather.begin(tracer, s.bounds, is_cancelled);
  if (s.has_residual()) s.residual.begin(scene, tracer, s.bounds, settings.bounces, is_cancelled);
  for (int y = 0; y < tile.height_px; y += kGiBlockEdgePx) {
    for (int x = 0; x < tile.width_px; x += kGiBlockEdgePx) {
      const TileRect block{tile.x_px + x, tile.y_px + y,
                           std::min(kGiBlockEdgePx, tile.width_px - x),
                           std::min(kGiBlockEdgePx, tile.height_px - y)};
      const TileRect region = grown(block, s.radius(), settings.width_px, settings.height_px);
      s.pixels.begin(block, region, settings.interleave);
      const auto samples = static_cast<std::uint32_t>(settings.samples_per_pixel);
      for (std::uint32_t sample = 0; sample < samples; ++sample) {
        s.pixels.clear();
        s.trace_camera(region, sample);
        s.gather_sample(sample);
        if (s.is_over()) return s.counts;
        s.pixels.add_reflected(tracer.kernels(), s.radius());
      }
      s.pixels.write(tile, 1 / static_cast<float>(samples), rgb);
    }
  }
  return s.counts;
}

}  // namespace tessera::core
