// SPDX-License-Identifier: Apache-2.0
#include "master/import/gltf/reader.h"

#include "master/import/gltf/document.h"
#include "master/import/gltf/extensions.h"
#include "master/import/gltf/materials.h"
#include "master/import/gltf/motion.h"
#include "master/import/gltf/nodes.h"

namespace tessera::import {
namespace {

// A list of names that a person can read: "'a', 'b' and 17 more".
std::string listed(const std::vector<std::string>& names) {
  constexpr std::size_t kShownMax = 8;
  std::string text;
  for (std::size_t i = 0; i < std::min(names.size(), kShownMax); ++i)
    text += (i > 0 ? ", '" : "'") + printable(names[i]) + "'";
  if (names.size() > kShownMax)
    text += " and " + std::to_string(names.size() - kShownMax) + " more";
  return text;
}

std::string name_of(const GltfObject& object, std::size_t index) {
  const std::string name = object.text("name");
  return name.empty() ? std::to_string(index) : name;
}

// The roots of the scene that is drawn: the default scene, else the first. Without scenes every
// node that has no parent is a root.
Result<std::vector<std::uint32_t>> roots_of(GltfDocument& document) {
  const std::size_t node_count = document.count("nodes");
  const std::size_t scene_count = document.count("scenes");
  const std::size_t drawn =
      document.root().index("scene", scene_count, "the first scene is drawn").value_or(0);
  if (scene_count > 0) {
    const GltfObject scene = document.at("scenes", drawn);
    scene.check_keys({"nodes"}, {"KHR_xmp_json_ld"});
    std::vector<std::string> others;
    for (std::size_t i = 0; i < scene_count; ++i) {
      if (i != drawn) others.push_back(name_of(document.at("scenes", i), i));
    }
    if (!others.empty())
      document.warnings().add("scenes", "holds several scenes; '" +
                                            printable(name_of(scene, drawn)) +
                                            "' is drawn, and not " + listed(others));
    return scene.refused_indices("nodes", node_count);
  }
  std::vector<bool> is_child(node_count, false);
  for (std::size_t i = 0; i < node_count; ++i) {
    const auto children = document.at("nodes", i).refused_indices("children", node_count);
    if (!children.is_ok()) return children.status();
    for (const std::uint32_t child : *children) is_child[child] = true;
  }
  std::vector<std::uint32_t> roots;
  for (std::size_t i = 0; i < node_count; ++i) {
    if (!is_child[i]) roots.push_back(static_cast<std::uint32_t>(i));
  }
  return roots;
}

void name_variants(GltfDocument& document) {
  const GltfObject extension = document.root().extension("KHR_materials_variants");
  extension.check_keys({"variants"}, {});
  const auto variants = extension.objects("variants");
  std::vector<std::string> names;
  for (std::size_t i = 0; i < variants.size(); ++i) names.push_back(name_of(variants[i], i));
  if (!names.empty())
    document.warnings().add("variants", "holds the variants " + listed(names) +
                                            " (KHR_materials_variants); its default is drawn");
}

Result<ReadScene> read(const std::string& path, PictureDecoder decode, WarningGroup& warnings) {
  auto opened = GltfDocument::open(path, warnings);
  if (!opened.is_ok()) return opened.status();
  GltfDocument& document = **opened;
  TESSERA_RETURN_IF_ERROR(check_extensions(document));
  document.root().check_keys(
      {"asset", "scene", "scenes", "nodes", "meshes", "accessors", "bufferViews", "buffers",
       "materials", "textures", "images", "samplers", "cameras", "animations", "skins",
       "extensionsUsed", "extensionsRequired"},
      {"KHR_lights_punctual", "KHR_materials_variants", "KHR_xmp_json_ld", "KHR_interactivity"});
  document.root().extension("KHR_lights_punctual").check_keys({"lights"}, {});
  ReadScene result;
  GltfTextures textures(document, std::move(decode), result.scene);
  GltfMaterials materials(document, textures, result.scene);
  GltfMotion motion(document, result.scene);
  GltfNodes nodes(document, materials, motion, result.scene);
  const auto roots = roots_of(document);
  if (!roots.is_ok()) return roots.status();
  TESSERA_RETURN_IF_ERROR(nodes.walk(*roots));
  TESSERA_RETURN_IF_ERROR(motion.finish());
  name_variants(document);
  if (result.scene.triangle_count() == 0)
    return Status::invalid_argument(document.count("meshes") == 0 ? "holds no meshes"
                                                                  : "holds no triangles");
  if (nodes.degenerate_count() > 0)
    warnings.add("degenerate", std::to_string(nodes.degenerate_count()) +
                                   " degenerate triangles have no area and are never hit");
  return result;
}

}  // namespace

Result<ReadScene> read_gltf(const std::string& path, PictureDecoder decode) {
  WarningGroup warnings(path);
  auto result = read(path, std::move(decode), warnings);
  if (!result.is_ok()) {
    const std::string& text = result.status().message();
    // An error of the file system begins with the file's name already.
    if (text.starts_with(path + ":")) return result;
    return Status(result.status().code(), path + ": " + text);
  }
  result->warnings = warnings.lines();
  return result;
}

}  // namespace tessera::import
