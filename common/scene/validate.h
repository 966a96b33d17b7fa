// SPDX-License-Identifier: Apache-2.0
// The border of scenes and cameras: what passes here is trusted behind it. The functions are called
// once where a scene enters: by the session for applications, by the decoder for peers, by the
// import process for files.
// Threads. Pure functions; SceneValidator: one at a time.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <unordered_map>
#include <vector>

#include "common/base/api.h"
#include "common/base/status.h"
#include "common/math/bounds3.h"
#include "common/scene/scene.h"

namespace tessera {

// Checks counts against limits.h, indices, array lengths, and that every number is finite.
// Returns: kInvalidArgument or kResourceExhausted naming the element.
TESSERA_API Status validate_scene(const Scene& scene);

// validate_scene() for version after version: what is shared with a scene before, and was found
// good there, is not looked at again, so that a change costs what it changes, and a comparison of
// each object and instance with that of the same number before. Its verdict is that of
// validate_scene().
class TESSERA_API SceneValidator {
 public:
  Status validate(const Scene& scene);

 private:
  // A mesh, surface, texture or environment map that is good.
  struct Good {
    std::weak_ptr<const void> object;
    std::size_t materials_needed = 0;
    Bounds3f box;  // of what is flattened, in the object's own space
  };
  // The good object of a number in the scene before, which was another one where it has changed.
  struct Place {
    const void* address = nullptr;
    Good good;
    bool has_changed = true;

    // Of two objects that share one owner, each has its address.
    template <class Object>
    bool is(const std::shared_ptr<const Object>& object) const {
      return object != nullptr && address == object.get() && !good.object.owner_before(object) &&
             !object.owner_before(good.object);
    }
  };
  // Instances of the scene before. Shape: [instance].
  struct Seen {
    std::vector<Instance> instances;
    std::vector<std::uint8_t> is_far;  // so far out that only all of them together can tell
    std::size_t mesh_count = 0, surface_count = 0;  // that they could be of
  };

  template <class Object, class Check>
  Status look_at(const std::shared_ptr<const Object>& object, const std::string& name,
                 std::size_t material_count, Check check);
  template <class Object, class Check>
  Status look_at_all(const std::vector<std::shared_ptr<const Object>>& objects, const char* what,
                     std::size_t material_count, std::vector<Place>& places, const Check& check);
  Status validate_objects(const Scene& scene);
  Status validate_instances(const Scene& scene, Seen seen);
  Status validate_size(const Scene& scene) const;
  const Place* place_of(const Instance& instance) const;  // null: of no object that is there

  std::unordered_map<const void*, Good> good_;
  std::vector<Place> meshes_, surfaces_, textures_;  // by their numbers
  Seen seen_;                                        // empty where the scene before was not good
};

// `name` opens the line. Returns: kInvalidArgument naming the light's field.
Status validate_light(const Light& light, const std::string& name);

// Returns: kInvalidArgument saying which rule of Camera is broken.
TESSERA_API Status validate_camera(const Camera& camera);

// Box of all flattened triangles, and of the control points of all flattened patches, between which
// the patches lie; empty for a scene without any.
TESSERA_API Bounds3f scene_bounds(const Scene& scene);

}  // namespace tessera
