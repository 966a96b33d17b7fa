// SPDX-License-Identifier: Apache-2.0
#include "master/import/gltf/lights.h"

#include <cmath>

#include "common/base/limits.h"
#include "common/scene/pose.h"
#include "common/scene/validate.h"

namespace tessera::import {
namespace {

constexpr double kPi = 3.14159265358979323846;
constexpr std::size_t kNameBytesMax = 256;
constexpr const char* kLightsExtension = "KHR_lights_punctual";

// The lamp of a node as "light 2 'Key'": its messages name the lamp and not the node.
GltfObject lamp_at(const GltfDocument& document, const GltfObject& node) {
  const GltfObject use = node.extension(kLightsExtension);
  use.check_keys({"light"}, {});
  const auto lamps = document.root().extension(kLightsExtension).objects("lights");
  if (!use.has("light")) {
    use.warn("light", "is missing, and the lamp is left out");
    return {};
  }
  const auto index = use.index("light", lamps.size(), "the lamp is left out");
  return index ? lamps[*index].named("light " + std::to_string(*index)) : GltfObject();
}

void set_cone(const GltfObject& lamp, Light& light) {
  const GltfObject spot = lamp.object("spot");
  spot.check_keys({"innerConeAngle", "outerConeAngle"}, {});
  // The outer angle is 45 degrees where nothing is said, 90 at most.
  const double outer = spot.number("outerConeAngle", kPi / 4, {0, kPi / 2 + 1e-6, true});
  double inner = spot.number("innerConeAngle", 0, {0, kPi / 2 + 1e-6});
  if (inner > outer) {
    spot.warn("innerConeAngle", "is more than outerConeAngle, which is used for both");
    inner = outer;
  }
  light.cos_inner = static_cast<float>(std::cos(inner));
  light.cos_outer = static_cast<float>(std::cos(outer));
}

}  // namespace

void add_light(const GltfDocument& document, const GltfObject& node, const Transform& to_world,
               Scene& scene) {
  if (!node.extension(kLightsExtension).is_there()) return;
  const GltfObject lamp = lamp_at(document, node);
  if (!lamp.is_there()) return;
  lamp.check_keys({"color", "intensity", "type", "range", "spot"}, {});
  Light light;
  const std::string type = lamp.text("type");
  if (type == "directional") {
    light.kind = LightKind::kDirectional;
  } else if (type == "spot") {
    light.kind = LightKind::kSpot;
    set_cone(lamp, light);
  } else if (type != "point") {
    return lamp.warn("type", "is '" + printable(type) +
                                 "'; it must be point, spot or directional; the lamp is left out");
  }
  if (lamp.has("range"))
    lamp.warn("range", "is a hint that is not followed: light reaches as far as it goes");
  const auto color = lamp.reals<3>("color", {1, 1, 1}, kShare);
  const float power = lamp.real("intensity", 1, kFromZero) / kLumensPerWatt;
  light.intensity = power * Vec3f{color[0], color[1], color[2]};
  light.position = to_world.point({0, 0, 0});
  light.direction = normalize(to_world.direction({0, 0, -1}));
  const bool is_good = is_finite(light.position) && is_finite(light.direction) &&
                       is_finite(light.intensity) && length(light.direction) > 0;
  if (!is_good)
    return node.warn("scale", "leaves its lamp no place or direction; the lamp is left out");
  if (scene.lights.size() >= kLightsMax)
    return node.warn("extensions", "hold more lamps than there may be; the lamp is left out");
  scene.lights.push_back(light);
}

void add_camera(const GltfDocument& document, const GltfObject& node, const Transform& to_world,
                Scene& scene) {
  const auto index = node.index("camera", document.count("cameras"), "the camera is left out");
  if (!index) return;
  const GltfObject source = document.at("cameras", *index);
  source.check_keys({"orthographic", "perspective", "type"}, {});
  const std::string type = source.text("type");
  if (type == "orthographic")
    return source.warn("type", "is orthographic, which is not drawn; the camera is left out");
  if (type != "perspective")
    return source.warn(
        "type", "is '" + printable(type) + "'; it must be perspective; the camera is left out");
  const GltfObject perspective = source.object("perspective");
  // Only yfov is used: a pinhole camera sees all depths, and the picture's size decides the aspect.
  perspective.check_keys({"aspectRatio", "yfov", "zfar", "znear"}, {});
  if (!perspective.has("yfov"))
    return source.warn("perspective.yfov", "is missing; the camera is left out");
  NamedCamera named;
  named.name = node.text("name");
  if (named.name.empty()) named.name = source.text("name");
  if (named.name.empty()) named.name = "camera " + std::to_string(*index);
  named.name.resize(std::min(named.name.size(), kNameBytesMax));
  const double yfov = perspective.number("yfov", 0.8, {0, kPi, true});
  named.camera = camera_of(to_world, static_cast<float>(yfov * 180 / kPi));
  if (!validate_camera(named.camera).is_ok())
    return node.warn("camera", "stands where no camera can be; it is left out");
  if (scene.cameras.size() >= kCamerasMax)
    return node.warn("camera", "is one of more than there may be; it is left out");
  if (!scene.camera) scene.camera = named.camera;
  scene.cameras.push_back(std::move(named));
}

}  // namespace tessera::import
