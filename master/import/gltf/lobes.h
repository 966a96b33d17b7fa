// SPDX-License-Identifier: Apache-2.0
// Reads the material extensions of glTF 2.0, each into the part of a scene's material that it
// describes. An extension that a material lacks leaves its part absent.
// Threads. One.
#pragma once

#include "common/scene/scene.h"
#include "master/import/gltf/object.h"
#include "master/import/gltf/textures.h"

namespace tessera::import {

// `material` is an element of "materials"; `surface` already has what the core format says of it.

// KHR_materials_ior and KHR_materials_specular: ior, specular, specular_f90 and their textures.
void read_reflectance(const GltfObject& material, GltfTextures& textures, Material& surface);
void read_clearcoat(const GltfObject& material, GltfTextures& textures, Clearcoat& clearcoat);
void read_sheen(const GltfObject& material, GltfTextures& textures, Sheen& sheen);
// KHR_materials_transmission and KHR_materials_volume.
void read_transmission(const GltfObject& material, GltfTextures& textures,
                       Transmission& transmission);
void read_anisotropy(const GltfObject& material, GltfTextures& textures, Anisotropy& anisotropy);
// KHR_materials_pbrSpecularGlossiness, which takes the place of metallic-roughness.
// Returns: the factor and texture of opacity in the alpha of its diffuse colour.
float read_specular_glossiness(const GltfObject& extension, GltfTextures& textures,
                               Material& surface);
// Adds one warning for each extension that is known and not drawn.
void name_what_is_not_drawn(const GltfObject& material);

}  // namespace tessera::import
