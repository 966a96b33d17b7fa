// SPDX-License-Identifier: Apache-2.0
// A master whose memory is limited refuses what does not fit, says what is needed and what is
// there, and goes on.
#include <gtest/gtest.h>

#include <unistd.h>

#include <chrono>
#include <fstream>
#include <memory>
#include <string>
#include <utility>

#include "common/base/limits.h"
#include "common/scene/scene.h"
#include "master/session/master_host.h"
#include "master/session/session.h"
#include "tests/support/patience.h"

namespace tessera {
namespace {

// The master may take a moment to see that the application before has gone.
// Sanitizers keep what is freed for a while.
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
constexpr bool kIsFreedKept = true;
#else
constexpr bool kIsFreedKept = false;
#endif
constexpr int kTries = 1000;
constexpr std::chrono::milliseconds kAMoment{1500};  // a frame takes 120 ms
constexpr std::uint64_t kMib = std::uint64_t{1} << 20;

// A triangle, and where `texture_side_px` is not 0 a texture of so many pixels a side.
Scene small_scene(int texture_side_px = 0) {
  Scene scene;
  auto mesh = std::make_shared<Mesh>();
  mesh->positions = {{-1, 0, 0}, {1, 0, 0}, {0, 1, 0}};
  mesh->triangles = {{0, 1, 2}};
  mesh->materials = {0};
  scene.meshes = {mesh};
  scene.materials.resize(1);
  scene.instances.resize(1);
  if (texture_side_px > 0) {
    auto texture = std::make_shared<Texture>();
    texture->width_px = texture->height_px = texture_side_px;
    texture->rgba.resize(4 * static_cast<std::size_t>(texture_side_px) *
                         static_cast<std::size_t>(texture_side_px));
    scene.textures = {texture};
  }
  return scene;
}

FrameSettings settings_of(int side_px) {
  FrameSettings settings;
  settings.width_px = settings.height_px = side_px;
  settings.camera = Camera{{0, 0, 3}, {0, 0, 0}, {0, 1, 0}, 45};
  settings.renderer = Renderer::kPrimary;
  settings.tile_edge_px = 64;
  return settings;
}

std::uint64_t resident_mib() {
  std::ifstream pages("/proc/self/statm");
  std::uint64_t all = 0, resident = 0;
  EXPECT_TRUE(pages >> all >> resident);
  return resident * static_cast<std::uint64_t>(::sysconf(_SC_PAGESIZE)) / kMib;
}

// The most memory that this process has had since forget_peak().
std::uint64_t peak_mib() {
  std::ifstream status("/proc/self/status");
  for (std::string line; std::getline(status, line);) {
    if (line.starts_with("VmHWM:")) return std::stoull(line.substr(6)) * 1024 / kMib;
  }
  return 0;
}
void forget_peak() { std::ofstream("/proc/self/clear_refs") << "5"; }

FrameResult take(Session& session) {
  auto result = session.next_frame(test::kPatience);
  if (result.is_ok()) return std::move(*result);
  FrameResult none;
  none.status = result.status();
  return none;
}

SessionOptions local_slave(std::uint64_t room_mib) {
  SessionOptions options;
  options.local_slaves = options.local_threads = options.slaves_min = 1;
  options.memory_mib = resident_mib() + room_mib;
  return options;
}

TEST(MemoryRoom, AFrameThatDoesNotFitFailsAloneAndTheNextOneComes) {
  auto session = Session::open(local_slave(150));
  ASSERT_TRUE(session.is_ok()) << session.status().message();
  ASSERT_TRUE((*session)->commit_scene(small_scene()).is_ok());
  ASSERT_TRUE((*session)->submit(settings_of(kImageSideMaxPx)).is_ok());
  ASSERT_TRUE((*session)->submit(settings_of(64)).is_ok());
  const FrameResult large = take(**session);
  EXPECT_EQ(large.status.code(), StatusCode::kResourceExhausted);
  EXPECT_TRUE(large.status.message().starts_with("the frame needs 30")) << large.status.message();
  EXPECT_NE(large.status.message().find(" MiB of memory in the master, "), std::string::npos)
      << large.status.message();
  const FrameResult next = take(**session);
  EXPECT_TRUE(next.status.is_ok()) << next.status.message();
  ASSERT_NE(next.image, nullptr);
}

// Two frames of 130 MiB do not fit at once into what is left: the second one waits for the first,
// and its scene for it, though newer ones have come.
TEST(MemoryRoom, FramesThatFitOneAfterTheOtherAllCome) {
  if (kIsFreedKept) GTEST_SKIP() << "sanitizers keep what is freed: there is never room again";
  forget_peak();
  const SessionOptions options = local_slave(200);
  auto session = Session::open(options);
  ASSERT_TRUE(session.is_ok()) << session.status().message();
  const FrameSettings settings = settings_of(3370);
  for (int frame = 0; frame < 4; ++frame) {
    ASSERT_TRUE((*session)->commit_scene(small_scene()).is_ok());
    ASSERT_TRUE((*session)->submit(settings).is_ok());
    if (frame % 2 == 0) continue;
    ASSERT_TRUE((*session)->commit_scene(small_scene()).is_ok());
    FrameResult first = take(**session);
    ASSERT_TRUE(first.status.is_ok()) << first.status.message();
    // So long as somebody holds the first picture there is no room for the second.
    EXPECT_FALSE((*session)->next_frame(kAMoment).is_ok());
    first = {};
    const Status second = take(**session).status;
    ASSERT_TRUE(second.is_ok()) << second.message();
  }
  EXPECT_GT(peak_mib(), 0u);
  EXPECT_LE(peak_mib(), options.memory_mib);
}

// Renders one frame of a scene through a master elsewhere. Returns: ok, or why there is no picture.
Status render_at(const std::string& address, const Scene& scene) {
  SessionOptions options;
  options.connect = address;
  options.is_plain = true;
  auto session = Session::open(options);
  if (!session.is_ok()) return session.status();
  const auto version = (*session)->commit_scene(scene);
  if (!version.is_ok()) return version.status();
  // The refusal of a scene may be here before the frame is asked for.
  const auto frame = (*session)->submit(settings_of(64));
  const auto result = (*session)->next_frame(test::kPatience);
  if (!result.is_ok()) return result.status();
  return frame.is_ok() ? result->status : frame.status();
}

TEST(MemoryRoom, ASceneThatDoesNotFitIsRefusedAndTheNextOneIsTaken) {
  if (kIsFreedKept) GTEST_SKIP() << "sanitizers keep what is freed: there is never room again";
  SessionOptions serving = local_slave(100);
  serving.listen = "127.0.0.1:0";
  serving.is_plain = true;
  auto host = master::MasterHost::start(serving, /*serves_applications=*/true);
  ASSERT_TRUE(host.is_ok()) << host.status().message();
  const std::string address = "127.0.0.1:" + std::to_string((*host)->listen_port());
  const std::string why = render_at(address, small_scene(5000)).message();  // 96 MiB of texels
  EXPECT_NE(why.find("the scene needs 96 MiB of memory in the master, "), std::string::npos) << why;
  EXPECT_NE(why.find(" MiB are free"), std::string::npos) << why;
  Status next = Status::unavailable("not tried");
  for (int i = 0; i < kTries && !next.is_ok(); ++i) next = render_at(address, small_scene());
  EXPECT_TRUE(next.is_ok()) << next.message();
}

}  // namespace
}  // namespace tessera
