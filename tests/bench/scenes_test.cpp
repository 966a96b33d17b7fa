// SPDX-License-Identifier: Apache-2.0
// The generated scenes are those that the figures of other ray tracers were taken on, bit for bit.
#include <gtest/gtest.h>

#include <span>

#include "common/base/digest.h"
#include "tests/bench/scenes.h"

namespace tessera::bench {
namespace {

std::string digest_of(const Mesh& mesh) {
  Sha256 hash;
  hash.update(std::as_bytes(std::span(mesh.positions)));
  hash.update(std::as_bytes(std::span(mesh.triangles)));
  return hash.finish().hex();
}

TEST(BenchScenes, AreTheSameToTheBit) {
  const std::pair<const char*, const char*> expected[] = {
      {"interior", "7eac2ba4d2add94768f1db903c5a09b2bf5283093017b7fca905e65eb1a56624"},
      {"knot", "652f8db0e1cac1865c9138dfcf4c3990d89ba426b4ff7c46b405dd15d51da60e"},
      {"building", "93ac37751cc825cf5791b1fae70686dc4acb5c10e32443af313b7e24d8acaadf"},
  };
  for (const auto& [name, digest] : expected) {
    const auto scene = make_scene(name);
    ASSERT_TRUE(scene.is_ok());
    EXPECT_EQ(digest_of(scene->mesh), digest) << name;
  }
}

}  // namespace
}  // namespace tessera::bench
