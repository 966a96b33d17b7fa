// SPDX-License-Identifier: Apache-2.0
// The surface at a place of a triangle, one at a time and in plain arithmetic, each line as the
// standard or the paper has it. The kernels have to agree with it to the bit
// (slave/core/primitive/triangle/triangle_points-inl.h, detail-inl.h, texture-inl.h).
#pragma once

#include "slave/core/kernels/kernel_table.h"
#include "slave/core/scene/prepared_scene_impl.h"
#include "slave/core/surface/programs.h"
#include "slave/core/surface/ray_cone.h"
#include "slave/core/surface/surface.h"
#include "slave/core/surface/surface_offset.h"

namespace tessera::test {

struct PlainPoint {
  core::SurfacePoint at;
  Vec3f normal;  // turned to the viewer
  bool is_front;
};

PlainPoint plain_point(const core::TriangleStore& triangles, std::uint32_t triangle, float u,
                       float v, Vec3f direction);

// Trilinear between levels (Williams, "Pyramidal parametrics", 1983). `texels`: width of the
// footprint in texels of the base.
Vec3f plain_mip_map_sample(const core::MipMap& map, Vec2f uv, float texels);

// cone: the ray cone at the surface.
core::Surface plain_surface(const core::PreparedScene::Impl& scene, std::uint32_t triangle, float u,
                            float v, Vec3f direction, core::RayCone cone);

}  // namespace tessera::test
