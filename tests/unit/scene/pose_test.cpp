// SPDX-License-Identifier: Apache-2.0
// Scenes of a time: ScenePoser beside another evaluator, and what two times share.
#include "common/scene/pose.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "common/scene/motion_curve.h"
#include "common/scene/scene_codec.h"
#include "common/scene/validate.h"
#include "common/scene/validate_animation.h"
#include "tests/support/motion_reference.h"
#include "tests/support/seed.h"

namespace tessera {
namespace {

class Motions {
 public:
  explicit Motions(std::uint64_t seed) : random_(seed) {}

  float number(double low, double high) {
    return static_cast<float>(std::uniform_real_distribution<double>(low, high)(random_));
  }
  std::uint32_t below(std::uint32_t end) {
    return std::uniform_int_distribution<std::uint32_t>(0, end - 1)(random_);
  }
  Vec3f vector() { return {number(-2, 2), number(-2, 2), number(-2, 2)}; }

  // A chain of nodes with all curves on all properties, a skinned and a morphed mesh, an instance,
  // a light and a camera that go with nodes.
  Scene scene() {
    Scene scene;
    scene.materials.resize(1);
    const auto mesh = std::make_shared<Mesh>();
    mesh->materials = {0};
    for (int i = 0; i < 24; ++i) mesh->positions.push_back(vector());
    for (std::uint32_t i = 0; i + 2 < 24; ++i) mesh->triangles.push_back({i, i + 1, i + 2});
    for (int i = 0; i < 24; ++i) mesh->normals.push_back({0, 0, 1});
    scene.meshes = {mesh, mesh, mesh};
    scene.instances = {{0, {}}, {1, {}}, {2, {}}};
    scene.lights = {Light{}};
    NamedCamera named;
    named.name = "c";
    named.camera.eye = {0, 0, 5};
    scene.cameras = {named};
    scene.animation = std::make_shared<const SceneAnimation>(animation());
    return scene;
  }

 private:
  SceneAnimation animation() {
    SceneAnimation a;
    for (std::uint32_t i = 0; i < 6; ++i) {
      MotionNode node;
      node.parent = i == 0 ? kNoIndex : below(i);
      node.translation = vector();
      node.rotation = {number(-1, 1), number(-1, 1), number(-1, 1), number(0.1, 1)};
      node.scale = {number(0.5, 2), number(-2, -0.5), number(0.5, 2)};
      a.nodes.push_back(node);
    }
    a.nodes[3].has_matrix = 1;
    a.nodes[3].matrix.m[0][1] = 0.5f;
    a.nodes[5].weight_count = 2;
    a.weights = {0.25f, -1};
    for (std::uint32_t i = 0; i < 6; ++i) {
      if (i == 3) continue;
      for (const auto path : {MotionPath::kTranslation, MotionPath::kRotation, MotionPath::kScale})
        add_channel(a, i, path);
    }
    add_channel(a, 5, MotionPath::kWeights);
    a.names = {'a'};
    a.clips = {{static_cast<std::uint32_t>(a.channels.size()), 1}};
    a.instances = {{2, 4, {}}};
    a.lights = {{0, 4}};
    a.cameras = {{0, 2}};
    for (std::uint32_t i = 0; i < 3; ++i) {
      Joint joint{below(6), {}};
      joint.inverse_bind.m[1][3] = number(-1, 1);
      a.joints.push_back(joint);
    }
    a.meshes = {{0, 0, 0, 3, 4, 0, 0, 0}, {1, 5, kNoIndex, 0, 0, 2, 1, 0}};
    for (int i = 0; i < 24 * 4; ++i) a.influences.push_back({below(3), number(0.01, 1)});
    for (int i = 0; i < 24 * 2 * 2; ++i) a.deltas.push_back(vector());
    return a;
  }

  void add_channel(SceneAnimation& a, std::uint32_t node, MotionPath path) {
    MotionChannel channel;
    channel.node = node;
    channel.path = path;
    channel.curve = static_cast<KeyCurve>(below(3));
    channel.first_key = static_cast<std::uint32_t>(a.key_seconds.size());
    channel.first_value = static_cast<std::uint32_t>(a.key_values.size());
    channel.key_count = 1 + below(5);
    float at = number(0, 0.2);
    for (std::uint32_t i = 0; i < channel.key_count; ++i, at += number(0.01, 1))
      a.key_seconds.push_back(at);
    for (std::size_t i = 0; i < channel.key_count * channel_width(a, channel); ++i)
      a.key_values.push_back(number(-1, 1));
    a.channels.push_back(channel);
  }

  std::mt19937_64 random_;
};

TEST(Pose, IsThatOfAnotherEvaluator) {
  std::uint64_t judged = 0;
  double worst = 0;
  const unsigned first = test::seed();
  TESSERA_TRACE_SEED(first);
  for (std::uint64_t i = 0; i < 200; ++i) {
    Motions motions(first + i);
    const Scene scene = motions.scene();
    ASSERT_TRUE(validate_scene(scene).is_ok()) << validate_scene(scene).message();
    ScenePoser poser;
    for (int k = 0; k < 8; ++k) {
      const double seconds = static_cast<double>(motions.number(0, 3));
      const auto posed = poser.at(scene, seconds);
      ASSERT_TRUE(posed.is_ok()) << posed.status().message();
      for (const std::size_t deformed : {0u, 1u}) {
        const auto expected = test::reference_vertices(scene, deformed, seconds);
        double size = 0;
        for (const auto& p : expected)
          size = std::max({size, std::fabs(p[0]), std::fabs(p[1]), std::fabs(p[2])});
        for (std::size_t v = 0; v < expected.size(); ++v) {
          const Vec3f& p = posed->meshes[deformed]->positions[v];
          for (std::size_t k = 0; k < 3; ++k) {
            const double off =
                std::fabs(static_cast<double>(p[static_cast<int>(k)]) - expected[v][k]) / size;
            worst = std::max(worst, off);
            ++judged;
          }
        }
      }
      const auto place = test::reference_place(*scene.animation, 4, seconds);
      for (std::size_t row = 0; row < 3; ++row) {
        const double at = static_cast<double>(posed->instances[2].object_to_world.m[row][3]);
        EXPECT_NEAR(at, place[row][3], 1e-6 * (1 + std::fabs(place[row][3])));
      }
    }
  }
  std::printf("%llu coordinates, at most %.2g of the size off\n",
              static_cast<unsigned long long>(judged), worst);
  // One rounding to float is half of 2^-23, 6e-8.
  EXPECT_LT(worst, 1e-7);
}

TEST(Pose, SlerpIsThatOfTheLibrarysSines) {
  const unsigned seed = test::seed();
  TESSERA_TRACE_SEED(seed);
  std::mt19937_64 random(seed);
  std::uniform_real_distribution<double> number(-1, 1);
  double worst = 0;
  for (int i = 0; i < 100'000; ++i) {
    const Quaternion a = unit({number(random), number(random), number(random), number(random)});
    // Every third pair is close together.
    const double spread = i % 3 == 0 ? std::exp(20 * (number(random) - 1)) : 1;
    const Quaternion b = unit({a[0] + spread * number(random), a[1] + spread * number(random),
                               a[2] + spread * number(random), a[3] + spread * number(random)});
    const double share = 0.5 + 0.5 * number(random);
    double dot = 0, chord = 0;
    for (std::size_t k = 0; k < 4; ++k) dot += a[k] * b[k];
    const double sign = dot < 0 ? -1 : 1;
    for (std::size_t k = 0; k < 4; ++k) chord += (sign * b[k] - a[k]) * (sign * b[k] - a[k]);
    const double angle = 2 * std::asin(std::sqrt(chord) / 2);
    if (angle == 0) continue;
    const Quaternion turned = slerp(a, b, share);
    for (std::size_t k = 0; k < 4; ++k) {
      const double expected =
          (std::sin((1 - share) * angle) * a[k] + std::sin(share * angle) * sign * b[k]) /
          std::sin(angle);
      worst = std::max(worst, std::fabs(turned[k] - expected));
    }
  }
  EXPECT_LT(worst, 1e-15);
}

TEST(Pose, WhatDidNotMoveIsTheSameObject) {
  Motions motions(7);
  const Scene scene = motions.scene();
  ScenePoser poser;
  const Scene first = *poser.at(scene, 0.5), again = *poser.at(scene, 0.5);
  const Scene late = *poser.at(scene, 50), later = *poser.at(scene, 60);
  EXPECT_EQ(first.meshes, again.meshes);
  EXPECT_NE(first.meshes[0], late.meshes[0]);
  EXPECT_EQ(late.meshes, later.meshes);  // behind the last key everything stands still
  EXPECT_EQ(first.meshes[2], scene.meshes[2]);
}

TEST(Pose, MeshesThatAreDeformedOtherwiseAreMadeAnew) {
  Motions motions(7);
  const Scene scene = motions.scene();
  SceneAnimation other = *scene.animation;
  for (Vec3f& delta : other.deltas) delta = 2 * delta;
  Scene changed = scene;
  changed.animation = std::make_shared<const SceneAnimation>(other);
  ScenePoser poser;
  const Scene first = *poser.at(scene, 0.5), second = *poser.at(changed, 0.5);
  const Scene alone = *ScenePoser().at(changed, 0.5);
  for (std::size_t m = 0; m < scene.meshes.size(); ++m)
    EXPECT_TRUE(*second.meshes[m] == *alone.meshes[m]) << m;
  // The same animation, decoded once more, changes nothing.
  changed.animation = std::make_shared<const SceneAnimation>(other);
  EXPECT_EQ(poser.at(changed, 0.5)->meshes, second.meshes);
}

TEST(Pose, AScaleOfZeroHidesAnInstance) {
  Motions motions(8);
  Scene scene = motions.scene();
  SceneAnimation a = *scene.animation;
  a.nodes[3].matrix.m = {};
  a.nodes[4].parent = 3;
  scene.animation = std::make_shared<const SceneAnimation>(a);
  const Scene posed = *ScenePoser().at(scene, 0.5);
  EXPECT_EQ(posed.instances.size(), 2u);
}

TEST(Pose, TravelsAsABlockOfItsOwn) {
  Motions motions(9);
  const Scene scene = motions.scene();
  const EncodedScene encoded = SceneEncoder().encode(scene);
  EXPECT_TRUE(encoded.is_animated());
  const auto decoded = SceneDecoder().decode(encoded);
  ASSERT_TRUE(decoded.is_ok()) << decoded.status().message();
  EXPECT_EQ(*decoded->animation, *scene.animation);
}

TEST(Pose, WhatCannotBeIsRefusedByNumber) {
  Motions motions(10);
  const Scene scene = motions.scene();
  const auto refusal = [&](auto damage) {
    SceneAnimation a = *scene.animation;
    damage(a);
    return validate_animation(a, scene).message();
  };
  const auto is_named = [&](const std::string& text, auto damage) {
    EXPECT_NE(refusal(damage).find(text), std::string::npos) << text << ": " << refusal(damage);
  };
  EXPECT_EQ(refusal([](SceneAnimation&) {}), "");
  is_named("node 2 comes before its parent", [](SceneAnimation& a) { a.nodes[2].parent = 2; });
  is_named("node 1 has a rotation of length 0", [](SceneAnimation& a) {
    a.nodes[1].rotation = {0, 0, 0, 0};
  });
  is_named("node 4 has a place", [](SceneAnimation& a) { a.nodes[4].scale.y = NAN; });
  is_named("channel 0 has a time",
           [](SceneAnimation& a) { a.key_seconds[a.channels[0].first_key] = -1; });
  is_named("channel 3 has keys that are not there",
           [](SceneAnimation& a) { a.channels[3].first_key = 1u << 30; });
  is_named("channel 2 has values that are not there",
           [](SceneAnimation& a) { a.channels[2].first_value = 0xfffffff0u; });
  is_named("channel 1 moves a node that is not there",
           [](SceneAnimation& a) { a.channels[1].node = 6; });
  is_named("clips do not fit", [](SceneAnimation& a) { a.clips[0].channel_count = 3; });
  is_named("vertex 5 of deformed mesh 0 has a joint",
           [](SceneAnimation& a) { a.influences[20].joint = 3; });
  is_named("vertex 0 of deformed mesh 0 has weights that sum to 0", [](SceneAnimation& a) {
    for (int i = 0; i < 4; ++i) a.influences[static_cast<std::size_t>(i)].weight = 0;
  });
  is_named("deformed mesh 1 has more morph targets",
           [](SceneAnimation& a) { a.meshes[1].target_count = 9; });
  is_named("deformed mesh 1 has fewer differences", [](SceneAnimation& a) { a.deltas.pop_back(); });
  is_named("difference 3 is not finite", [](SceneAnimation& a) { a.deltas[3].x = INFINITY; });
  is_named("moved instance 0", [](SceneAnimation& a) { a.instances[0].instance = 3; });
}

}  // namespace
}  // namespace tessera
