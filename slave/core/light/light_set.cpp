#include "slave/core/light/light_set.h"

#include <algorithm>

#include "common/math/rounding.h"

namespace tessera::core {
namespace {

void add_emitters(const Mesh& mesh, const Scene& scene, std::uint64_t first,
                  const TriangleStore& triangles, std::span<const std::uint64_t> left_out,
                  std::vector<Emitter>& out) {
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
    const std::uint32_t material =
        mesh.materials.size() == 1 ? mesh.materials[0] : mesh.materials[i];
    const Vec3f emission = scene.materials[material].emission;
    if (is_black(emission) || std::binary_search(left_out.begin(), left_out.end(), first + i))
      continue;
    Emitter e;
    e.a = triangles.vertex(first + i, 0);
    e.edge_b = triangles.vertex(first + i, 1) - e.a;
    e.edge_c = triangles.vertex(first + i, 2) - e.a;
    const Vec3f normal = cross(e.edge_b, e.edge_c);
    const float twice_area = length(normal);
    if (!(twice_area > 0))
      continue;  // too small for float32: sheds no light that could be measured
    e.normal = normal * (1 / twice_area);
    e.area = twice_area / 2;
    e.emission = emission;
    out.push_back(e);
  }
}

// Rec. 709 luminance.
double luminance(Vec3f c) { return 0.2126 * c.x + 0.7152 * c.y + 0.0722 * c.z; }

void share_out(LightSet& set) {
  for (const Emitter& e : set.emitters) set.power += luminance(e.emission) * e.area;
  double sum = 0;
  for (const Emitter& e : set.emitters) {
    sum += luminance(e.emission) * e.area / set.power;
    set.cumulative.push_back(static_cast<float>(sum));
  }
  set.cumulative.back() = 1;
  // The chance that pick() really gives, so that rounding of the sums does not bias the mean.
  float below = 0;
  for (std::size_t i = 0; i < set.emitters.size(); ++i) {
    set.emitters[i].share = set.cumulative[i] - below;
    below = set.cumulative[i];
  }
}

}  // namespace

const Emitter& LightSet::pick(float x, float& rest) const {
  const auto it = std::upper_bound(cumulative.begin(), cumulative.end() - 1, x);
  const auto number = static_cast<std::size_t>(it - cumulative.begin());
  const Emitter& e = emitters[number];
  const float below = number == 0 ? 0 : cumulative[number - 1];
  rest = std::clamp((x - below) / e.share, 0.0f, 1 - kUnitRoundoff);
  return e;
}

float LightSet::density_by_area(Vec3f emission, float area, bool is_picked) const {
  return is_picked ? static_cast<float>(luminance(emission) / power) : 1 / area;
}

LightSet make_light_set(const Scene& scene, const TriangleStore& triangles,
                        std::span<const std::uint64_t> left_out) {
  LightSet set;
  set.lights = scene.lights;
  set.environment = scene.environment;
  set.has_environment = !is_black(scene.environment);
  for (Light& light : set.lights) light.direction = normalize(light.direction);
  bool has_emission = false;
  for (const Material& material : scene.materials) has_emission |= !is_black(material.emission);
  if (!has_emission) return set;
  for (std::size_t i = 0; i < scene.instances.size(); ++i) {
    add_emitters(*scene.meshes[scene.instances[i].mesh], scene, triangles.instance_first[i],
                 triangles, left_out, set.emitters);
  }
  if (!set.emitters.empty()) share_out(set);
  return set;
}

}  // namespace tessera::core
