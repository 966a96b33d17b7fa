// SPDX-License-Identifier: Apache-2.0
// Property: a scene that was changed piece by piece, in any order, sent as what changed and built
// beside what did not, has the picture of the same scene made, sent and built in one go; and a
// change that is refused changes nothing.
#include "common/scene/scene_edits.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <map>
#include <optional>
#include <random>
#include <string>
#include <vector>

#include "common/scene/scene_codec.h"
#include "slave/core/integrate/tile_renderer.h"
#include "slave/core/scene/prepared_scene.h"
#include "tests/support/seed.h"
#include "tests/support/test_meshes.h"

namespace tessera {
namespace {

constexpr std::uint32_t kSequences = 1000;
constexpr int kWidthPx = 20, kHeightPx = 14;
constexpr float kNan = std::numeric_limits<float>::quiet_NaN();

using Random = std::mt19937;

float unit(Random& random) { return std::uniform_real_distribution<float>(-1, 1)(random); }
std::size_t below(Random& random, std::size_t count) {
  return std::uniform_int_distribution<std::size_t>(0, count - 1)(random);
}

Transform place(Random& random) {
  Transform t;
  const float angle = 3 * unit(random), size = 0.6f + 0.3f * unit(random);
  t.m[0] = {size * std::cos(angle), -size * std::sin(angle), 0, 2 * unit(random)};
  t.m[1] = {size * std::sin(angle), size * std::cos(angle), 0, 1.5f * unit(random)};
  t.m[2] = {0, 0, size, unit(random)};
  return t;
}

Material material(Random& random) {
  Material m;
  m.albedo = {0.5f + 0.4f * unit(random), 0.5f, 0.5f + 0.4f * unit(random)};
  if (below(random, 4) == 0) m.emission = {2, 1, 0.5f};
  if (below(random, 3) == 0) m.bsdf = BsdfKind::kMirror;
  return m;
}

Light light(Random& random) {
  Light l;
  l.position = {3 * unit(random), 3, 4 + unit(random)};
  l.intensity = {20, 20 + 10 * unit(random), 20};
  return l;
}

Mesh mesh(Random& random) {
  Mesh m =
      below(random, 2) == 0 ? test::make_icosphere(1) : test::make_random_triangles(20, 0.6f, 5);
  m.materials = {static_cast<std::uint32_t>(below(random, 2))};
  return m;
}

std::vector<float> picture(const core::PreparedScene& scene, Renderer kind) {
  FrameSettings settings;
  settings.width_px = kWidthPx;
  settings.height_px = kHeightPx;
  settings.camera = {{0, 0, 7}, {0, 0, 0}, {0, 1, 0}, 45};
  settings.renderer = kind;
  settings.samples_per_pixel = settings.light_samples = 1;
  settings.vpls = 8;
  std::vector<float> rgb(3 * kWidthPx * kHeightPx);
  core::TileRenderer renderer;
  renderer.render(scene, settings, widest_isa(core::supported_isas()), {0, 0, kWidthPx, kHeightPx},
                  rgb);
  return rgb;
}

// The scene as an application thinks of it, which knows nothing of names, sharing and versions.
struct Description {
  struct Object {
    std::shared_ptr<Mesh> mesh;  // shared where a change of one changes all
    Transform place;
  };
  std::map<ObjectName, Object> objects;
  std::vector<Material> materials;
  std::vector<Light> lights;
  Vec3f environment{};

  // Each object has a mesh of its own in it.
  Scene in_one_go() const {
    Scene scene;
    scene.materials = materials;
    scene.lights = lights;
    scene.environment = environment;
    for (const auto& [name, object] : objects) {
      scene.instances.push_back({static_cast<std::uint32_t>(scene.meshes.size()), object.place});
      scene.meshes.push_back(std::make_shared<const Mesh>(*object.mesh));
    }
    return scene;
  }
};

// What versions leave behind: the application's encoder, a slave's decoder and its newest scene.
struct Pipeline {
  SceneEncoder encoder;
  SceneDecoder decoder;
  Scene scene;
  std::shared_ptr<const core::PreparedScene> newest;

  const core::PreparedScene& show(const Scene& next) {
    Result<Scene> decoded = decoder.decode(encoder.encode(next));
    EXPECT_TRUE(decoded.is_ok()) << decoded.status().message();
    core::BuildOptions options;
    options.other = newest.get();
    auto built = core::PreparedScene::build(*decoded, options);
    EXPECT_TRUE(built.is_ok());
    newest = *built;
    scene = *std::move(decoded);  // what it shares with the next version lives as long as it does
    return *newest;
  }
};

class Editor {
 public:
  explicit Editor(std::uint32_t seed) : random_(seed) {
    said_.materials.resize(1);
    for (int i = 0; i < 3; ++i) {
      said_.materials.push_back(material(random_));
      EXPECT_TRUE(edits_.add_material(said_.materials.back()).is_ok());
    }
    add_light();
    for (int i = 0; i < 3; ++i) add_object();
  }

  void change() {
    switch (below(random_, 9)) {
      case 0:
      case 1:
        return move();
      case 2:
        return deform();
      case 3:
        return add_object();
      case 4:
        return remove_object();
      case 5:
        return set_material();
      case 6:
        return below(random_, 2) == 0 ? add_light() : set_light();
      case 7:
        said_.environment = {0.2f + 0.1f * unit(random_), 0.2f, 0.3f};
        return expect_ok(edits_.set_environment(said_.environment));
      default:
        return be_refused();
    }
  }

  void compare() {
    const Renderer kind = below(random_, 3) == 0 ? Renderer::kIgi : Renderer::kDirect;
    const std::vector<float> edited = picture(pipeline_.show(edits_.scene()), kind);
    Pipeline fresh;
    ASSERT_EQ(edited, picture(fresh.show(said_.in_one_go()), kind));
  }

 private:
  using Named = std::pair<const ObjectName, Description::Object>;

  static void expect_ok(const Status& status) { EXPECT_TRUE(status.is_ok()) << status.message(); }
  static void expect_refused(const Status& status) {
    EXPECT_FALSE(status.is_ok());
    EXPECT_EQ(status.message().find('\n'), std::string::npos);
  }
  Named* any() {
    if (said_.objects.empty()) return nullptr;
    return &*std::next(said_.objects.begin(),
                       static_cast<std::ptrdiff_t>(below(random_, said_.objects.size())));
  }

  void move() {
    Named* const object = any();
    if (object == nullptr) return;
    object->second.place = place(random_);
    expect_ok(edits_.set_transform(object->first, object->second.place));
  }

  void deform() {
    Named* const object = any();
    if (object == nullptr) return;
    std::vector<Vec3f>& all = object->second.mesh->positions;
    const std::size_t first = below(random_, all.size());
    const std::size_t count = 1 + below(random_, all.size() - first);
    std::vector<Vec3f> moved(all.begin() + static_cast<std::ptrdiff_t>(first),
                             all.begin() + static_cast<std::ptrdiff_t>(first + count));
    for (Vec3f& p : moved) p = p + 0.2f * Vec3f{unit(random_), unit(random_), unit(random_)};
    std::copy(moved.begin(), moved.end(), all.begin() + static_cast<std::ptrdiff_t>(first));
    expect_ok(edits_.set_positions(object->first, first, moved));
  }

  // A new mesh, or one that was added before and has not been deformed since.
  void add_object() {
    Description::Object object{nullptr, place(random_)};
    std::shared_ptr<const Mesh> shown;
    if (added_ && below(random_, 2) == 0 && *added_ == *described_) {
      shown = added_;
      object.mesh = is_shown(described_) ? described_ : std::make_shared<Mesh>(*added_);
    } else {
      object.mesh = std::make_shared<Mesh>(mesh(random_));
      shown = std::make_shared<const Mesh>(*object.mesh);
    }
    added_ = shown;
    described_ = object.mesh;
    const auto name = edits_.add_object(shown, object.place);
    ASSERT_TRUE(name.is_ok()) << name.status().message();
    EXPECT_TRUE(said_.objects.emplace(*name, object).second) << "a name of its own";
  }

  // Whether an object shows this mesh, and it is still what was added.
  bool is_shown(const std::shared_ptr<Mesh>& mesh) const {
    for (const auto& [name, object] : said_.objects) {
      if (object.mesh == mesh) return true;
    }
    return false;
  }

  void remove_object() {
    Named* const object = any();
    if (object == nullptr) return;
    const ObjectName name = object->first;
    expect_ok(edits_.remove_object(name));
    said_.objects.erase(name);
    expect_refused(edits_.remove_object(name));
  }

  void set_material() {
    const std::size_t at = below(random_, said_.materials.size());
    said_.materials[at] = material(random_);
    expect_ok(edits_.set_material(at, said_.materials[at]));
  }

  void add_light() {
    said_.lights.push_back(light(random_));
    EXPECT_TRUE(edits_.add_light(said_.lights.back()).is_ok());
  }

  void set_light() {
    const std::size_t at = below(random_, said_.lights.size());
    if (said_.lights.size() > 1 && below(random_, 2) == 0) {
      said_.lights.erase(said_.lights.begin() + static_cast<std::ptrdiff_t>(at));
      return expect_ok(edits_.remove_light(at));
    }
    said_.lights[at] = light(random_);
    expect_ok(edits_.set_light(at, said_.lights[at]));
  }

  void be_refused() {
    Transform flat;
    flat.m[1] = {0, 0, 0, 1};
    Transform broken;
    broken.m[2][3] = kNan;
    expect_refused(edits_.set_transform(~ObjectName{0}, {}));
    expect_refused(edits_.set_material(said_.materials.size(), {}));
    expect_refused(edits_.set_light(said_.lights.size(), {}));
    expect_refused(edits_.remove_light(said_.lights.size()));
    expect_refused(edits_.set_environment({-1, 0, 0}));
    Named* const object = any();
    if (object == nullptr) return;
    const std::size_t count = object->second.mesh->positions.size();
    const std::vector<Vec3f> two{{9, 9, 9}, {9, 9, kNan}}, fits{{9, 9, 9}, {9, 9, 9}};
    expect_refused(edits_.set_transform(object->first, flat));
    expect_refused(edits_.set_transform(object->first, broken));
    expect_refused(edits_.set_positions(object->first, 0, two));
    expect_refused(edits_.set_positions(object->first, count - 1, fits));
    expect_refused(edits_.set_positions(object->first, ~std::size_t{0}, fits));
    expect_refused(edits_.set_normals(object->first, count, fits));
    expect_refused(edits_.add_object(std::shared_ptr<const Mesh>(), {}).status());
    expect_refused(edits_.add_object(object->second.mesh, flat).status());
  }

  Random random_;
  SceneEdits edits_;
  Description said_;
  Pipeline pipeline_;
  std::shared_ptr<const Mesh> added_;
  std::shared_ptr<Mesh> described_;
};

TEST(SceneEditsProperty, AnyOrderOfChangesHasThePictureOfTheSceneInOneGo) {
  for (std::uint32_t sequence = 0; sequence < kSequences; ++sequence) {
    const std::uint32_t seed = test::seed(sequence);
    SCOPED_TRACE("sequence " + std::to_string(sequence) + ", seed " + std::to_string(seed));
    Editor editor(seed);
    for (int version = 0; version < 4; ++version) {
      for (std::uint32_t i = 0; i <= (seed + static_cast<std::uint32_t>(version)) % 4; ++i)
        editor.change();
      editor.compare();
      if (testing::Test::HasFailure()) return;
    }
  }
}

}  // namespace
}  // namespace tessera
