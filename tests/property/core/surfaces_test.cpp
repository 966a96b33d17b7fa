// SPDX-License-Identifier: Apache-2.0
// Property: the kernels compute camera rays and surface interactions of whole packets to the bit as
// plain arithmetic does for each ray alone, on every instruction set.
#include <gtest/gtest.h>

#include <bit>
#include <cmath>
#include <cstring>
#include <limits>
#include <random>
#include <set>

#include "slave/core/integrate/camera_packet.h"
#include "slave/core/integrate/frame_light.h"
#include "slave/core/sampling/dimension.h"
#include "slave/core/sampling/sample_sequence.h"
#include "slave/core/scene/met_surfaces.h"
#include "tests/support/packets.h"
#include "tests/support/plain_surface.h"
#include "tests/support/seed.h"
#include "tests/support/test_meshes.h"

namespace tessera::core {
namespace {

// Compares floats by their bits: 0 and -0 differ, NaN is NaN.
bool same_bits(Vec3f a, Vec3f b) { return std::memcmp(&a, &b, sizeof(a)) == 0; }
Vec3f at(const float (&v)[3][kPacketRays], int i) { return {v[0][i], v[1][i], v[2][i]}; }

std::shared_ptr<const PreparedScene> make_scene() {
  Scene scene = test::make_scene(test::make_torus(40, 17));
  Mesh strips;  // every other triangle of them is a sliver
  strips.materials = {0};
  for (int i = 0; i < 500; ++i) {
    const float z = 0.004f * static_cast<float>(i) - 1;
    test::add_quad(strips, {-3, -1, z}, {6, 0, 0}, {0, 0, 0.004f}, 0);
  }
  strips.materials = {0};
  scene.meshes.push_back(std::make_shared<const Mesh>(strips));
  scene.instances.push_back({1, {}});
  for (const float scale : {3.0f, 0.01f, 1000.0f}) {  // tiny and far away
    Instance moved;
    moved.object_to_world.m = {{{0, -scale, 0, scale * 7}, {scale, 0, 0.5f, 1}, {0, 0, scale, -3}}};
    scene.instances.push_back(moved);
  }
  return *PreparedScene::build(scene, {});
}

// Rays of a packet: from one point in a fan, or from anywhere.
RayPacket random_packet(std::mt19937& random, bool is_fan) {
  std::uniform_real_distribution<float> unit(-1, 1);
  const auto any = [&](float size) {
    return Vec3f{unit(random) * size, unit(random) * size, unit(random) * size};
  };
  RayPacket rays;
  const Vec3f eye = any(4), towards = any(1) - eye;
  for (int i = 0; i < kPacketRays; ++i) {
    const Vec3f o = is_fan ? eye : any(4), d = is_fan ? towards + any(0.6f) : any(1) - o;
    for (int a = 0; a < 3; ++a) {
      rays.origin[a][i] = o[a];
      rays.direction[a][i] = d[a];
    }
    rays.t_min[i] = 0;
    rays.t_max[i] = 1e30f;
  }
  rays.active = (std::uint64_t{random()} << 32 | random()) | std::uint64_t{random()};
  return rays;
}

FanPacket fan_of(const RayPacket& rays) {
  FanPacket fan;
  std::memcpy(fan.direction, rays.direction, sizeof(fan.direction));
  std::memcpy(fan.t_max, rays.t_max, sizeof(fan.t_max));
  for (int a = 0; a < 3; ++a) fan.origin[a] = rays.origin[a][0];
  fan.t_min = 0;
  fan.active = rays.active;
  return fan;
}

void expect_plain(const PreparedScene::Impl& scene, const RayPacket& rays, const PacketHits& hits,
                  const PacketPoints& points) {
  std::uint64_t met = 0;
  for (int i = 0; i < kPacketRays; ++i) {
    const std::uint32_t triangle = hits.primitive[i];
    if (triangle == kNoPrimitive) continue;
    met |= std::uint64_t{1} << i;
    const Vec3f d = at(rays.direction, i);
    const TriangleStore& t = scene.triangles;
    const Vec2f uv = barycentric(at(rays.origin, i), d, t.vertex(triangle, 0),
                                 t.vertex(triangle, 1), t.vertex(triangle, 2));
    const test::PlainPoint plain = test::plain_point(t, triangle, uv.x, uv.y, d);
    ASSERT_TRUE(same_bits({uv.x, uv.y, hits.t[i] * length(d)},
                          {points.u[i], points.v[i], points.distance[i]}))
        << uv.x << " " << points.u[i] << " " << uv.y << " " << points.v[i];
    ASSERT_TRUE(same_bits(plain.at.point, at(points.point, i))) << i;
    ASSERT_TRUE(same_bits(plain.normal, at(points.normal, i))) << i;
    ASSERT_EQ(plain.at.offset, points.offset[i]);
    ASSERT_EQ(plain.is_front, (points.front >> i & 1u) != 0);
    const Vec3f a = t.vertex(triangle, 0);
    ASSERT_EQ(is_sliver(t.vertex(triangle, 1) - a, t.vertex(triangle, 2) - a),
              (points.sliver >> i & 1u) != 0);
  }
  ASSERT_EQ(met, points.met);
}

TEST(Surfaces, PointsOfPacketsAreThoseOfEachRayAlone) {
  const auto prepared = make_scene();
  const PreparedScene::Impl& scene = prepared->impl();
  const float* const vertices = scene.triangles.vertices.data();
  for (const Isa isa : test::isas_here()) {
    const KernelTable& kernels = kernels_for(isa);
    const SceneTracer tracer(scene.index, kernels);
    std::mt19937 random(test::seed(11));
    std::uint64_t met = 0, slivers = 0;
    for (int round = 0; round < 2000; ++round) {
      const bool is_fan = round % 2 == 0;
      const RayPacket rays = random_packet(random, is_fan);
      PacketHits hits;
      PacketPoints points;
      if (is_fan) {
        const FanPacket fan = fan_of(rays);
        tracer.closest(fan, hits);
        kernels.fan_points(vertices, fan, hits, points);
      } else {
        tracer.closest(rays, hits);
        kernels.packet_points(vertices, rays, hits, points);
      }
      expect_plain(scene, rays, hits, points);
      if (testing::Test::HasFatalFailure()) return;
      met += static_cast<std::uint64_t>(std::popcount(points.met));
      slivers += static_cast<std::uint64_t>(std::popcount(points.sliver & points.met));
    }
    EXPECT_GT(met, 30000u) << isa_name(isa);
    EXPECT_GT(slivers, 1000u) << isa_name(isa);
  }
}

// Texture 0 repeats, 1 wraps in other ways, 2 is not interpolated, all with 8 bits; 3 has 16.
std::shared_ptr<const Texture> random_texture(int width, int height, bool is_srgb, int number) {
  std::mt19937 random(static_cast<unsigned>(width));
  Texture t;
  t.width_px = width;
  t.height_px = height;
  t.is_srgb = is_srgb;
  if (number > 0) {
    t.wrap_u = number == 1 ? TextureWrap::kMirror : TextureWrap::kClamp;
    t.wrap_v = number == 2 ? TextureWrap::kMirror : TextureWrap::kClamp;
  }
  if (number == 3) t.wrap_v = TextureWrap::kRepeat;
  t.is_nearest = number == 2;
  for (int i = 0; i < 4 * width * height; ++i) {
    if (number == 3) t.rgba16.push_back(static_cast<std::uint16_t>(random()));
    if (number != 3) t.rgba.push_back(static_cast<std::uint8_t>(random() % 256));
  }
  return std::make_shared<const Texture>(t);
}

// The materials: plain, marble, wood, brick, glossy with all textures, diffuse with lamps of two
// kinds, mirror, glass with a normal map, and two whose textures have uv transforms of their own.
constexpr std::uint32_t kRichMaterials = 10;
std::vector<Material> rich_materials() {
  std::vector<Material> materials(kRichMaterials);
  const auto place = [](std::uint32_t texture, std::uint32_t set, std::array<float, 6> map) {
    TextureRef ref(texture);
    ref.uv_set = set;
    ref.uv_map = map;
    return ref;
  };
  const SurfaceKind kinds[] = {SurfaceKind::kMarble, SurfaceKind::kWood, SurfaceKind::kBrick};
  for (std::size_t i = 0; i < 3; ++i) {
    materials[i + 1].surface.kind = kinds[i];
    materials[i + 1].surface.parameters = find_surface_program(kinds[i])->defaults;
  }
  materials[0].emission = {1, 2, 3};
  materials[4].bsdf = BsdfKind::kGlossy;
  materials[4].metalness = materials[4].roughness = 0.7f;
  materials[4].albedo_texture = 0;
  materials[4].roughness_metalness_texture = 1;
  materials[4].normal_texture = 2;
  materials[4].normal_scale = 0.8f;
  materials[5].emission = {5, 4, 3};
  materials[5].emission_texture = 3;
  materials[5].albedo_texture = 4;
  materials[6].bsdf = BsdfKind::kMirror;
  materials[7].bsdf = BsdfKind::kGlass;
  materials[7].normal_texture = 5;
  // Textures with uv transforms and uv sets of their own, some of them alike.
  materials[8].bsdf = BsdfKind::kGlossy;
  materials[8].albedo_texture = place(6, 0, {0.5f, 2, 0.1f, -1, 0.25f, 3});
  materials[8].roughness_metalness_texture = place(7, 0, {0.5f, 2, 0.1f, -1, 0.25f, 3});
  materials[8].normal_texture = place(2, 1, {1, 0, 0, 0, 1, 0});
  materials[9].emission = {1, 1, 1};
  materials[9].emission_texture = place(0, 1, {3, 0, 0.25f, 0, 2, 0});
  materials[9].albedo_texture = place(7, 1, {1, 0, 0, 0, 1, 0});
  materials[9].normal_texture = place(2, 0, {0, -1, 1, 1, 0, 0});
  return materials;
}

// Texture coordinates: plain, mirrored, of no area, huge, tiny.
Vec2f rich_uv(Vec3f p, std::uint32_t triangle) {
  switch (triangle % 5) {
    case 0:
      return {p.x, p.y + p.z};
    case 1:
      return {-p.x, p.y - p.z};
    case 2:
      return {0.3f, 0.4f};
    case 3:
      return {p.x * 3e38f, p.y * 1e30f};
    default:
      return {p.x * 1e-6f, 7 + p.z * 1e-6f};
  }
}

// A mesh with several materials and kinds of texture coordinates, triangle by triangle, and another
// without any. Both are there as they are, turned, and turned inside out.
std::shared_ptr<const PreparedScene> make_rich_scene() {
  const Mesh torus = test::make_torus(30, 13);
  Mesh mesh, plain = torus;
  for (std::uint32_t i = 0; i < torus.triangles.size(); ++i) {
    const auto first = static_cast<std::uint32_t>(mesh.positions.size());
    for (const std::uint32_t vertex : torus.triangles[i]) {
      const Vec3f p = torus.positions[vertex];
      mesh.positions.push_back(p);
      // Some normals point behind the surface, some are zero.
      mesh.normals.push_back(i % 11 == 0 ? Vec3f{} : normalize(p + Vec3f{0.1f, 0.2f, 0}));
      mesh.uvs.push_back(rich_uv(p, i));
      mesh.uvs1.push_back(rich_uv({p.z, p.x, p.y}, i / 5));
    }
    mesh.triangles.push_back({first, first + 1, first + 2});
    mesh.materials.push_back(i * 7 % kRichMaterials);
  }
  plain.normals.clear();
  plain.uvs.clear();
  plain.uvs1.clear();
  plain.materials = {4};
  Scene scene = test::make_scene(mesh);
  scene.meshes.push_back(std::make_shared<const Mesh>(plain));
  scene.materials = rich_materials();
  scene.textures = {random_texture(37, 11, true, 0),   random_texture(64, 32, false, 3),
                    random_texture(16, 16, false, 0),  random_texture(1, 5, true, 2),
                    random_texture(256, 256, true, 3), random_texture(1, 1, false, 1),
                    random_texture(37, 11, true, 1),   random_texture(40, 9, false, 2)};
  Instance turned, inside_out, other;
  turned.object_to_world.m = {{{0, -2, 0, 3}, {2, 0, 0.5f, 1}, {0, 0, 2, -3}}};
  inside_out.object_to_world.m = {{{-1, 0, 0, -3}, {0, 2, 0, 1}, {0, 0.5f, 1, 3}}};
  other.mesh = 1;
  other.object_to_world.m = {{{1, 0, 0, 0}, {0, 0, 1, 3}, {0, 1, 0, 0}}};
  scene.instances.insert(scene.instances.end(), {turned, inside_out, other});
  return *PreparedScene::build(scene, {});
}

// A cone mostly of the size of texels, at times of no size, wider than everything, or NaN.
RayCone random_cone(std::mt19937& random) {
  std::uniform_real_distribution<float> unit(0, 1);
  const float inf = std::numeric_limits<float>::infinity();
  const float odd[] = {0, 1e30f, inf, std::numeric_limits<float>::quiet_NaN()};
  const float width = random() % 8 == 0 ? odd[random() % 4] : std::exp2(12 * unit(random) - 11);
  return {width, 0.01f * unit(random)};
}

void expect_same(const Surface& a, const Surface& b) {
  EXPECT_TRUE(same_bits(a.point, b.point) && same_bits(a.normal, b.normal));
  EXPECT_TRUE(same_bits(a.shading_normal, b.shading_normal));
  EXPECT_TRUE(same_bits(a.albedo, b.albedo)) << a.albedo.x << " " << b.albedo.x;
  EXPECT_TRUE(same_bits(a.emission, b.emission) && same_bits(a.to_viewer, b.to_viewer));
  EXPECT_TRUE(
      same_bits({a.roughness, a.metalness, a.offset}, {b.roughness, b.metalness, b.offset}));
  EXPECT_TRUE(same_bits({a.cone.width, a.cone.spread, 0}, {b.cone.width, b.cone.spread, 0}));
  EXPECT_TRUE(a.bsdf == b.bsdf && a.material == b.material && a.instance == b.instance);
  EXPECT_EQ(a.is_front, b.is_front);
}

// A surface is the same whatever other rays of the packet have hit, and whether they are asked for.
TEST(Surfaces, RichSurfacesOfPacketsAreThoseOfEachRayAlone) {
  const auto prepared = make_rich_scene();
  const PreparedScene::Impl& scene = prepared->impl();
  for (const Isa isa : test::isas_here()) {
    const KernelTable& kernels = kernels_for(isa);
    const SceneTracer tracer(scene.index, kernels);
    MetSurfaces::Memory memory;
    MetSurfaces met(scene, kernels, memory);
    std::mt19937 random(test::seed(13));
    int compared = 0;
    for (int round = 0; round < 3000; ++round) {
      const RayPacket rays = random_packet(random, round % 2 == 0);
      PacketHits hits;
      tracer.closest(rays, hits);
      met.find(rays, hits);
      const bool has_cones = round % 3 != 0;
      RayCone cones[kPacketRays];
      Surface surface[kPacketRays];
      Surface* to[kPacketRays];
      for (int i = 0; i < kPacketRays; ++i) {
        cones[i] = random_cone(random);
        to[i] = &surface[i];
      }
      const std::uint64_t asked =
          met.points().met & (std::uint64_t{random()} << 32 | std::uint64_t{random()});
      met.make(rays, hits, asked, has_cones ? cones : nullptr, to);
      for (std::uint64_t left = asked; left != 0; left &= left - 1) {
        const int i = std::countr_zero(left);
        const RayCone cone = has_cones ? cones[i].advanced(met.points().distance[i]) : RayCone{};
        expect_same(surface[i],
                    test::plain_surface(scene, hits.primitive[i], met.points().u[i],
                                        met.points().v[i], at(rays.direction, i), cone));
        ++compared;
      }
      if (testing::Test::HasFailure()) return;
    }
    EXPECT_GT(compared, 20000) << isa_name(isa);
  }
}

// Every pixel of a part has one ray in one packet, through its own place, with its own key.
TEST(Surfaces, CameraPacketsCoverAPartWithEachPixelsOwnRay) {
  const auto prepared = make_scene();
  FrameSettings settings;
  settings.width_px = 1000;
  settings.height_px = 700;
  settings.camera = {{0.3f, 3, 2.5f}, {0.1f, 0, 0}, {0.1f, 1, 0}, 40};
  settings.seed = 77;
  const CameraRays camera(settings.camera, settings.width_px, settings.height_px);
  std::mt19937 random(test::seed(12));
  for (const Isa isa : test::isas_here()) {
    const SceneTracer tracer(prepared->impl().index, kernels_for(isa));
    for (int round = 0; round < 200; ++round) {
      settings.samples_per_pixel = round % 4 == 0 ? 1 : 5;
      settings.pass = static_cast<std::uint32_t>(round % 3);
      const auto below = [&](unsigned limit) { return static_cast<int>(random() % limit); };
      const TileRect part{below(900), below(600), 1 + below(32), 1 + below(32)};
      const auto sample =
          static_cast<std::uint32_t>(settings.samples_per_pixel == 1 ? 0 : below(5));
      FrameLight light;
      const RenderContext context{prepared->impl(), tracer, settings, camera, light};
      CameraPacket packet(context);
      packet.enter(part);
      ASSERT_EQ(packet.width_px() * packet.height_px(), kPacketRays);
      std::set<std::pair<int, int>> seen;
      for (int y = part.y_px; y < part.y_px + part.height_px; y += packet.height_px()) {
        for (int x = part.x_px; x < part.x_px + part.width_px; x += packet.width_px()) {
          packet.set(x, y, sample);
          for (int i = 0; i < kPacketRays; ++i) {
            if ((packet.rays.active >> i & 1u) == 0) continue;
            const int px = x + packet.column(i), py = y + packet.row(i);
            ASSERT_TRUE(seen.insert({px, py}).second);
            const bool is_centre = settings.samples_per_pixel == 1 && settings.pass == 0;
            const Vec2f in = is_centre
                                 ? Vec2f{0.5f, 0.5f}
                                 : sample_2d(pixel_key(77, px, py, dimension(Dimension::kLens)),
                                             sequence_index(settings, sample));
            const Vec3f direction = camera.direction(double{in.x} + px, double{in.y} + py);
            ASSERT_TRUE(same_bits(direction, at(packet.rays.direction, i))) << isa_name(isa);
            ASSERT_EQ(packet.key[i], pixel_key(77, px, py, dimension(Dimension::kSurface)));
          }
        }
      }
      ASSERT_EQ(seen.size(), static_cast<std::size_t>(part.pixel_count()));
      for (const auto& [px, py] : seen) {
        ASSERT_TRUE(px >= part.x_px && px < part.x_px + part.width_px && py >= part.y_px &&
                    py < part.y_px + part.height_px);
      }
    }
  }
}

}  // namespace
}  // namespace tessera::core
