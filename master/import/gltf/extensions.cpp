// SPDX-License-Identifier: Apache-2.0
#include "master/import/gltf/extensions.h"

#include <algorithm>

namespace tessera::import {
namespace {

struct Extension {
  const char* name;
  // What a file that uses the extension loses. Null: nothing, or each object that has it warns.
  const char* loss;
};

constexpr Extension kExtensions[] = {
    {"KHR_materials_unlit", nullptr},
    {"KHR_materials_emissive_strength", nullptr},
    {"KHR_materials_ior", nullptr},
    {"KHR_materials_transmission", nullptr},
    {"KHR_materials_volume", nullptr},
    {"KHR_materials_clearcoat", nullptr},
    {"KHR_materials_sheen", nullptr},
    {"KHR_materials_specular", nullptr},
    {"KHR_materials_anisotropy", nullptr},
    {"KHR_materials_pbrSpecularGlossiness", nullptr},
    {"KHR_materials_variants", nullptr},
    {"KHR_texture_transform", nullptr},
    {"KHR_lights_punctual", nullptr},
    {"KHR_mesh_quantization", nullptr},
    {"KHR_draco_mesh_compression", nullptr},
    {"KHR_node_visibility", nullptr},
    {"EXT_mesh_gpu_instancing", nullptr},
    {"EXT_meshopt_compression", nullptr},
    {"EXT_texture_webp", nullptr},
    // Texts about the file, which no picture shows.
    {"KHR_xmp_json_ld", nullptr},
    // Each material or texture that has one of these warns of it.
    {"KHR_materials_iridescence", nullptr},
    {"KHR_materials_dispersion", nullptr},
    {"KHR_materials_diffuse_transmission", nullptr},
    {"KHR_texture_basisu", nullptr},
    {"KHR_animation_pointer", "nothing moves"},
    {"KHR_interactivity", "nothing answers to a person"},
    {"KHR_node_hoverability", "nothing answers to a person"},
    {"KHR_node_selectability", "nothing answers to a person"},
};

const Extension* find(const std::string& name) {
  const auto* const found = std::find_if(std::begin(kExtensions), std::end(kExtensions),
                                         [&name](const Extension& e) { return e.name == name; });
  return found == std::end(kExtensions) ? nullptr : found;
}

}  // namespace

Status check_extensions(GltfDocument& document) {
  for (const std::string& name : document.root().texts("extensionsRequired")) {
    if (find(name) == nullptr) {
      return Status::unimplemented("requires the extension " + printable(name) +
                                   ", which is not known here; export the file without it");
    }
  }
  for (const std::string& name : document.root().texts("extensionsUsed")) {
    const Extension* extension = find(name);
    if (extension != nullptr && extension->loss == nullptr) continue;
    document.warnings().add_once(
        "extension " + name,
        "uses the extension " + printable(name) +
            (extension == nullptr ? ", which is not known here; what it says is not drawn"
                                  : std::string(", which is not followed: ") + extension->loss));
  }
  return Status::ok();
}

}  // namespace tessera::import
