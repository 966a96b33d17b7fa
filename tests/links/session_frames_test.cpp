// SPDX-License-Identifier: Apache-2.0
// Whole frames through Session have the same bits, whatever the number of slaves, threads, the tile
// size, the frames in flight and the way the session reaches its master.
#include <gtest/gtest.h>

#include <set>
#include <thread>

#include "common/base/limits.h"
#include "master/session/master_host.h"
#include "master/session/session.h"
#include "tests/support/patience.h"

namespace tessera {
namespace {

using namespace std::chrono_literals;

// A lit box corner: small, with shadows, emission and a point light. `height` changes the picture.
Scene small_scene(float height = 1) {
  Scene scene;
  auto mesh = std::make_shared<Mesh>();
  mesh->positions = {{-2, 0, -2},
                     {2, 0, -2},
                     {2, 0, 2},
                     {-2, 0, 2},
                     {-0.5f, height, -0.5f},
                     {0.5f, height, -0.5f},
                     {0.5f, height, 0.5f},
                     {-0.5f, 3, -0.5f},
                     {0.5f, 3, -0.5f},
                     {0, 3, 0.5f}};
  mesh->triangles = {{0, 2, 1}, {0, 3, 2}, {4, 6, 5}, {7, 8, 9}};
  mesh->materials = {0, 0, 1, 2};
  scene.meshes = {mesh};
  scene.materials.resize(3);
  scene.materials[1].albedo = {0.9f, 0.2f, 0.1f};
  scene.materials[2].emission = {8, 8, 8};
  scene.instances.resize(1);
  scene.lights.push_back({LightKind::kPoint, {2, 3, 2}, {0, -1, 0}, {10, 10, 10}, 1, 0});
  scene.camera = Camera{{3, 2, 4}, {0, 0.5f, 0}, {0, 1, 0}, 45};
  return scene;
}

FrameSettings small_settings(int tile_edge_px = 16) {
  FrameSettings settings;
  settings.width_px = 150;
  settings.height_px = 101;
  settings.camera = *small_scene().camera;
  settings.tile_edge_px = tile_edge_px;
  settings.samples_per_pixel = 2;
  return settings;
}

FrameResult take(Session& session) {
  auto result = session.next_frame(test::kPatience);
  EXPECT_TRUE(result.is_ok()) << result.status().message();
  if (!result.is_ok()) return {};
  EXPECT_TRUE(result->status.is_ok()) << result->status.message();
  return std::move(*result);
}

std::string digest_of_one_frame(const SessionOptions& options, int tile_edge_px) {
  auto session = Session::open(options);
  EXPECT_TRUE(session.is_ok()) << session.status().message();
  if (!session.is_ok()) return "";
  EXPECT_TRUE((*session)->commit_scene(small_scene()).is_ok());
  EXPECT_TRUE((*session)->submit(small_settings(tile_edge_px)).is_ok());
  const FrameResult result = take(**session);
  if (!result.image) return "";
  EXPECT_EQ(result.image->digest(), result.stats.digest);
  EXPECT_GT(result.stats.rays.primary, 0u);
  EXPECT_GT(result.stats.rays.shadow, 0u);
  return result.stats.digest.hex();
}

SessionOptions local(int slaves, int threads) {
  SessionOptions options;
  options.local_slaves = slaves;
  options.local_threads = threads;
  options.slaves_min = slaves;
  return options;
}

TEST(SessionFrames, BitsDoNotDependOnSlavesThreadsOrTiles) {
  std::set<std::string> digests;
  for (const int slaves : {1, 2, 3}) {
    for (const int tile_edge_px : {8, 16, 40, 256})
      digests.insert(digest_of_one_frame(local(slaves, 3), tile_edge_px));
  }
  EXPECT_EQ(digests.size(), 1u);
}

// Settings of frames that differ in everything.
FrameSettings settings_of(int i) {
  FrameSettings settings = small_settings(i == 3 ? kTileEdgeAuto : 16);
  settings.width_px += 40 * i;
  settings.height_px -= 9 * i;
  settings.camera.eye.x -= static_cast<float>(i);
  return settings;
}

TEST(SessionFrames, ComeInOrderEachOfItsOwnSceneCameraAndSize) {
  auto session = Session::open(local(2, 2));
  ASSERT_TRUE(session.is_ok()) << session.status().message();
  std::vector<std::string> alone;
  for (int i = 0; i < 4; ++i) {
    ASSERT_TRUE(
        (*session)->commit_scene(small_scene(0.5f + 0.25f * static_cast<float>(i))).is_ok());
    ASSERT_TRUE((*session)->submit(settings_of(i)).is_ok());
    alone.push_back(take(**session).stats.digest.hex());
  }
  EXPECT_EQ(std::set<std::string>(alone.begin(), alone.end()).size(), 4u);
  std::vector<FrameResult> overlapped;
  for (int i = 0; i < 4; ++i) {
    ASSERT_TRUE(
        (*session)->commit_scene(small_scene(0.5f + 0.25f * static_cast<float>(i))).is_ok());
    ASSERT_TRUE((*session)->submit(settings_of(i)).is_ok());
    if (i >= 1) overlapped.push_back(take(**session));
  }
  overlapped.push_back(take(**session));
  for (std::size_t i = 0; i < 4; ++i) {
    EXPECT_EQ(overlapped[i].frame, 4 + i);
    EXPECT_EQ(overlapped[i].stats.digest.hex(), alone[i]) << "frame " << i;
  }
}

struct Served {
  std::unique_ptr<master::MasterHost> host;
  SessionOptions client;
};

Served serve_plain(int slaves) {
  SessionOptions options = local(slaves, slaves);
  options.slaves_min = 0;
  options.listen = "127.0.0.1:0";
  options.is_plain = true;
  Served served;
  auto host = master::MasterHost::start(options, /*serves_applications=*/true);
  EXPECT_TRUE(host.is_ok()) << host.status().message();
  if (!host.is_ok()) return served;
  served.host = std::move(*host);
  served.client.connect = "127.0.0.1:" + std::to_string(served.host->listen_port());
  served.client.is_plain = true;
  return served;
}

TEST(SessionFrames, AnAuditedFrameIsTheSame) {
  SessionOptions options = local(3, 3);
  const std::string plain = digest_of_one_frame(options, 16);
  options.audit_percent = 100;
  EXPECT_EQ(digest_of_one_frame(options, 16), plain);
  options = local(1, 1);  // nobody to compare with
  options.audit_percent = 50;
  EXPECT_EQ(digest_of_one_frame(options, 16), plain);
}

TEST(SessionFrames, ConnectedSessionGivesTheSameBits) {
  const std::string in_process = digest_of_one_frame(local(1, 1), 16);
  Served served = serve_plain(2);
  ASSERT_TRUE(served.host);
  EXPECT_EQ(digest_of_one_frame(served.client, 16), in_process);
  EXPECT_EQ(digest_of_one_frame(served.client, 32), in_process)
      << "the next application finds a clean master";
}

constexpr int kBentPatches = 40;  // enough that scenes which are not weighed overtake them

// The small scene with bent patches above it, which take a while to weigh and change the picture.
Scene scene_with_patches(float height) {
  Scene scene = small_scene();
  auto surface = std::make_shared<PatchSurface>();
  for (int patch = 0; patch < kBentPatches; ++patch) {
    surface->patches.push_back({3, 3, 0, 0});
    const float away = 1.5f + 0.01f * static_cast<float>(patch);
    for (int i = 0; i < 16; ++i) {
      const int row = i / 4, column = i % 4;
      const bool is_inner = row % 3 != 0 && column % 3 != 0;
      surface->numbers.push_back(0.5f * static_cast<float>(row) - 0.75f);
      surface->numbers.push_back(is_inner ? away + 8 + height : away);
      surface->numbers.push_back(0.5f * static_cast<float>(column) - 0.75f);
    }
  }
  surface->materials = {1};
  scene.surfaces = {surface};
  scene.instances.push_back({0, {}, ObjectKind::kPatchSurface});
  return scene;
}

// Scenes with patches are weighed beside the master's network thread; those without go at once.
TEST(SessionFrames, OfScenesThatAreWeighedKeepTheirOrder) {
  Served served = serve_plain(1);
  ASSERT_TRUE(served.host);
  auto remote = Session::open(served.client), alone = Session::open(local(1, 1));
  ASSERT_TRUE(remote.is_ok() && alone.is_ok());
  std::set<std::string> digests;
  for (int round = 0; round < 3; ++round) {
    const auto height = static_cast<float>(round);
    const Scene scenes[2] = {scene_with_patches(height), small_scene(0.5f + 0.1f * height)};
    for (auto* session : {&*remote, &*alone}) {
      for (const Scene& scene : scenes) {
        ASSERT_TRUE((*session)->commit_scene(scene).is_ok());
        ASSERT_TRUE((*session)->submit(small_settings()).is_ok());
      }
    }
    for (int k = 0; k < 2; ++k) {
      const std::string digest = take(**remote).stats.digest.hex();
      EXPECT_EQ(digest, take(**alone).stats.digest.hex()) << round << ", scene " << k;
      digests.insert(digest);
    }
  }
  EXPECT_EQ(digests.size(), 6u);
}

// A scene that is weighed while others come is followed by the newest that a frame wants.
TEST(SessionFrames, OfTheNewestSceneComeWhileOneIsWeighed) {
  Served served = serve_plain(1);
  ASSERT_TRUE(served.host);
  auto remote = Session::open(served.client);
  ASSERT_TRUE(remote.is_ok());
  for (int k = 0; k < 50; ++k) {
    const float height = 0.5f + 0.01f * static_cast<float>(k);
    ASSERT_TRUE(
        (*remote)->commit_scene(k == 0 ? scene_with_patches(0) : small_scene(height)).is_ok());
  }
  ASSERT_TRUE((*remote)->submit(small_settings()).is_ok());
  auto alone = Session::open(local(1, 1));
  ASSERT_TRUE(alone.is_ok());
  ASSERT_TRUE((*alone)->commit_scene(small_scene(0.5f + 0.01f * 49)).is_ok());
  ASSERT_TRUE((*alone)->submit(small_settings()).is_ok());
  EXPECT_EQ(take(**remote).stats.digest.hex(), take(**alone).stats.digest.hex());
}

TEST(SessionFrames, SecondApplicationIsToldBusy) {
  Served served = serve_plain(1);
  ASSERT_TRUE(served.host);
  auto first = Session::open(served.client);
  ASSERT_TRUE(first.is_ok()) << first.status().message();
  auto second = Session::open(served.client);
  ASSERT_FALSE(second.is_ok());
  EXPECT_NE(second.status().message().find("busy"), std::string::npos) << second.status().message();
}

TEST(SessionFrames, CancelledFramesComeOutAsCancelledAndTheNextIsWhole) {
  auto session = Session::open(local(1, 1));
  ASSERT_TRUE(session.is_ok());
  ASSERT_TRUE((*session)->commit_scene(small_scene()).is_ok());
  FrameSettings large = small_settings();
  large.width_px = large.height_px = 2000;
  large.samples_per_pixel = 16;
  ASSERT_TRUE((*session)->submit(large).is_ok());
  (*session)->cancel_frames();
  auto cancelled = (*session)->next_frame(test::kPatience);
  ASSERT_TRUE(cancelled.is_ok()) << cancelled.status().message();
  EXPECT_EQ(cancelled->status.code(), StatusCode::kCancelled);
  ASSERT_TRUE((*session)->submit(small_settings()).is_ok());
  EXPECT_TRUE(take(**session).image);
}

TEST(SessionFrames, OpenRefusesWhatCannotWork) {
  SessionOptions options;
  options.connect = "127.0.0.1:1";
  options.is_plain = true;
  EXPECT_EQ(Session::open(options).status().code(), StatusCode::kUnavailable);
  options.is_plain = false;
  EXPECT_EQ(Session::open(options).status().code(), StatusCode::kInvalidArgument);
  SessionOptions beyond;
  beyond.listen = "0.0.0.0:0";
  beyond.is_plain = true;
  const Status status = Session::open(beyond).status();
  EXPECT_NE(status.message().find("tessera-keys init"), std::string::npos) << status.message();
}

TEST(SessionFrames, ClosingWithWorkQueuedIsOrderly) {
  Served served = serve_plain(1);
  ASSERT_TRUE(served.host);
  for (int i = 0; i < 20; ++i) {
    for (const SessionOptions& options : {local(1, 1), served.client}) {
      auto session = Session::open(options);
      if (!session.is_ok()) {  // the master still closes the previous application
        EXPECT_NE(session.status().message().find("busy"), std::string::npos);
        continue;
      }
      for (int k = 0; k < 3; ++k) {
        ASSERT_TRUE(
            (*session)->commit_scene(small_scene(1 + 0.1f * static_cast<float>(k))).is_ok());
      }
      ASSERT_TRUE((*session)->submit(small_settings()).is_ok());
      (*session)->status();
      (*session)->cancel_frames();
    }
  }
}

TEST(SessionFrames, ScenesThatNoFrameShowsCostNothing) {
  Served served = serve_plain(1);
  ASSERT_TRUE(served.host);
  for (const SessionOptions& options : {local(1, 1), served.client}) {
    auto session = Session::open(options);
    ASSERT_TRUE(session.is_ok());
    for (int i = 0; i < 60; ++i) {
      ASSERT_TRUE(
          (*session)->commit_scene(small_scene(0.5f + 0.01f * static_cast<float>(i))).is_ok());
      std::this_thread::sleep_for(2ms);
    }
    ASSERT_TRUE((*session)->submit(small_settings()).is_ok());
    EXPECT_EQ(take(**session).stats.scene_version, 60u);
  }
}

TEST(SessionFrames, AFrameInWorkOutlivesManyLaterScenes) {
  auto session = Session::open(local(1, 1));
  ASSERT_TRUE(session.is_ok());
  FrameSettings settings = small_settings(4);
  settings.samples_per_pixel = 64;
  ASSERT_TRUE((*session)->commit_scene(small_scene()).is_ok());
  ASSERT_TRUE((*session)->submit(settings).is_ok());
  for (int i = 1; i < 40; ++i) {
    ASSERT_TRUE(
        (*session)->commit_scene(small_scene(0.5f + 0.01f * static_cast<float>(i))).is_ok());
    std::this_thread::sleep_for(1ms);
  }
  EXPECT_EQ(take(**session).stats.scene_version, 1u);
}

TEST(SessionFrames, CancelledFramesOfAConnectedSessionAreCancelled) {
  Served served = serve_plain(1);
  ASSERT_TRUE(served.host);
  auto session = Session::open(served.client);
  ASSERT_TRUE(session.is_ok());
  FrameSettings settings = small_settings(4);
  settings.samples_per_pixel = 200;
  ASSERT_TRUE((*session)->commit_scene(small_scene()).is_ok());
  ASSERT_TRUE((*session)->submit(settings).is_ok());
  (*session)->cancel_frames();
  auto result = (*session)->next_frame(test::kPatience);
  ASSERT_TRUE(result.is_ok());
  EXPECT_EQ(result->status.code(), StatusCode::kCancelled) << result->status.message();
}

}  // namespace
}  // namespace tessera
