// SPDX-License-Identifier: Apache-2.0
// A scene that an application changes piece by piece: it says what is different, and not the whole
// scene again. Changes are gathered here and cost what they change; the scene that they make is
// read with scene(), and its frames are those of the same scene made in one go, whatever the order
// of the changes was.
//
// Objects (instances of meshes and surfaces) have names of their own, which stay when others are
// removed. Materials and lights are named by their place in the scene. Meshes and surfaces come
// with the first object that shows them, are shared by objects that show the same pointer, and go
// with the last one.
//
// Threads. One at a time. Invariants. (1) A change that is refused changes nothing. (2) scene() is
// valid (validate.h), where its box does not overflow. (3) What was read from scene() is never
// changed afterwards: a mesh whose vertices move is another object.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <unordered_map>
#include <vector>

#include "common/base/api.h"
#include "common/base/status.h"
#include "common/scene/flattened_counts.h"
#include "common/scene/scene.h"

namespace tessera {

using ObjectName = std::uint64_t;  // never used again for another object

class TESSERA_API SceneEdits {
 public:
  SceneEdits();  // of a scene without objects and lights, of one material
  // Begins with a scene, whose instances are named from 0 on in their order. Returns:
  // validate_scene()'s refusal.
  static Result<SceneEdits> of(Scene scene);

  // The scene with all changes. Whoever shares it by copying copies no mesh.
  const Scene& scene();

  // Each returns one line that names what is wrong: kNotFound for what is not there,
  // kInvalidArgument for values that cannot be, kResourceExhausted for too many of a kind.

  // object_to_world must be finite and have an inverse. An object that a node of the scene's
  // animation carries goes where the node goes.
  Status set_transform(ObjectName object, const Transform& object_to_world);
  // Moves the vertices from `first` on of the object's mesh, for all objects that share it.
  Status set_positions(ObjectName object, std::size_t first, std::span<const Vec3f> positions);
  // Likewise the normals, of a mesh that has some.
  Status set_normals(ObjectName object, std::size_t first, std::span<const Vec3f> normals);
  Status set_material(std::size_t material, const Material& value);
  Status set_light(std::size_t light, const Light& value);
  Status set_environment(Vec3f radiance);
  // What moves with time, or null.
  Status set_animation(std::shared_ptr<const SceneAnimation> animation);

  Result<ObjectName> add_object(std::shared_ptr<const Mesh> mesh, const Transform& object_to_world);
  Result<ObjectName> add_object(std::shared_ptr<const PatchSurface> surface,
                                const Transform& object_to_world);
  // Objects, and lights, of an animated scene are named by number in its animation, so none can be
  // removed before set_animation(nullptr).
  Status remove_object(ObjectName object);
  Result<std::size_t> add_material(const Material& value);
  Result<std::size_t> add_light(const Light& value);
  // The lights behind it move up.
  Status remove_light(std::size_t light);

 private:
  Result<std::size_t> place_of(ObjectName object) const;
  Status write(ObjectName object, std::vector<Vec3f> Mesh::*array, const char* what,
               std::size_t first, std::span<const Vec3f> values);
  Mesh& writable_mesh(std::uint32_t index);
  template <class Object>
  Result<ObjectName> add(std::vector<std::shared_ptr<const Object>>& objects, ObjectKind kind,
                         std::shared_ptr<const Object> object, const Transform& object_to_world);
  void drop_unused(ObjectKind kind, std::uint32_t index);
  Status refuse_removal(const char* what) const;

  Scene scene_;
  std::vector<ObjectName> names_;  // [instance], rising
  ObjectName next_name_ = 0;
  FlattenedCounts counts_;
  // Copies of meshes that nobody has read yet, so that they may be written to.
  std::unordered_map<const Mesh*, std::shared_ptr<Mesh>> unread_;
};

}  // namespace tessera
