#include "slave/core/render/gi_tile.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>
#include <vector>

#include "slave/core/render/camera_packet.h"
#include "slave/core/render/clamp_residual.h"
#include "slave/core/render/path_tracer.h"
#include "slave/core/render/specular_chain.h"
#include "slave/core/render/surface.h"
#include "slave/core/render/vpl_gather.h"

namespace tessera::core {
namespace {

constexpr int kBlockEdgePx = 64;
constexpr int kEntryEdgePx = 32;
constexpr int kSquareEdgePx = 8;  // of a packet
constexpr int kNoSlot = -1;
constexpr float kNowhere = std::numeric_limits<float>::quiet_NaN();  // a distance
static_assert(kFilterEdgeMax == kBlockEdgePx + 2 * kFilterRadiusMax);

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
  VplGather gather;
  ClampResidual residual;
  SpecularChain chain;
  PathTracer paths;
  SurfaceBatch surfaces, glossy;  // of a part of the block, where not all are diffuse
  Vec3f radiance[kBatchMax];      // likewise: what VPLs have no part in
  FilterPlanes planes;
  float albedo[3][kFilterPixels];
  float own[3][kFilterPixels];  // what pixels show without any light: emission, sky
  float sum[3][kFilterPixels];  // over samples
  int slot[kFilterPixels];      // of a pixel in the batches, or kNoSlot
  // [class][batch]: points of pixels with the same place in the K x K pattern.
  std::vector<std::unique_ptr<GatherPoints>> batches;
  int batches_per_class = 0;

  // Of the call in progress.
  const PreparedScene::Impl* scene = nullptr;
  const SceneTracer* tracer = nullptr;
  const FrameSettings* settings = nullptr;
  const VplSets* vpls = nullptr;
  const std::atomic<bool>* is_cancelled = nullptr;
  RayCounts counts;
  float pixel_spread = 0;  // see TileRenderer
  GeometryBounds bounds;

  bool is_over() const {
    return is_cancelled != nullptr && is_cancelled->load(std::memory_order_relaxed);
  }
  bool has_residual() const { return settings->is_compensated && bounds.has_any(); }
  int radius() const {
    const bool is_filtered = settings->is_filtered && settings->pass < kFilteredPasses;
    return is_filtered ? settings->interleave / 2 : 0;
  }

  void begin_batches();
  void clear(const TileRect& region);
  void trace_camera(const TileRect& region, std::uint32_t sample);
  void add_hits(const TileRect& region, const TileRect& part, int x_px, int y_px);
  void add_surface(const TileRect& region, int x_px, int y_px, const Surface& s, std::uint32_t key);
  void shade_part(const TileRect& region, const TileRect& part);
  void gather_sample(std::uint32_t sample);
  void resolve(const TileRect& region, const TileRect& block);
  void write(const TileRect& block, const TileRect& region, const TileRect& tile,
             std::span<float> rgb) const;
};

void GiTile::Scratch::begin_batches() {
  const int k = settings->interleave;
  const int edge = (kFilterEdgeMax + k - 1) / k;
  batches_per_class = (edge * edge + kGatherMax - 1) / kGatherMax;
  const auto count = static_cast<std::size_t>(k * k * batches_per_class);
  while (batches.size() < count) batches.push_back(std::make_unique<GatherPoints>());
}

void GiTile::Scratch::clear(const TileRect& region) {
  for (auto& batch : batches) batch->count = 0;
  // One more all round than the filter may read, and what its registers read behind the last.
  std::fill(std::begin(planes.distance), std::end(planes.distance), kNowhere);
  for (int y = 0; y < region.height_px; ++y) {
    const int at = filter_index(0, y);
    std::fill_n(slot + at, region.width_px, kNoSlot);
    for (int c = 0; c < 3; ++c) std::fill_n(own[c] + at, region.width_px, 0.0f);
  }
}

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
          add_hits(region, part, x, y);
        }
      }
      if (!scene->features.is_diffuse()) shade_part(region, part);
    }
  }
}

void GiTile::Scratch::add_hits(const TileRect& region, const TileRect& part, int x_px, int y_px) {
  const FanPacket& rays = camera.rays;
  const Vec3f eye{rays.origin[0], rays.origin[1], rays.origin[2]};
  const bool is_diffuse = scene->features.is_diffuse();
  SurfacesSeen seen(*scene, eye, pixel_spread);
  for (int i = 0; i < kPacketRays; ++i) {
    if ((rays.active >> i & 1u) == 0) continue;
    const int x = x_px + camera.column(i), y = y_px + camera.row(i);
    const int pixel = filter_index(x - region.x_px, y - region.y_px);
    const std::uint32_t triangle = hits.primitive[i];
    const Vec3f d{rays.direction[0][i], rays.direction[1][i], rays.direction[2][i]};
    if (triangle == kNoPrimitive) {
      const Vec3f sky = scene->lights.sky(d);
      for (int c = 0; c < 3; ++c) own[c][pixel] = sky[c];
      continue;
    }
    const float distance = hits.t[i] * length(d);
    const Surface s = seen.at(triangle, d, hits.t[i]);
    planes.distance[pixel] = distance;
    for (int c = 0; c < 3; ++c) own[c][pixel] = s.emission[c];
    if (is_diffuse) {
      add_surface(region, x, y, s, camera.key[i]);
      continue;
    }
    surfaces.surface[surfaces.count] = s;
    surfaces.key[surfaces.count] = camera.key[i];
    surfaces.pixel[surfaces.count++] =
        static_cast<std::uint16_t>((y - part.y_px) * kEntryEdgePx + x - part.x_px);
  }
}

// Of a part whose surfaces need not be diffuse: chains, then gathering points or paths.
void GiTile::Scratch::shade_part(const TileRect& region, const TileRect& part) {
  std::fill(std::begin(radiance), std::end(radiance), Vec3f{});
  if (scene->features.has_specular) counts.secondary += chain.follow(surfaces, radiance);
  glossy.count = 0;
  glossy.sample_index = surfaces.sample_index;
  for (int i = 0; i < surfaces.count; ++i) {
    const Surface& s = surfaces.surface[i];
    if (s.bsdf == BsdfKind::kGlossy) {
      glossy.surface[glossy.count] = s;
      glossy.key[glossy.count] = surfaces.key[i];
      glossy.pixel[glossy.count++] = surfaces.pixel[i];
    } else {
      add_surface(region, part.x_px + surfaces.pixel[i] % kEntryEdgePx,
                  part.y_px + surfaces.pixel[i] / kEntryEdgePx, s, surfaces.key[i]);
    }
  }
  if (glossy.count > 0) counts += paths.add(glossy, radiance);
  for (int y = 0; y < part.height_px; ++y) {
    for (int x = 0; x < part.width_px; ++x) {
      const int pixel = filter_index(part.x_px + x - region.x_px, part.y_px + y - region.y_px);
      for (int c = 0; c < 3; ++c) own[c][pixel] += radiance[y * kEntryEdgePx + x][c];
      // What ends in the sky or is glossy has nothing to share with its neighbours.
      if (slot[pixel] == kNoSlot) planes.distance[pixel] = kNowhere;
    }
  }
  surfaces.count = 0;
}

void GiTile::Scratch::add_surface(const TileRect& region, int x_px, int y_px, const Surface& s,
                                  std::uint32_t key) {
  const int k = settings->interleave;
  int number = (y_px % k * k + x_px % k) * batches_per_class;
  while (batches[static_cast<std::size_t>(number)]->count == kGatherMax) ++number;
  GatherPoints& batch = *batches[static_cast<std::size_t>(number)];
  const int at = batch.count++;
  const int pixel = filter_index(x_px - region.x_px, y_px - region.y_px);
  slot[pixel] = number * kGatherMax + at;
  for (int c = 0; c < 3; ++c) {
    batch.point[c][at] = planes.point[c][pixel] = s.point[c];
    batch.normal[c][at] = s.normal[c];
    batch.shading[c][at] = planes.normal[c][pixel] = s.shading_normal[c];
    batch.light[c][at] = 0;
    albedo[c][pixel] = s.albedo[c] * s.weight[c];
  }
  batch.offset[at] = s.offset;
  batch.key[at] = key;
  planes.material[pixel] = static_cast<std::int32_t>(s.material - scene->materials.data());
}

void GiTile::Scratch::gather_sample(std::uint32_t sample) {
  const auto samples = static_cast<std::size_t>(settings->samples_per_pixel);
  for (std::size_t number = 0; number < batches.size(); ++number) {
    GatherPoints& batch = *batches[number];
    if (batch.count == 0) continue;
    tracer->kernels().bound_points(batch);
    const int set = static_cast<int>(number) / batches_per_class;
    counts.shadow += gather.add(vpls->each(), 0, 1, 1, batch);
    counts.shadow +=
        gather.add(vpls->set(set), sample, samples, static_cast<float>(samples), batch);
    if (has_residual()) counts += residual.add(batch, sequence_index(*settings, sample));
    if (is_over()) return;
  }
}

// Adds one sample of the block's pixels to their sums.
void GiTile::Scratch::resolve(const TileRect& region, const TileRect& block) {
  for (int y = 0; y < region.height_px; ++y) {
    for (int x = 0; x < region.width_px; ++x) {
      const int pixel = filter_index(x, y), at = slot[pixel];
      for (int c = 0; c < 3; ++c) {
        planes.light[c][pixel] =
            at == kNoSlot
                ? 0
                : batches[static_cast<std::size_t>(at / kGatherMax)]->light[c][at % kGatherMax];
      }
    }
  }
  const int left = block.x_px - region.x_px, top = block.y_px - region.y_px;
  const bool is_filtered = radius() > 0;
  if (is_filtered)
    tracer->kernels().filter(planes, radius(), left, top, block.width_px, block.height_px);
  for (int y = top; y < top + block.height_px; ++y) {
    for (int x = left; x < left + block.width_px; ++x) {
      const int pixel = filter_index(x, y);
      for (int c = 0; c < 3; ++c) {
        const float light = is_filtered ? planes.filtered[c][pixel] : planes.light[c][pixel];
        const float reflected = slot[pixel] == kNoSlot ? 0 : albedo[c][pixel] * light;
        sum[c][pixel] += own[c][pixel] + reflected;
      }
    }
  }
}

void GiTile::Scratch::write(const TileRect& block, const TileRect& region, const TileRect& tile,
                            std::span<float> rgb) const {
  const float scale = 1 / static_cast<float>(settings->samples_per_pixel);
  for (int y = block.y_px; y < block.y_px + block.height_px; ++y) {
    for (int x = block.x_px; x < block.x_px + block.width_px; ++x) {
      const int pixel = filter_index(x - region.x_px, y - region.y_px);
      const auto at = 3 * static_cast<std::size_t>((y - tile.y_px) * tile.width_px + x - tile.x_px);
      for (std::size_t c = 0; c < 3; ++c) rgb[at + c] = sum[c][pixel] * scale;
    }
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
  s.pixel_spread =
      camera.pixel_spread() / std::sqrt(static_cast<float>(settings.samples_per_pixel));
  s.chain.begin(scene, tracer, is_cancelled);
  s.paths.begin(scene, tracer, settings.bounces, is_cancelled);
  s.bounds = bounds_of(settings, scene.lights, tracer.bounds());
  s.gather.begin(tracer, s.bounds, is_cancelled);
  if (s.has_residual()) s.residual.begin(scene, tracer, s.bounds, settings.bounces, is_cancelled);
  s.begin_batches();
  for (int y = 0; y < tile.height_px; y += kBlockEdgePx) {
    for (int x = 0; x < tile.width_px; x += kBlockEdgePx) {
      const TileRect block{tile.x_px + x, tile.y_px + y, std::min(kBlockEdgePx, tile.width_px - x),
                           std::min(kBlockEdgePx, tile.height_px - y)};
      const TileRect region = grown(block, s.radius(), settings.width_px, settings.height_px);
      for (auto& plane : s.sum) std::fill(std::begin(plane), std::end(plane), 0.0f);
      const auto samples = static_cast<std::uint32_t>(settings.samples_per_pixel);
      for (std::uint32_t sample = 0; sample < samples; ++sample) {
        s.clear(region);
        s.trace_camera(region, sample);
        s.gather_sample(sample);
        if (s.is_over()) return s.counts;
        s.resolve(region, block);
      }
      s.write(block, region, tile, rgb);
    }
  }
  return s.counts;
}

}  // namespace tessera::core
