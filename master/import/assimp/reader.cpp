// SPDX-License-Identifier: Apache-2.0
#include "master/import/assimp/reader.h"

#include <assimp/config.h>
#include <assimp/postprocess.h>
#include <assimp/scene.h>

#include <algorithm>
#include <assimp/Importer.hpp>
#include <cmath>
#include <map>
#include <numbers>
#include <optional>
#include <utility>

#include "common/scene/validate.h"
#include "common/scene_io/vertex_color.h"
#include "common/scene_io/warning_group.h"
#include "master/import/assimp/materials.h"

namespace tessera::import {
namespace {

Vec3f vec(const aiVector3D& v) { return {v.x, v.y, v.z}; }

Transform transform_of(const aiMatrix4x4& m) {
  Transform t;
  t.m = {{{m.a1, m.a2, m.a3, m.a4}, {m.b1, m.b2, m.b3, m.b4}, {m.c1, m.c2, m.c3, m.c4}}};
  return t;
}

// Keeps only the importer of the format: others would be tried on bytes of which they know nothing.
bool keep_only(Assimp::Importer& importer, const char* suffix) {
  for (std::size_t i = importer.GetImporterCount(); i-- > 0;) {
    Assimp::BaseImporter* const one = importer.GetImporter(i);
    if (one != importer.GetImporter(suffix)) importer.UnregisterLoader(one);
  }
  return importer.GetImporterCount() == 1;
}

class Reader {
 public:
  Reader(const std::string& path, const aiScene& from, const TextureLoader& load,
         const PictureDecoder& decode)
      : path_(path),
        from_(from),
        warnings_(path),
        load_([&](const std::string& name) { return picture(name, load, decode); }),
        pictures_(result_.scene, load_) {
    pictures_.set_warnings(&warnings_);
  }

  Result<ReadScene> read() {
    add_materials();
    meshes_.resize(from_.mNumMeshes);
    if (from_.mRootNode != nullptr) walk();
    if (result_.scene.instances.empty())
      return Status::invalid_argument(path_ + ": holds no triangles");
    add_lights();
    name_what_is_not_drawn();
    result_.warnings = warnings_.lines();
    std::uint64_t degenerate = 0;
    for (const auto& mesh : result_.scene.meshes) degenerate += count_degenerate(*mesh);
    warn_degenerate(degenerate, result_.warnings);
    return std::move(result_);
  }

 private:
  static constexpr std::uint32_t kNoMesh = 0xffffffffu;

  // A picture that the file holds, else a file beside it. Where its name is a path of another
  // machine, the last part of that path is looked for, also in the folder "textures".
  Result<std::shared_ptr<const Texture>> picture(const std::string& name, const TextureLoader& load,
                                                 const PictureDecoder& decode) const {
    if (const aiTexture* held = from_.GetEmbeddedTexture(name.c_str())) {
      if (held->mHeight != 0)
        return Status::unimplemented("is held without a format, which is not read");
      return decode({reinterpret_cast<const std::byte*>(held->pcData), held->mWidth});
    }
    std::string file = name;
    std::replace(file.begin(), file.end(), '\\', '/');
    auto texture = load(file);
    if (texture.is_ok()) return texture;
    const std::string last = file.substr(file.rfind('/') + 1);
    for (const std::string& other : {last, "textures/" + last}) {
      if (other == file || last.empty()) continue;
      if (auto found = load(other); found.is_ok()) return found;
    }
    return texture;
  }

  void add_materials() {
    for (unsigned i = 0; i < from_.mNumMaterials; ++i)
      result_.scene.materials.push_back(material_of(*from_.mMaterials[i], pictures_, warnings_));
    if (result_.scene.materials.empty()) result_.scene.materials.emplace_back();
  }

  // Adds all nodes; a mesh is converted at the first node that shows it. A list of nodes that are
  // left takes the place of recursion, since files nest nodes as deep as they like.
  void walk() {
    std::vector<std::pair<const aiNode*, Transform>> left{{from_.mRootNode, Transform{}}};
    while (!left.empty()) {
      const auto [node, above] = left.back();
      left.pop_back();
      const Transform to_world = above * transform_of(node->mTransformation);
      add_camera(*node, to_world);
      places_.emplace(node->mName.C_Str(), to_world);
      for (unsigned i = 0; i < node->mNumMeshes; ++i) {
        const std::uint32_t mesh = mesh_of(node->mMeshes[i]);
        if (mesh != kNoMesh) result_.scene.instances.push_back({mesh, to_world});
      }
      for (unsigned i = node->mNumChildren; i-- > 0;)
        left.emplace_back(node->mChildren[i], to_world);
    }
  }

  std::uint32_t mesh_of(unsigned number) {
    if (number >= from_.mNumMeshes) return kNoMesh;
    if (meshes_[number]) return *meshes_[number];
    const aiMesh& from = *from_.mMeshes[number];
    auto mesh = std::make_shared<Mesh>();
    bool has_others = false;
    for (unsigned i = 0; i < from.mNumFaces; ++i) {
      const aiFace& face = from.mFaces[i];
      if (face.mNumIndices != 3) {
        has_others = true;
        continue;
      }
      mesh->triangles.push_back({face.mIndices[0], face.mIndices[1], face.mIndices[2]});
    }
    if (has_others) warnings_.add("points", "points and lines have no surface and are not drawn");
    if (from.mNumBones > 0) has_skins_ = true;
    if (from.mNumAnimMeshes > 0) has_morphs_ = true;
    if (mesh->triangles.empty()) {
      meshes_[number] = kNoMesh;
      return kNoMesh;
    }
    for (unsigned i = 0; i < from.mNumVertices; ++i) {
      mesh->positions.push_back(vec(from.mVertices[i]));
      if (from.HasNormals()) mesh->normals.push_back(normal(vec(from.mNormals[i])));
      if (from.HasTextureCoords(0)) mesh->uvs.push_back(uv(from.mTextureCoords[0][i]));
      if (from.HasTextureCoords(1)) mesh->uvs1.push_back(uv(from.mTextureCoords[1][i]));
      if (!from.HasVertexColors(0)) continue;
      const aiColor4D& c = from.mColors[0][i];
      mesh->colors.push_back(std::isfinite(c.r + c.g + c.b + c.a) ? vertex_color(c.r, c.g, c.b, c.a)
                                                                  : Vec4f{1, 1, 1, 1});
    }
    const auto material_count = static_cast<std::uint32_t>(result_.scene.materials.size());
    mesh->materials = {std::min(from.mMaterialIndex, material_count - 1)};
    meshes_[number] = static_cast<std::uint32_t>(result_.scene.meshes.size());
    result_.scene.meshes.push_back(std::move(mesh));
    return *meshes_[number];
  }
  // A normal that is not finite becomes zero, which the renderer takes for the flat normal.
  static Vec3f normal(Vec3f n) { return is_finite(n) ? n : Vec3f{}; }
  static Vec2f uv(const aiVector3D& v) {
    return std::isfinite(v.x) && std::isfinite(v.y) ? Vec2f{v.x, v.y} : Vec2f{};
  }

  void add_camera(const aiNode& node, const Transform& to_world) {
    for (unsigned i = 0; i < from_.mNumCameras; ++i) {
      const aiCamera& from = *from_.mCameras[i];
      if (from.mName != node.mName) continue;
      const float aspect = from.mAspect > 0 ? from.mAspect : 1.5f;
      NamedCamera camera;
      camera.name = from.mName.C_Str();
      camera.camera.eye = to_world.point(vec(from.mPosition));
      camera.camera.target = camera.camera.eye + normalize(to_world.direction(vec(from.mLookAt)));
      camera.camera.up = to_world.direction(vec(from.mUp));
      camera.camera.vfov_degrees =
          std::atan(std::tan(from.mHorizontalFOV / 2) / aspect) * 360 / std::numbers::pi_v<float>;
      if (const Status status = validate_camera(camera.camera); !status.is_ok()) {
        warnings_.add("camera",
                      "camera '" + camera.name + "': " + status.message() + "; it is left out");
        continue;
      }
      if (!result_.scene.camera) result_.scene.camera = camera.camera;
      result_.scene.cameras.push_back(std::move(camera));
    }
  }

  void add_lights() {
    const Bounds3f bounds = scene_bounds(result_.scene);
    for (unsigned i = 0; i < from_.mNumLights; ++i) {
      const aiLight& from = *from_.mLights[i];
      const auto place = places_.find(from.mName.C_Str());
      const std::string name = "lamp '" + std::string(from.mName.C_Str()) + "'";
      if (from.mType != aiLightSource_POINT && from.mType != aiLightSource_SPOT &&
          from.mType != aiLightSource_DIRECTIONAL) {
        warnings_.add("lamp kind",
                      name + ": is neither a point, a spot nor a sun, and is not drawn");
        continue;
      }
      if (place == places_.end()) continue;  // no node shows it
      Light light;
      light.kind = from.mType == aiLightSource_POINT  ? LightKind::kPoint
                   : from.mType == aiLightSource_SPOT ? LightKind::kSpot
                                                      : LightKind::kDirectional;
      light.position = place->second.point(vec(from.mPosition));
      light.direction = place->second.direction(vec(from.mDirection));
      light.intensity = {from.mColorDiffuse.r, from.mColorDiffuse.g, from.mColorDiffuse.b};
      if (light.kind != LightKind::kDirectional)
        light.intensity = light.intensity * reach(from, name, length(bounds.extent()) / 2);
      if (light.kind == LightKind::kSpot) {
        const float outer = std::clamp(from.mAngleOuterCone / 2, 0.0f, std::numbers::pi_v<float>);
        light.cos_outer = std::cos(outer);
        light.cos_inner = std::cos(std::clamp(from.mAngleInnerCone / 2, 0.0f, outer));
      }
      if (!is_lamp(light)) {
        warnings_.add("lamp", name +
                                  ": its place, direction or strength is no number that a lamp can "
                                  "have; it is left out");
        continue;
      }
      result_.scene.lights.push_back(light);
    }
  }

  static bool is_lamp(const Light& light) {
    const Vec3f i = light.intensity;
    const bool has_way = light.kind == LightKind::kPoint || length(light.direction) > 0;
    return is_finite(light.position) && is_finite(light.direction) && is_finite(i) && i.x >= 0 &&
           i.y >= 0 && i.z >= 0 && has_way;
  }

  // The square of the distance at which a lamp's light is the colour that the file says. Light
  // falls off with the square of the distance; where the file asks for another law, both agree at
  // the distance `middle`.
  float reach(const aiLight& from, const std::string& name, float middle) {
    if (from.mAttenuationQuadratic > 0) return 1 / from.mAttenuationQuadratic;
    const float divided = from.mAttenuationConstant + from.mAttenuationLinear * middle;
    warnings_.add(
        "falloff",
        name +
            ": does not fall off with the square of the distance; it does here, and is as "
            "bright as the file says at half of the scene's diagonal");
    return middle * middle / (divided > 0 ? divided : 1);
  }

  void name_what_is_not_drawn() {
    if (from_.mNumAnimations > 0)
      warnings_.add("animation", "holds animations, which are not played: the rest pose is shown");
    if (has_skins_)
      warnings_.add("skin", "holds skins, which are not played: the rest pose is shown");
    if (has_morphs_)
      warnings_.add("morph", "holds morph targets, which are not played: the rest pose is shown");
    if ((from_.mFlags & AI_SCENE_FLAGS_INCOMPLETE) != 0)
      warnings_.add("incomplete", "is not complete; what there is is drawn");
  }

  const std::string path_;
  const aiScene& from_;
  ReadScene result_;
  WarningGroup warnings_;
  const TextureLoader load_;
  ScenePictures pictures_;
  std::vector<std::optional<std::uint32_t>> meshes_;  // by number of Assimp
  std::map<std::string, Transform> places_;           // of nodes, by name
  bool has_skins_ = false, has_morphs_ = false;
};

}  // namespace

Result<ReadScene> read_by_assimp(const std::string& path, FileFormat format,
                                 const TextureLoader& load_texture, const PictureDecoder& decode) {
  Assimp::Importer importer;
  if (!keep_only(importer, format == FileFormat::kFbx ? "fbx" : "dae"))
    return Status::unimplemented(path + ": this build's Assimp does not read the format");
  // Polygons are triangulated by ear clipping, and errors of the file's structure are found before
  // it is used.
  constexpr unsigned kSteps = aiProcess_Triangulate | aiProcess_ValidateDataStructure;
  const aiScene* const scene = importer.ReadFile(path, kSteps);
  if (scene == nullptr) {
    std::string reason = importer.GetErrorString();
    std::replace(reason.begin(), reason.end(), '\n', ' ');
    return Status::data_loss(path + ": " + reason);
  }
  return Reader(path, *scene, load_texture, decode).read();
}

}  // namespace tessera::import
