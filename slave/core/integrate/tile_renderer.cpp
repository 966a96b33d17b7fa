// SPDX-License-Identifier: Apache-2.0
#include "slave/core/integrate/tile_renderer.h"

#include <algorithm>
#include <bit>

#include "common/base/check.h"
#include "slave/core/integrate/camera_packet.h"
#include "slave/core/integrate/direct_light.h"
#include "slave/core/integrate/igi/gi_tile.h"
#include "slave/core/integrate/open_sky.h"
#include "slave/core/integrate/path_tracer.h"
#include "slave/core/kernels/kernel_table.h"
#include "slave/core/ray/ray_bits.h"
#include "slave/core/scene/met_surfaces.h"
#include "slave/core/simd/isa_support.h"
#include "slave/core/trace/scene_tracer.h"

namespace tessera::core {
namespace {

// Up to 4x4 packets are traced before they are shaded together, so that shadow rays find company.
constexpr int kBatchEdgePx = 32;
static_assert(kBatchEdgePx * kBatchEdgePx == kBatchMax);

}  // namespace

struct TileRenderer::Scratch {
  CameraPacket camera;
  PacketHits hits;
  MetSurfaces met;
  OpenSky sky;
  RayCone cones[kPacketRays];  // of camera rays
  SurfaceBatch batch;
  DirectLight direct;
  PathTracer paths;
  GiTile global;
  SpecularChain chain;
  Vec3f radiance[kBatchMax];  // [row][column], kBatchEdgePx in a row

  // Of the call in progress.
  const PreparedScene::Impl* scene = nullptr;
  const FrameSettings* settings = nullptr;
  const std::atomic<bool>* is_cancelled = nullptr;
  RayCounts counts;

  // Asked for every packet, so that a cancelled tile is left within some ten thousand rays.
  bool is_over() const {
    return is_cancelled != nullptr && is_cancelled->load(std::memory_order_relaxed);
  }

  // (x, y): of the packet in the part.
  int pixel(int x, int y, int ray) const {
    return (y + camera.row(ray)) * kBatchEdgePx + x + camera.column(ray);
  }
  void shade_primary(int x, int y);
  void add_background(int x, int y);
  void add_surfaces(int x, int y);
  void add_light();
  void render_batch(const SceneTracer& tracer, const TileRect& rect);
  void write(const TileRect& rect, const TileRect& tile, std::span<float> rgb) const;
};

void TileRenderer::Scratch::shade_primary(int x, int y) {
  const FanPacket& rays = camera.rays;
  for (int i = 0; i < kPacketRays; ++i) {
    if (hits.primitive[i] == kNoPrimitive) continue;
    const Vec3f d{rays.direction[0][i], rays.direction[1][i], rays.direction[2][i]};
    const float distance = hits.t[i] * length(d);
    Vec3f& sum = radiance[pixel(x, y, i)];
    sum = sum + Vec3f{distance, distance, distance};
  }
}

void TileRenderer::Scratch::add_background(int x, int y) {
  std::uint64_t open = 0;
  for_each_ray(camera.rays.active, [&](int i) {
    if (hits.primitive[i] == kNoPrimitive) open |= std::uint64_t{1} << i;
  });
  sky.look_out(camera.rays.direction, open);
  for_each_ray(open, [&](int i) {
    Vec3f& sum = radiance[pixel(x, y, i)];
    sum = sum + sky.background(i);
  });
}

void TileRenderer::Scratch::add_light() {
  if (scene->features.has_specular) counts.secondary += chain.follow(batch, radiance);
  if (kHasIndirect && settings->renderer == Renderer::kPath) {
    counts += paths.add(batch, radiance);
  } else {
    counts.shadow += direct.add(batch, radiance);
  }
}

// Adds the surfaces that a packet has hit to the batch, and the light that they give themselves. In
// the dark there is nothing more to find.
void TileRenderer::Scratch::add_surfaces(int x, int y) {
  const bool has_light = !scene->lights.is_empty();
  const bool has_glow = scene->has_glow();
  met.find(camera.rays, hits);
  Surface* to[kPacketRays];
  int count = batch.count;
  for (std::uint64_t left = met.points().met; left != 0; left &= left - 1) {
    const int i = std::countr_zero(left);
    to[i] = &batch.surface[count];
    batch.key[count] = camera.key[i];
    batch.pixel[count++] = static_cast<std::uint16_t>(pixel(x, y, i));
  }
  met.make_seen(met.points().met, cones, to, &batch);
  for (std::uint64_t left = has_glow ? met.points().met : 0; left != 0; left &= left - 1) {
    const int i = std::countr_zero(left);
    Vec3f& sum = radiance[pixel(x, y, i)];
    sum = sum + to[i]->emission;
  }
  if (has_light) batch.count = count;
}

// rect: at most kBatchEdgePx on an edge.
void TileRenderer::Scratch::render_batch(const SceneTracer& tracer, const TileRect& rect) {
  std::fill(std::begin(radiance), std::end(radiance), Vec3f{});
  camera.enter(rect);
  const auto samples = static_cast<std::uint32_t>(settings->samples_per_pixel);
  for (std::uint32_t sample = 0; sample < samples; ++sample) {
    batch.count = 0;
    batch.sample_index = sequence_index(*settings, sample);
    for (int y = 0; y < rect.height_px; y += camera.height_px()) {
      for (int x = 0; x < rect.width_px; x += camera.width_px()) {
        if (is_over()) return;
        camera.set(rect.x_px + x, rect.y_px + y, sample);
        tracer.closest(camera.rays, hits);
        counts.primary += static_cast<std::uint64_t>(std::popcount(camera.rays.active));
        if (settings->renderer == Renderer::kPrimary) {
          shade_primary(x, y);
        } else {
          if (scene->lights.is_background_lit()) add_background(x, y);
          add_surfaces(x, y);
        }
      }
    }
    if (batch.count > 0) add_light();
  }
}

void TileRenderer::Scratch::write(const TileRect& rect, const TileRect& tile,
                                  std::span<float> rgb) const {
  const float scale = 1 / static_cast<float>(settings->samples_per_pixel);
  for (int y = 0; y < rect.height_px; ++y) {
    for (int x = 0; x < rect.width_px; ++x) {
      const int column = rect.x_px + x - tile.x_px, row = rect.y_px + y - tile.y_px;
      const auto at = 3 * static_cast<std::size_t>(row * tile.width_px + column);
      for (int c = 0; c < 3; ++c)
        rgb[at + static_cast<std::size_t>(c)] = radiance[y * kBatchEdgePx + x][c] * scale;
    }
  }
}

IsaMask supported_isas() { return cpu_isas() & compiled_isas(); }

TileRenderer::TileRenderer() : scratch_(std::make_unique<Scratch>()) {}
TileRenderer::~TileRenderer() = default;

RayCounts TileRenderer::render(const PreparedScene& scene, const FrameSettings& settings, Isa isa,
                               const TileRect& rect, std::span<float> rgb,
                               const std::atomic<bool>* is_cancelled, FrameLight* frame_light) {
  TESSERA_CHECK_EQ(rgb.size(), 3 * static_cast<std::size_t>(rect.pixel_count()));
  Scratch& s = *scratch_;
  s.scene = &scene.impl();
  s.settings = &settings;
  s.counts = {};
  const SceneTracer tracer(scene.impl().index, kernels_for(isa), scene.impl().alpha.get());
  s.is_cancelled = is_cancelled;
  const CameraRays camera(settings.camera, settings.width_px, settings.height_px);
  if (kHasIndirect && settings.renderer == Renderer::kIgi && !scene.impl().lights.is_empty()) {
    FrameLight own;
    const VplSets& vpls = (frame_light == nullptr ? own : *frame_light)
                              .vpls(scene.impl(), tracer, settings, s.counts.secondary);
    s.counts +=
        s.global.render(scene.impl(), tracer, settings, vpls, camera, rect, rgb, is_cancelled);
    return s.counts;
  }
  s.direct.begin(scene.impl(), tracer, settings.light_samples, DirectLight::Kind::kWhole,
                 is_cancelled);
  s.chain.begin(scene.impl(), tracer, is_cancelled);
  if (kHasIndirect && settings.renderer == Renderer::kPath)
    s.paths.begin(scene.impl(), tracer, settings.bounces, is_cancelled);
  s.camera.begin(settings, camera, tracer);
  s.met.begin(scene.impl(), tracer.kernels());
  s.batch.begin(scene.impl().features.has_lobes);
  s.sky.begin(scene.impl().lights, tracer.kernels());
  std::fill_n(s.cones, kPacketRays, s.camera.cone());
  for (int y = 0; y < rect.height_px; y += kBatchEdgePx) {
    for (int x = 0; x < rect.width_px; x += kBatchEdgePx) {
      if (s.is_over()) return s.counts;
      const TileRect part{rect.x_px + x, rect.y_px + y, std::min(kBatchEdgePx, rect.width_px - x),
                          std::min(kBatchEdgePx, rect.height_px - y)};
      s.render_batch(tracer, part);
      s.write(part, rect, rgb);
    }
  }
  return s.counts;
}

}  // namespace tessera::core
