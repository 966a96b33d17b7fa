#include "master/import/gltf_reader.h"

#include <assimp/GltfMaterial.h>
#include <assimp/postprocess.h>
#include <assimp/scene.h>

#include <assimp/DefaultIOSystem.h>
#include <assimp/Importer.hpp>
#include <cmath>
#include <filesystem>
#include <map>

#include "common/base/limits.h"
#include "common/scene_io/confined_path.h"
#include "common/scene_io/text_scanner.h"
#include "master/import/json_scan.h"
#include "master/import/texture_reader.h"

namespace tessera::import {
namespace {

constexpr int kNodeDepthMax = 64;
constexpr std::uint64_t kJsonBytesMax = std::uint64_t{4} << 30;

Vec3f vec(const aiVector3D& v) { return {v.x, v.y, v.z}; }

Transform transform(const aiMatrix4x4& m) {
  Transform t;
  t.m = {{{m.a1, m.a2, m.a3, m.a4}, {m.b1, m.b2, m.b3, m.b4}, {m.c1, m.c2, m.c3, m.c4}}};
  return t;
}

// Assimp's files: the scene's own folder and below it, for reading.
class ConfinedFiles : public Assimp::DefaultIOSystem {
 public:
  explicit ConfinedFiles(std::string folder) : folder_(folder.empty() ? "." : std::move(folder)) {}
  bool Exists(const char* file) const override { return is_inside(file); }
  Assimp::IOStream* Open(const char* file, const char* mode) override {
    return mode[0] == 'r' && is_inside(file) ? DefaultIOSystem::Open(file, mode) : nullptr;
  }

 private:
  bool is_inside(const char* file) const {
    const auto relative = std::filesystem::path(file).lexically_relative(folder_);
    const std::string name = folder_ == "." && relative.empty() ? file : relative.string();
    return confined_path(folder_, name).is_ok();
  }
  const std::string folder_;
};

class GltfReader {
 public:
  GltfReader(std::string path, const aiScene& source)
      : path_(std::move(path)),
        folder_(std::filesystem::path(path_).parent_path().string()),
        source_(source) {}

  Result<ReadScene> read() {
    read_emissive_strengths();
    for (unsigned i = 0; i < source_.mNumMaterials; ++i)
      add_material(*source_.mMaterials[i], i < strengths_.size() ? strengths_[i] : 1);
    if (scene_.materials.empty()) scene_.materials.emplace_back();
    for (unsigned i = 0; i < source_.mNumMeshes; ++i)
      TESSERA_RETURN_IF_ERROR(add_mesh(*source_.mMeshes[i], i));
    TESSERA_RETURN_IF_ERROR(walk(*source_.mRootNode, Transform{}, 0));
    add_lights();
    add_camera();
    if (scene_.triangle_count() == 0)
      return Status::invalid_argument(path_ + ": holds no triangles");
    warn_degenerate(degenerate_count_, result_.warnings);
    result_.scene = std::move(scene_);
    return std::move(result_);
  }

 private:
  // KHR_materials_emissive_strength, which Assimp 5.2 passes over: [material of the file]. Of a .glb
  // the text is the first chunk, behind 12 bytes of header and 8 of its own.
  void read_emissive_strengths() {
    const auto bytes = read_whole_file(path_, kJsonBytesMax);
    if (!bytes.is_ok()) return;
    std::string_view text = *bytes;
    if (text.starts_with("glTF")) text = text.substr(std::min<std::size_t>(20, text.size()));
    for (const std::string_view material : json_elements(json_member(text, "materials"))) {
      const std::string_view strength = json_member(
          json_member(json_member(material, "extensions"), "KHR_materials_emissive_strength"),
          "emissiveStrength");
      strengths_.push_back(json_number(strength).value_or(1));
    }
  }

  void add_material(const aiMaterial& source, float strength) {
    Material material;
    material.name = std::string(source.GetName().C_Str()).substr(0, 256);
    aiColor4D base(0.8f, 0.8f, 0.8f, 1);
    if (source.Get(AI_MATKEY_BASE_COLOR, base) != AI_SUCCESS)
      source.Get(AI_MATKEY_COLOR_DIFFUSE, base);
    material.albedo = max(min(Vec3f{base.r, base.g, base.b}, Vec3f{1, 1, 1}), Vec3f{});
    aiColor3D emission(0, 0, 0);
    source.Get(AI_MATKEY_COLOR_EMISSIVE, emission);
    const Vec3f glow = std::isfinite(strength) && strength >= 0
                           ? strength * Vec3f{emission.r, emission.g, emission.b}
                           : Vec3f{};
    if (is_finite(glow) && glow.x >= 0 && glow.y >= 0 && glow.z >= 0) material.emission = glow;
    aiString name;
    if (source.GetTexture(aiTextureType_BASE_COLOR, 0, &name) == AI_SUCCESS ||
        source.GetTexture(aiTextureType_DIFFUSE, 0, &name) == AI_SUCCESS) {
      material.albedo_texture = texture_index(name.C_Str(), true);
    }
    if (source.GetTexture(aiTextureType_EMISSIVE, 0, &name) == AI_SUCCESS) {
      material.emission_texture = texture_index(name.C_Str(), true);
      // Most of such a picture is dark, as a rule: without it there is no lamp.
      if (material.emission_texture == kNoTexture) material.emission = {};
    }
    set_scattering(source, material);
    warn_of_coordinates(source, material.name);
    scene_.materials.push_back(std::move(material));
  }

  // glTF 2.0, section 3.9: metallic-roughness; KHR_materials_transmission makes glass of it where it
  // lets more than half of the light through, since a surface here is one or the other.
  void set_scattering(const aiMaterial& source, Material& material) {
    const auto share = [&](const char* key, unsigned type, unsigned index, float fallback) {
      float value = fallback;
      source.Get(key, type, index, value);
      return value >= 0 && value <= 1 ? value : fallback;
    };
    aiString name;
    if (source.GetTexture(aiTextureType_NORMALS, 0, &name) == AI_SUCCESS) {
      material.normal_texture = texture_index(name.C_Str(), false);
      float scale = 1;
      source.Get(AI_MATKEY_GLTF_TEXTURE_SCALE(aiTextureType_NORMALS, 0), scale);
      material.normal_scale = std::isfinite(scale) ? scale : 1;
    }
    float ior = 1.5f;
    source.Get(AI_MATKEY_REFRACTI, ior);
    if (!(ior >= kIorMin && ior <= kIorMax)) ior = 1.5f;
    if (share(AI_MATKEY_TRANSMISSION_FACTOR, 0.0f) > 0.5f) {
      material.bsdf = BsdfKind::kGlass;
      material.ior = ior;
      material.specular = material.albedo;
      return;
    }
    material.bsdf = BsdfKind::kGlossy;
    const float root = (ior - 1) / (ior + 1);
    material.specular = Vec3f{root, root, root} * root;
    material.metalness = share(AI_MATKEY_METALLIC_FACTOR, 1.0f);
    material.roughness = share(AI_MATKEY_ROUGHNESS_FACTOR, 1.0f);
    if (source.GetTexture(AI_MATKEY_GLTF_PBRMETALLICROUGHNESS_METALLICROUGHNESS_TEXTURE, &name) ==
        AI_SUCCESS) {
      material.roughness_metalness_texture = texture_index(name.C_Str(), false);
    }
  }

  // Vertices have one set of texture coordinates here, as it is.
  void warn_of_coordinates(const aiMaterial& source, const std::string& name) {
    for (const aiTextureType type :
         {aiTextureType_BASE_COLOR, aiTextureType_DIFFUSE, aiTextureType_EMISSIVE,
          aiTextureType_NORMALS, aiTextureType_UNKNOWN}) {
      int set = 0;
      source.Get(AI_MATKEY_UVWSRC(type, 0), set);
      aiUVTransform moved;
      const bool is_moved = source.Get(AI_MATKEY_UVTRANSFORM(type, 0), moved) == AI_SUCCESS &&
                            !(moved.mTranslation == aiVector2D(0, 0) &&
                              moved.mScaling == aiVector2D(1, 1) && moved.mRotation == 0);
      if (set == 0 && !is_moved) continue;
      result_.warnings.push_back("material " + name + ": a picture of it has " +
                                 (is_moved ? "moved texture coordinates (KHR_texture_transform)"
                                           : "texture coordinates of another set than the first") +
                                 ", which are not read; it may lie wrongly");
      return;
    }
  }

  std::uint32_t texture_index(const std::string& name, bool is_srgb) {
    const auto key = std::make_pair(name, is_srgb);
    if (const auto known = textures_.find(key); known != textures_.end()) return known->second;
    std::uint32_t index = kNoTexture;
    auto texture = read_texture(name);
    if (texture.is_ok()) {
      auto decoded = std::make_shared<Texture>(**texture);
      decoded->is_srgb = is_srgb;
      index = static_cast<std::uint32_t>(scene_.textures.size());
      scene_.textures.push_back(std::move(decoded));
    } else {
      result_.warnings.push_back("texture " + name + ": " + texture.status().message() +
                                 "; the plain value is used");
    }
    return textures_[key] = index;
  }

  Result<std::shared_ptr<const Texture>> read_texture(const std::string& name) {
    const aiTexture* embedded = source_.GetEmbeddedTexture(name.c_str());
    if (embedded == nullptr) return read_texture_file(folder_, name);
    if (embedded->mHeight != 0) return Status::unimplemented("is embedded without compression");
    return read_texture_bytes(
        {reinterpret_cast<const std::byte*>(embedded->pcData), embedded->mWidth},
        embedded->achFormatHint);
  }

  Status add_mesh(const aiMesh& source, unsigned index) {
    auto mesh = std::make_shared<Mesh>();
    for (unsigned i = 0; i < source.mNumVertices; ++i) {
      mesh->positions.push_back(vec(source.mVertices[i]));
      if (!is_finite(mesh->positions.back())) {
        return Status::invalid_argument(path_ + ": mesh " + std::to_string(index) + ", vertex " +
                                        std::to_string(i) + " is not finite");
      }
      if (source.HasNormals()) {
        const Vec3f n = vec(source.mNormals[i]);
        mesh->normals.push_back(is_finite(n) ? n : Vec3f{});
      }
      if (source.HasTextureCoords(0)) {
        const Vec2f uv{source.mTextureCoords[0][i].x, source.mTextureCoords[0][i].y};
        mesh->uvs.push_back(std::isfinite(uv.x) && std::isfinite(uv.y) ? uv : Vec2f{});
      }
    }
    for (unsigned i = 0; i < source.mNumFaces; ++i) {
      const aiFace& face = source.mFaces[i];
      if (face.mNumIndices != 3) continue;  // points and lines
      mesh->triangles.push_back({face.mIndices[0], face.mIndices[1], face.mIndices[2]});
      for (const std::uint32_t vertex : mesh->triangles.back()) {
        if (vertex >= mesh->positions.size()) {
          return Status::invalid_argument(path_ + ": mesh " + std::to_string(index) +
                                          ", triangle " + std::to_string(i) + ": vertex " +
                                          std::to_string(vertex) + " is out of range");
        }
      }
    }
    mesh->materials = {
        std::min(source.mMaterialIndex, static_cast<unsigned>(scene_.materials.size() - 1))};
    degenerate_count_ += count_degenerate(*mesh);
    scene_.meshes.push_back(std::move(mesh));
    return Status::ok();
  }

  Status walk(const aiNode& node, const Transform& parent, int depth) {
    if (depth > kNodeDepthMax)
      return Status::invalid_argument(path_ + ": nodes are nested deeper than " +
                                      std::to_string(kNodeDepthMax));
    const Transform here = parent * transform(node.mTransformation);
    nodes_[node.mName.C_Str()] = here;
    for (unsigned i = 0; i < node.mNumMeshes; ++i) {
      if (scene_.instances.size() >= kInstancesMax)
        return Status::resource_exhausted(path_ + ": too many instances");
      scene_.instances.push_back(
          {is_mirrored(here) ? reversed(node.mMeshes[i]) : node.mMeshes[i], here});
    }
    for (unsigned i = 0; i < node.mNumChildren; ++i)
      TESSERA_RETURN_IF_ERROR(walk(*node.mChildren[i], here, depth + 1));
    return Status::ok();
  }

  // glTF 2.0, section 3.7.4: a node that mirrors turns the order of a triangle's corners round.
  static bool is_mirrored(const Transform& t) {
    const auto row = [&t](std::size_t i) { return Vec3f{t.m[i][0], t.m[i][1], t.m[i][2]}; };
    return dot(cross(row(0), row(1)), row(2)) < 0;
  }
  std::uint32_t reversed(std::uint32_t mesh) {
    const auto [known, is_new] =
        reversed_.try_emplace(mesh, static_cast<std::uint32_t>(scene_.meshes.size()));
    if (is_new) {
      auto copy = std::make_shared<Mesh>(*scene_.meshes[mesh]);
      for (auto& t : copy->triangles) std::swap(t[1], t[2]);
      scene_.meshes.push_back(std::move(copy));
    }
    return known->second;
  }

  Transform node_of(const aiString& name) const {
    const auto node = nodes_.find(name.C_Str());
    return node == nodes_.end() ? Transform{} : node->second;
  }

  // Unit factors: KHR_lights_punctual's candela and lux are taken as W/sr and W/m2 (no photometric
  // factor).
  void add_lights() {
    for (unsigned i = 0; i < source_.mNumLights && i < kLightsMax; ++i) {
      const aiLight& source = *source_.mLights[i];
      const Transform node = node_of(source.mName);
      Light light;
      light.position = node.point({0, 0, 0});
      light.direction = node.direction(length(vec(source.mDirection)) > 0 ? vec(source.mDirection)
                                                                          : Vec3f{0, 0, -1});
      light.intensity = {source.mColorDiffuse.r, source.mColorDiffuse.g, source.mColorDiffuse.b};
      if (source.mType == aiLightSource_DIRECTIONAL) light.kind = LightKind::kDirectional;
      if (source.mType == aiLightSource_SPOT) {
        light.kind = LightKind::kSpot;
        light.cos_inner = std::cos(source.mAngleInnerCone);
        light.cos_outer = std::min(std::cos(source.mAngleOuterCone), light.cos_inner);
      }
      const bool is_good =
          is_finite(light.position) && is_finite(light.intensity) && length(light.direction) > 0;
      if (is_good) {
        scene_.lights.push_back(light);
      } else {
        result_.warnings.push_back("light " + std::to_string(i) + " is not finite and left out");
      }
    }
  }

  void add_camera() {
    if (source_.mNumCameras == 0) return;
    const aiCamera& source = *source_.mCameras[0];
    const Transform node = node_of(source.mName);
    Camera camera;
    // Assimp 5.2 repeats the node's translation in mPosition, and gives yfov * aspect as the
    // horizontal angle; a glTF camera itself stands at the origin of its node.
    camera.eye = node.point({0, 0, 0});
    camera.target = camera.eye + node.direction(vec(source.mLookAt));
    camera.up = node.direction(vec(source.mUp));
    const float aspect = source.mAspect > 0 ? source.mAspect : 1;
    camera.vfov_degrees = source.mHorizontalFOV / aspect * 180 / 3.14159265f;
    scene_.camera = camera;
  }

  const std::string path_, folder_;
  const aiScene& source_;
  ReadScene result_;
  Scene scene_;
  std::map<std::pair<std::string, bool>, std::uint32_t> textures_;
  std::vector<float> strengths_;
  std::map<std::string, Transform> nodes_;
  std::map<std::uint32_t, std::uint32_t> reversed_;  // mesh -> its mirror image
  std::uint64_t degenerate_count_ = 0;
};

}  // namespace

Result<ReadScene> read_gltf(const std::string& path) {
  Assimp::Importer importer;
  importer.SetIOHandler(
      new ConfinedFiles(std::filesystem::path(path).parent_path().string()));  // the importer's now
  const aiScene* scene = importer.ReadFile(path, aiProcess_Triangulate);
  if (scene == nullptr || scene->mRootNode == nullptr)
    return Status::invalid_argument(path +
                                    ": cannot be read as glTF 2: " + importer.GetErrorString());
  return GltfReader(path, *scene).read();
}

}  // namespace tessera::import
