#include "slave/core/render/tile_renderer.h"

#include <algorithm>
#include <bit>
#include <limits>

#include "common/base/check.h"
#include "slave/core/kernel/kernel_table.h"
#include "slave/core/render/camera_rays.h"
#include "slave/core/render/direct_light.h"
#include "slave/core/sampling/sample_sequence.h"
#include "slave/core/simd/isa_support.h"

namespace tessera::core {
namespace {

constexpr int kBlockEdgePx = 4;  // a bundle is 4x4 pixels, anchored at multiples of 4 of the image
static_assert(kBlockEdgePx * kBlockEdgePx == kBundleRays);

// Dimensions of the sample sequence of one pixel.
constexpr std::uint32_t kDimensionLens = 0, kDimensionLight = 1;

// Lanes of the block at (x, y) that lie inside the tile.
std::uint32_t lanes_inside(const TileRect& rect, int x_px, int y_px) {
  std::uint32_t lanes = 0;
  for (int lane = 0; lane < kBundleRays; ++lane) {
    const int x = x_px + lane % kBlockEdgePx, y = y_px + lane / kBlockEdgePx;
    const bool is_inside = x >= rect.x_px && x < rect.x_px + rect.width_px && y >= rect.y_px &&
                           y < rect.y_px + rect.height_px;
    if (is_inside) lanes |= 1u << lane;
  }
  return lanes;
}

}  // namespace

struct TileRenderer::Scratch {
  RayBundle rays{};
  HitBundle hits{};
  SurfaceBlock block{};
  DirectLight direct;
  Vec3f radiance[kBundleRays];

  // Of the call in progress.
  const PreparedScene::Impl* scene = nullptr;
  const FrameSettings* settings = nullptr;
  const KernelTable* kernels = nullptr;
  SceneView view{};
  RayCounts counts;

  void camera_bundle(const CameraRays& camera, int x_px, int y_px, std::uint32_t sample,
                     std::uint32_t lanes);
  void shade_primary();
  void shade_direct(int x_px, int y_px, std::uint32_t sample);
  void render_block(const CameraRays& camera, int x_px, int y_px, std::uint32_t lanes);
};

void TileRenderer::Scratch::camera_bundle(const CameraRays& camera, int x_px, int y_px,
                                          std::uint32_t sample, std::uint32_t lanes) {
  const Vec3f origin = camera.origin();
  const bool is_centre = settings->samples_per_pixel == 1;
  for (int lane = 0; lane < kBundleRays; ++lane) {
    if ((lanes >> lane & 1u) == 0) continue;
    const int x = x_px + lane % kBlockEdgePx, y = y_px + lane / kBlockEdgePx;
    const Vec2f at = is_centre ? Vec2f{0.5f, 0.5f}
                               : sample_2d(pixel_key(settings->seed, x, y, kDimensionLens), sample);
    const Vec3f direction = camera.direction(double{at.x} + x, double{at.y} + y);
    for (int a = 0; a < 3; ++a) {
      rays.origin[a][lane] = origin[a];
      rays.direction[a][lane] = direction[a];
    }
    rays.t_min[lane] = 0;
    rays.t_max[lane] = std::numeric_limits<float>::infinity();
  }
  rays.active = lanes;
}

void TileRenderer::Scratch::shade_primary() {
  for (int lane = 0; lane < kBundleRays; ++lane) {
    if ((rays.active >> lane & 1u) == 0 || hits.primitive[lane] == kNoPrimitive) continue;
    const Vec3f d{rays.direction[0][lane], rays.direction[1][lane], rays.direction[2][lane]};
    const float distance = hits.t[lane] * length(d);
    radiance[lane] = radiance[lane] + Vec3f{distance, distance, distance};
  }
}

void TileRenderer::Scratch::shade_direct(int x_px, int y_px, std::uint32_t sample) {
  const bool has_light = !scene->lights.is_empty();
  const bool has_emitters = !scene->lights.emitters.empty();
  block.hit = 0;
  block.sample_index = sample;
  for (int lane = 0; lane < kBundleRays; ++lane) {
    if ((rays.active >> lane & 1u) == 0 || hits.primitive[lane] == kNoPrimitive) continue;
    const Vec3f d{rays.direction[0][lane], rays.direction[1][lane], rays.direction[2][lane]};
    Surface& s = block.surface[lane];
    s = surface_at(*scene, hits.primitive[lane], hits.u[lane], hits.v[lane], d);
    block.hit |= 1u << lane;
    if (!has_light) {  // a bare mesh: the camera is its lamp
      radiance[lane] =
          radiance[lane] + s.albedo * std::max(0.0f, -dot(s.shading_normal, normalize(d)));
      continue;
    }
    if (has_emitters) {
      radiance[lane] = radiance[lane] + s.emission;
      block.key[lane] = pixel_key(settings->seed, x_px + lane % kBlockEdgePx,
                                  y_px + lane / kBlockEdgePx, kDimensionLight);
    }
  }
  if (has_light && block.hit != 0) counts.shadow += direct.add(block, radiance);
}

void TileRenderer::Scratch::render_block(const CameraRays& camera, int x_px, int y_px,
                                         std::uint32_t lanes) {
  std::fill(std::begin(radiance), std::end(radiance), Vec3f{});
  const auto samples = static_cast<std::uint32_t>(settings->samples_per_pixel);
  for (std::uint32_t sample = 0; sample < samples; ++sample) {
    camera_bundle(camera, x_px, y_px, sample, lanes);
    kernels->trace_closest(view, rays, hits);
    counts.primary += static_cast<std::uint64_t>(std::popcount(lanes));
    if (settings->renderer == Renderer::kPrimary) {
      shade_primary();
    } else {
      shade_direct(x_px, y_px, sample);
    }
  }
}

IsaMask supported_isas() { return cpu_isas() & compiled_isas(); }

TileRenderer::TileRenderer() : scratch_(std::make_unique<Scratch>()) {}
TileRenderer::~TileRenderer() = default;

RayCounts TileRenderer::render(const PreparedScene& scene, const FrameSettings& settings, Isa isa,
                               const TileRect& rect, std::span<float> rgb,
                               const std::atomic<bool>* is_cancelled) {
  TESSERA_CHECK_EQ(rgb.size(), 3 * static_cast<std::size_t>(rect.pixel_count()));
  Scratch& s = *scratch_;
  s.scene = &scene.impl();
  s.settings = &settings;
  s.kernels = &kernels_for(isa);
  s.view = scene.impl().view();
  s.counts = {};
  s.direct.begin(scene.impl(), *s.kernels, settings.light_samples);
  const CameraRays camera(settings.camera, settings.width_px, settings.height_px);
  const float scale = 1 / static_cast<float>(settings.samples_per_pixel);
  const int first_x = rect.x_px / kBlockEdgePx * kBlockEdgePx;
  for (int y = rect.y_px / kBlockEdgePx * kBlockEdgePx; y < rect.y_px + rect.height_px;
       y += kBlockEdgePx) {
    if (is_cancelled != nullptr && is_cancelled->load(std::memory_order_relaxed)) break;
    for (int x = first_x; x < rect.x_px + rect.width_px; x += kBlockEdgePx) {
      const std::uint32_t lanes = lanes_inside(rect, x, y);
      s.render_block(camera, x, y, lanes);
      for (int lane = 0; lane < kBundleRays; ++lane) {
        if ((lanes >> lane & 1u) == 0) continue;
        const int column = x + lane % kBlockEdgePx - rect.x_px,
                  row = y + lane / kBlockEdgePx - rect.y_px;
        const auto at = 3 * static_cast<std::size_t>(row * rect.width_px + column);
        rgb[at] = s.radiance[lane].x * scale;
        rgb[at + 1] = s.radiance[lane].y * scale;
        rgb[at + 2] = s.radiance[lane].z * scale;
      }
    }
  }
  return s.counts;
}

}  // namespace tessera::core
