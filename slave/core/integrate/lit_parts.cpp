// SPDX-License-Identifier: Apache-2.0
#include "slave/core/integrate/lit_parts.h"

#include "slave/core/ray/ray_bits.h"

namespace tessera::core {

LitParts::LitParts(const RenderContext& context, Memory& memory)
    : context_(context),
      memory_(memory),
      parts_(context),
      met_(context.scene, context.tracer, memory.met),
      sky_(context.scene.lights, context.kernels(), memory.sky) {
  memory.batch.make_room_for_lobes(context.scene.features.has_lobes);
  std::fill_n(cones_, kPacketRays, parts_.camera().cone());
  if (!context.scene.features.has_specular) return;
  if (memory.chain == nullptr) memory.chain = std::make_unique<SpecularChain::Memory>();
  chain_.emplace(context, *memory.chain);
}

void LitParts::add_packet(int x, int y) {
  if (context_.scene.lights.is_background_lit()) add_background(x, y);
  add_surfaces(x, y);
}

void LitParts::add_background(int x, int y) {
  const FanPacket& rays = parts_.camera().rays;
  std::uint64_t open = 0;
  for_each_ray(rays.active, [&](int i) {
    if (memory_.hits.primitive[i] == kNoPrimitive) open |= std::uint64_t{1} << i;
  });
  sky_.look_out(rays.direction, open);
  for_each_ray(open, [&](int i) {
    Vec3f& sum = memory_.pixels.radiance[parts_.pixel(x, y, i)];
    sum = sum + sky_.background(i);
  });
}

// In a scene without lights the surfaces' own emission is all there is, and the batch stays empty.
void LitParts::add_surfaces(int x, int y) {
  const PreparedScene::Impl& scene = context_.scene;
  const CameraPacket& camera = parts_.camera();
  SurfaceBatch& batch = memory_.batch;
  met_.find(camera.rays, memory_.hits);
  const std::uint64_t met = met_.points().met;
  Surface* to[kPacketRays];
  int count = batch.count;
  for_each_ray(met, [&](int i) {
    to[i] = &batch.surface[count];
    batch.key[count] = camera.key[i];
    batch.pixel[count++] = static_cast<std::uint16_t>(parts_.pixel(x, y, i));
  });
  met_.make_seen(camera.rays, memory_.hits, met, cones_, to, &batch);
  for_each_ray(scene.has_glow() ? met : 0, [&](int i) {
    Vec3f& sum = memory_.pixels.radiance[parts_.pixel(x, y, i)];
    sum = sum + to[i]->emission;
  });
  if (!scene.lights.is_empty() || scene.lights.has_partial_emission) batch.count = count;
}

}  // namespace tessera::core
