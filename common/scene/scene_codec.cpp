#include "common/scene/scene_codec.h"

#include <bit>
#include <cstring>
#include <string>
#include <type_traits>
#include <utility>

#include "common/base/limits.h"
#include "common/scene/validate.h"

namespace tessera {
namespace {

static_assert(std::endian::native == std::endian::little,
              "arrays are copied as they lie in memory");

// First eight bytes of a block: what it is, and the version of its layout.
enum class BlockKind : std::uint32_t {
  kRoot = 0x52535354,
  kMesh = 0x4d535354,
  kTexture = 0x54535354
};
constexpr std::uint32_t kLayoutVersion = 4;

// What follows a large array begins at a chunk, so that an array that grew or shrank leaves the
// chunks behind it as they were (README.md). An array is large when that costs 6 % at most.
constexpr std::uint64_t kLargeArrayBytes = 16 * kSceneChunkBytes;
constexpr std::uint64_t padding_behind(std::uint64_t array_bytes, std::uint64_t block_bytes) {
  const std::uint64_t over = block_bytes % kSceneChunkBytes;
  return array_bytes < kLargeArrayBytes || over == 0 ? 0 : kSceneChunkBytes - over;
}

class Writer {
 public:
  explicit Writer(BlockKind kind) {
    put(kind);
    put(kLayoutVersion);
  }
  template <typename T>
  void put(const T& value) {
    static_assert(std::is_trivially_copyable_v<T>);
    append(&value, sizeof(T));
  }
  template <typename T>
  void put_array(const std::vector<T>& values) {
    static_assert(std::is_trivially_copyable_v<T>);
    put(std::uint64_t{values.size()});
    append(values.data(), values.size() * sizeof(T));
    bytes_.resize(bytes_.size() + padding_behind(values.size() * sizeof(T), bytes_.size()));
  }
  void put_text(const std::string& text) {
    put(std::uint64_t{text.size()});
    append(text.data(), text.size());
  }
  SceneBlock finish() { return make_scene_block(std::move(bytes_)); }

 private:
  void append(const void* data, std::size_t size) {
    const auto* begin = static_cast<const std::byte*>(data);
    bytes_.insert(bytes_.end(), begin, begin + size);
  }
  std::vector<std::byte> bytes_;
};

// Every read says whether the bytes were there; after the first that were not, all fail.
class Reader {
 public:
  explicit Reader(std::span<const std::byte> bytes) : block_bytes_(bytes.size()), rest_(bytes) {}

  bool open(BlockKind kind) {
    return get<BlockKind>() == kind && get<std::uint32_t>() == kLayoutVersion && is_good_;
  }
  template <typename T>
  T get() {
    T value{};
    if (take(sizeof(T))) std::memcpy(&value, taken_.data(), sizeof(T));
    return value;
  }
  template <typename T>
  bool get_array(std::vector<T>& values) {
    const std::uint64_t count = get<std::uint64_t>();
    if (!is_good_ || count > rest_.size() / sizeof(T)) return is_good_ = false;
    take(count * sizeof(T));
    values.resize(count);
    if (count > 0) std::memcpy(values.data(), taken_.data(), taken_.size());
    return skip_padding(count * sizeof(T));
  }
  bool get_text(std::string& text) {
    const std::uint64_t count = get<std::uint64_t>();
    if (!take(count)) return false;
    text.assign(reinterpret_cast<const char*>(taken_.data()), count);
    return true;
  }
  // A count of elements of at least `bytes_each` bytes, checked against what is left.
  std::uint64_t get_count(std::uint64_t bytes_each) {
    const std::uint64_t count = get<std::uint64_t>();
    if (!is_good_ || count > rest_.size() / bytes_each) {
      is_good_ = false;
      return 0;
    }
    return count;
  }
  bool skip_array(std::uint64_t bytes_each) {
    const std::uint64_t bytes = get_count(bytes_each) * bytes_each;
    return take(bytes) && skip_padding(bytes);
  }
  bool is_good() const { return is_good_; }
  bool is_finished() const { return is_good_ && rest_.empty(); }

 private:
  bool take(std::uint64_t size) {
    if (!is_good_ || size > rest_.size()) return is_good_ = false;
    taken_ = rest_.first(size);
    rest_ = rest_.subspan(size);
    return true;
  }
  // Zeros, so that equal content has equal bytes.
  bool skip_padding(std::uint64_t array_bytes) {
    if (!take(padding_behind(array_bytes, block_bytes_ - rest_.size()))) return false;
    for (const std::byte b : taken_) is_good_ &= b == std::byte{0};
    return is_good_;
  }

  const std::uint64_t block_bytes_;
  std::span<const std::byte> rest_, taken_;
  bool is_good_ = true;
};

SceneBlock encode_mesh(const Mesh& mesh) {
  Writer out(BlockKind::kMesh);
  out.put_array(mesh.positions);
  out.put_array(mesh.normals);
  out.put_array(mesh.uvs);
  out.put_array(mesh.triangles);
  out.put_array(mesh.materials);
  return out.finish();
}

std::shared_ptr<const Mesh> decode_mesh(std::span<const std::byte> bytes) {
  Reader in(bytes);
  auto mesh = std::make_shared<Mesh>();
  const bool is_good = in.open(BlockKind::kMesh) && in.get_array(mesh->positions) &&
                       in.get_array(mesh->normals) && in.get_array(mesh->uvs) &&
                       in.get_array(mesh->triangles) && in.get_array(mesh->materials);
  return is_good && in.is_finished() ? mesh : nullptr;
}

std::uint64_t mesh_triangle_count(std::span<const std::byte> bytes) {
  Reader in(bytes);
  const bool is_good = in.open(BlockKind::kMesh) && in.skip_array(sizeof(Vec3f)) &&
                       in.skip_array(sizeof(Vec3f)) && in.skip_array(sizeof(Vec2f));
  return is_good ? in.get_count(3 * sizeof(std::uint32_t)) : 0;
}

SceneBlock encode_texture(const Texture& texture) {
  Writer out(BlockKind::kTexture);
  out.put(std::int32_t{texture.width_px});
  out.put(std::int32_t{texture.height_px});
  out.put(std::uint32_t{texture.is_srgb ? 1u : 0u});
  out.put_array(texture.rgba);
  return out.finish();
}

std::shared_ptr<const Texture> decode_texture(std::span<const std::byte> bytes) {
  Reader in(bytes);
  auto texture = std::make_shared<Texture>();
  if (!in.open(BlockKind::kTexture)) return nullptr;
  texture->width_px = in.get<std::int32_t>();
  texture->height_px = in.get<std::int32_t>();
  texture->is_srgb = in.get<std::uint32_t>() != 0;
  return in.get_array(texture->rgba) && in.is_finished() ? texture : nullptr;
}

void put_camera(Writer& out, const Camera& camera) {
  for (const Vec3f v : {camera.eye, camera.target, camera.up}) out.put(v);
  out.put(camera.vfov_degrees);
}

void put_material(Writer& out, const Material& m) {
  out.put_text(m.name);
  out.put(m.albedo);
  out.put(m.emission);
  out.put(m.albedo_texture);
  out.put(static_cast<std::uint32_t>(m.bsdf));
  out.put(m.specular);
  for (const float x : {m.roughness, m.metalness, m.ior}) out.put(x);
  out.put(m.roughness_metalness_texture);
  out.put(static_cast<std::uint32_t>(m.surface.kind));
  out.put(m.surface.parameters);
}

bool get_material(Reader& in, Material& m) {
  if (!in.get_text(m.name)) return false;
  m.albedo = in.get<Vec3f>();
  m.emission = in.get<Vec3f>();
  m.albedo_texture = in.get<std::uint32_t>();
  const auto bsdf = in.get<std::uint32_t>();
  m.specular = in.get<Vec3f>();
  m.roughness = in.get<float>();
  m.metalness = in.get<float>();
  m.ior = in.get<float>();
  m.roughness_metalness_texture = in.get<std::uint32_t>();
  const auto surface = in.get<std::uint32_t>();
  m.surface.parameters = in.get<SurfaceParameters>();
  if (bsdf > static_cast<std::uint32_t>(BsdfKind::kGlass) ||
      surface > static_cast<std::uint32_t>(SurfaceKind::kBrick)) {
    return false;
  }
  m.bsdf = static_cast<BsdfKind>(bsdf);
  m.surface.kind = static_cast<SurfaceKind>(surface);
  return in.is_good();
}

SceneBlock encode_root(const Scene& scene) {
  Writer out(BlockKind::kRoot);
  out.put(std::uint64_t{scene.meshes.size()});
  out.put(std::uint64_t{scene.textures.size()});
  out.put(std::uint64_t{scene.materials.size()});
  for (const Material& m : scene.materials) put_material(out, m);
  out.put(std::uint64_t{scene.instances.size()});
  for (const Instance& instance : scene.instances) {
    out.put(instance.mesh);
    out.put(instance.object_to_world);
  }
  out.put(std::uint64_t{scene.lights.size()});
  for (const Light& light : scene.lights) {
    out.put(static_cast<std::uint32_t>(light.kind));
    for (const Vec3f v : {light.position, light.direction, light.intensity}) out.put(v);
    out.put(light.cos_inner);
    out.put(light.cos_outer);
  }
  out.put(scene.environment);
  out.put(std::uint32_t{scene.camera ? 1u : 0u});
  if (scene.camera) put_camera(out, *scene.camera);
  return out.finish();
}

constexpr std::uint64_t kMaterialBytesMin =
    8 + 12 + 12 + 4 + 4 + 12 + 3 * 4 + 4 + 4 + sizeof(SurfaceParameters);
constexpr std::uint64_t kInstanceBytes = 4 + sizeof(Transform);
constexpr std::uint64_t kLightBytes = 4 + 3 * 12 + 2 * 4;

// Everything but the meshes and textures themselves.
bool decode_root(std::span<const std::byte> bytes, Scene& scene, std::uint64_t& mesh_count,
                 std::uint64_t& texture_count) {
  Reader in(bytes);
  if (!in.open(BlockKind::kRoot)) return false;
  mesh_count = in.get<std::uint64_t>();
  texture_count = in.get<std::uint64_t>();
  scene.materials.resize(in.get_count(kMaterialBytesMin));
  for (Material& m : scene.materials) {
    if (!get_material(in, m)) return false;
  }
  scene.instances.resize(in.get_count(kInstanceBytes));
  for (Instance& instance : scene.instances) {
    instance.mesh = in.get<std::uint32_t>();
    instance.object_to_world = in.get<Transform>();
  }
  scene.lights.resize(in.get_count(kLightBytes));
  for (Light& light : scene.lights) {
    const auto kind = in.get<std::uint32_t>();
    if (kind > static_cast<std::uint32_t>(LightKind::kDirectional)) return false;
    light.kind = static_cast<LightKind>(kind);
    light.position = in.get<Vec3f>();
    light.direction = in.get<Vec3f>();
    light.intensity = in.get<Vec3f>();
    light.cos_inner = in.get<float>();
    light.cos_outer = in.get<float>();
  }
  scene.environment = in.get<Vec3f>();
  if (in.get<std::uint32_t>() != 0) {
    Camera camera;
    camera.eye = in.get<Vec3f>();
    camera.target = in.get<Vec3f>();
    camera.up = in.get<Vec3f>();
    camera.vfov_degrees = in.get<float>();
    scene.camera = camera;
  }
  return in.is_finished();
}

template <typename T>
std::shared_ptr<const T> cached(
    std::unordered_map<Digest, std::weak_ptr<const T>, DigestHash>& cache, const SceneBlock& block,
    std::shared_ptr<const T> (*decode)(std::span<const std::byte>)) {
  std::weak_ptr<const T>& entry = cache[block.digest];
  if (auto known = entry.lock()) return known;
  auto fresh = decode(*block.bytes);
  entry = fresh;
  return fresh;
}

Status malformed(const char* what, std::size_t index) {
  return Status::data_loss("scene block " + std::to_string(index) + " (" + what + ") is malformed");
}

}  // namespace

SceneBlock make_scene_block(std::vector<std::byte> bytes) {
  SceneBlock block;
  if (is_one_chunk(bytes.size())) {
    block.digest = sha256(bytes);
  } else {
    auto chunks = std::make_shared<const ChunkDigests>(chunk_digests(bytes));
    block.digest = block_digest(bytes.size(), *chunks);
    block.chunks = std::move(chunks);
  }
  block.bytes = std::make_shared<const std::vector<std::byte>>(std::move(bytes));
  return block;
}

std::uint64_t EncodedScene::total_bytes() const {
  std::uint64_t total = 0;
  for (const SceneBlock& block : blocks) total += block.bytes->size();
  return total;
}

std::uint64_t triangle_count_of(const EncodedScene& encoded) {
  Scene root;
  std::uint64_t mesh_count = 0, texture_count = 0;
  if (encoded.blocks.empty() ||
      !decode_root(*encoded.blocks[0].bytes, root, mesh_count, texture_count) ||
      mesh_count >= encoded.blocks.size()) {
    return 0;
  }
  std::vector<std::uint64_t> counts;
  for (std::uint64_t i = 1; i <= mesh_count; ++i) {
    counts.push_back(mesh_triangle_count(*encoded.blocks[i].bytes));
  }
  std::uint64_t total = 0;
  for (const Instance& instance : root.instances) {
    if (instance.mesh < mesh_count) total += counts[instance.mesh];
  }
  return total;
}

std::uint64_t texture_bytes_of(const EncodedScene& encoded) {
  std::uint64_t total = 0;
  for (const SceneBlock& block : encoded.blocks) {
    if (Reader(*block.bytes).open(BlockKind::kTexture)) total += block.bytes->size();
  }
  return total;
}

Digest EncodedScene::digest() const {
  Sha256 hash;
  for (const SceneBlock& block : blocks) hash.update(std::as_bytes(std::span(block.digest.bytes)));
  return hash.finish();
}

EncodedScene SceneEncoder::encode(const Scene& scene) {
  decltype(known_) used;
  EncodedScene encoded;
  encoded.blocks.push_back(encode_root(scene));
  const auto add = [&](const std::shared_ptr<const void>& object, auto make) {
    auto known = known_.find(object.get());
    const SceneBlock block = known != known_.end() ? known->second.second : make();
    used[object.get()] = {object, block};
    encoded.blocks.push_back(block);
  };
  for (const auto& mesh : scene.meshes) add(mesh, [&] { return encode_mesh(*mesh); });
  for (const auto& texture : scene.textures) add(texture, [&] { return encode_texture(*texture); });
  known_ = std::move(used);  // what this version does not use is forgotten
  return encoded;
}

Result<Scene> SceneDecoder::decode(const EncodedScene& encoded) {
  std::erase_if(meshes_, [](const auto& entry) { return entry.second.expired(); });
  std::erase_if(textures_, [](const auto& entry) { return entry.second.expired(); });
  Scene scene;
  std::uint64_t mesh_count = 0, texture_count = 0;
  if (encoded.blocks.empty() || encoded.blocks.size() > kSceneBlocksMax ||
      !decode_root(*encoded.blocks[0].bytes, scene, mesh_count, texture_count)) {
    return malformed("root", 0);
  }
  const std::uint64_t others = encoded.blocks.size() - 1;
  if (mesh_count > others || texture_count != others - mesh_count) return malformed("root", 0);
  for (std::size_t i = 1; i <= others; ++i) {
    if (i <= mesh_count) {
      scene.meshes.push_back(cached<Mesh>(meshes_, encoded.blocks[i], &decode_mesh));
      if (!scene.meshes.back()) return malformed("mesh", i);
    } else {
      scene.textures.push_back(cached<Texture>(textures_, encoded.blocks[i], &decode_texture));
      if (!scene.textures.back()) return malformed("texture", i);
    }
  }
  TESSERA_RETURN_IF_ERROR(validate_scene(scene));
  return scene;
}

}  // namespace tessera
