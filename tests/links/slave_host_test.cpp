// SPDX-License-Identifier: Apache-2.0
// SlaveHost with its threads against a scripted master: pixels, orderly leaving. What takes time
// here is waited for and not judged; SlaveNode's times are those of slave_node_test.cpp.
#include "slave/slave_host.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <memory>
#include <set>

#include "common/frame/tile_grid.h"
#include "tests/links/fake_master.h"

namespace tessera::slave {
namespace {

EncodedScene one_triangle() {
  auto mesh = std::make_shared<Mesh>();
  mesh->positions = {{-1, -1, 0}, {1, -1, 0}, {0, 1, 0}};
  mesh->triangles = {{0, 1, 2}};
  mesh->materials = {0};
  Scene scene;
  scene.meshes.push_back(std::move(mesh));
  scene.materials.emplace_back();
  scene.instances.emplace_back();
  return SceneEncoder().encode(scene);
}

class SlaveHostTest : public testing::Test {
 protected:
  void start(int threads, int tile_sleep_ms) {
    SlaveOptions options;
    options.name = "sara";
    options.threads = threads;
    options.isas = isa_bit(Isa::kScalar);
    options.hooks.tile_sleep_ms = tile_sleep_ms;
    host_ = std::make_unique<SlaveHost>(master_.slave_io(), options, master_.factory());
    host_->start();
  }

  // A master that is late for 20 s (200 ms * 101) is not taken for dead.
  void join_with_scene() {
    master_.shake_hands(200, 100);
    master_.give_scene(1, one_triangle());
    EXPECT_EQ(master_.built.triangle_count, 1u);
    master_.begin(7, 1);
  }

  FakeMaster master_;
  std::unique_ptr<SlaveHost> host_;  // goes before the master
};

TEST_F(SlaveHostTest, RendersEachLeasedTileOnce) {
  start(2, 0);
  join_with_scene();
  const TileGrid grid(64, 40, 16);
  for (TileIndex tile = 0; tile < grid.tile_count(); ++tile) master_.lease(7, tile, tile + 1);
  std::set<TileIndex> seen;
  bool is_something_hit = false;
  for (TileIndex i = 0; i < grid.tile_count(); ++i) {
    const wire::TileResult result = master_.expect<wire::TileResult>();
    EXPECT_TRUE(seen.insert(result.tile).second);
    EXPECT_EQ(result.frame, 7u);
    EXPECT_EQ(result.version, 1u);
    EXPECT_EQ(result.attempt, result.tile + 1);
    const int pixels = grid.rect(result.tile).pixel_count();
    EXPECT_EQ(result.pixels.size(), static_cast<std::size_t>(pixels) * 12);
    EXPECT_EQ(result.rays.primary, static_cast<std::uint64_t>(pixels));
    is_something_hit =
        is_something_hit || std::any_of(result.pixels.begin(), result.pixels.end(),
                                        [](std::byte b) { return b != std::byte{0}; });
  }
  EXPECT_TRUE(is_something_hit);
}

// The tile takes an hour, or until its frame ends: whatever comes meanwhile, comes while the only
// render thread is busy.
TEST_F(SlaveHostTest, HeartbeatsGoOutWhileEveryWorkerIsBusy) {
  start(1, 3'600'000);
  join_with_scene();
  master_.lease(7, 0);
  EXPECT_TRUE(master_.wait_for_pings(4)) << "two on each connection";
  EXPECT_FALSE(master_.has_event()) << "the tile was to be in work";
  master_.send(master_.tile, wire::FrameEnd{7});
}

TEST_F(SlaveHostTest, StoppingFinishesWorkAndHandsBackTheQueue) {
  start(1, 100);
  join_with_scene();
  for (TileIndex tile = 0; tile < 6; ++tile) master_.lease(7, tile);
  EXPECT_EQ(master_.expect<wire::TileResult>().tile, 0u);
  host_->stop();
  std::set<TileIndex> accounted = {0};
  bool is_goodbye = false;
  while (!is_goodbye || accounted.size() < 6) {
    const auto event = master_.next();
    ASSERT_TRUE(event);
    if (!event->message) continue;
    if (const auto* returned = std::get_if<wire::TileReturned>(&*event->message)) {
      EXPECT_TRUE(accounted.insert(returned->tile).second);
    } else if (const auto* result = std::get_if<wire::TileResult>(&*event->message)) {
      EXPECT_TRUE(accounted.insert(result->tile).second);
    } else if (std::holds_alternative<wire::Goodbye>(*event->message) &&
               event->link == master_.tile) {
      is_goodbye = true;
      EXPECT_EQ(accounted.size(), 6u) << "nothing follows a goodbye";
    }
  }
  EXPECT_EQ(accounted.size(), 6u);
}

TEST_F(SlaveHostTest, StopsInAnyState) {
  master_.set_away(true);
  start(1, 1);
  host_->stop();
  master_.set_away(false);
  host_.reset();
  start(1, 1);
  (void)master_.expect<wire::Hello>();
  host_.reset();
  SlaveHost never_started(master_.slave_io(), {"x", 1, 1}, master_.factory());
}

}  // namespace
}  // namespace tessera::slave
