// SPDX-License-Identifier: Apache-2.0
// Materials of Assimp as materials of the scene.
// Threads. One.
#pragma once

#include <assimp/material.h>

#include "common/scene_io/scene_pictures.h"
#include "common/scene_io/warning_group.h"

namespace tessera::import {

// Warnings name the material.
Material material_of(const aiMaterial& from, ScenePictures& pictures, WarningGroup& warnings);

}  // namespace tessera::import
