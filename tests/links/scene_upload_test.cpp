// SPDX-License-Identifier: Apache-2.0
// An application announces a scene of gigabytes and sends some of its chunks, the last first: the
// master's memory grows by what it was sent, and shrinks when the application is killed. How long
// its network thread was away from its loop is printed, and not judged.
#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <cstdio>
#include <fstream>
#include <memory>
#include <numeric>
#include <optional>
#include <random>
#include <thread>
#include <utility>
#include <vector>

#include "common/base/clock.h"
#include "common/base/heap.h"
#include "common/base/limits.h"
#include "common/base/memory_room.h"
#include "common/scene/block_chunks.h"
#include "master/cluster/master_metrics.h"
#include "master/session/master_host.h"
#include "tests/links/bare_client.h"
#include "tests/support/patience.h"

namespace tessera {
namespace {

using test::bytes_of;

constexpr std::uint64_t kMib = std::uint64_t{1} << 20;

// Sanitizers keep what is freed for a while.
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
constexpr bool kIsFreedKept = true;
#else
constexpr bool kIsFreedKept = false;
#endif

std::uint64_t resident_bytes() {
  std::ifstream pages("/proc/self/statm");
  std::uint64_t all = 0, resident = 0;
  EXPECT_TRUE(pages >> all >> resident);
  return resident * static_cast<std::uint64_t>(::sysconf(_SC_PAGESIZE));
}

// The bound of the largest gap that was met: seconds.
double longest_gap() {
  const metrics::Histogram& gaps = master::master_metrics().loop_gap_seconds;
  std::size_t last = 0;
  for (std::size_t i = 0; i <= gaps.bounds().size(); ++i) {
    if (gaps.count(i) > 0) last = i;
  }
  return gaps.bounds()[std::min(last, gaps.bounds().size() - 1)];
}

TEST(SceneUpload, ChunksInAnyOrderTakeTheMemoryOfWhatWasSent) {
  give_large_blocks_back();  // as serve does
  SessionOptions options;
  options.local_slaves = 0;
  options.listen = "127.0.0.1:0";
  options.is_plain = true;
  auto host = master::MasterHost::start(options, /*serves_applications=*/true);
  ASSERT_TRUE(host.is_ok()) << host.status().message();

  // As much as a block may have, or where the master would refuse that, what it takes.
  const auto room = memory_room(0);
  ASSERT_TRUE(room.has_value());
  const std::uint64_t announced =
      std::min(kSceneBlockBytesMax, room->free_bytes / 2 / kSceneChunkBytes * kSceneChunkBytes);
  const std::vector<std::byte> chunk(kSceneChunkBytes, std::byte{0x5a});
  const auto count = chunk_count(announced);
  wire::SceneChunkList list{1, 0, ChunkDigests(count, sha256(chunk))};
  wire::SceneAnnounce announce;
  announce.version = 1;
  announce.digests = {block_digest(announced, list.chunks)};
  announce.sizes = {announced};

  constexpr std::size_t kSent = 400;
  std::vector<std::uint32_t> order(count);
  std::iota(order.begin(), order.end(), 0u);
  std::swap(order.front(), order.back());
  std::shuffle(order.begin() + 1, order.end(), std::mt19937(5));
  order.resize(kSent);
  std::vector<std::string> records{bytes_of(announce), bytes_of(std::move(list))};
  for (const std::uint32_t index : order) {
    records.push_back(bytes_of(wire::SceneChunk{1, 0, std::uint64_t{index} * kSceneChunkBytes,
                                                net::SharedBytes::of(chunk)}));
  }

  std::optional<test::BareClient> application(std::in_place, (*host)->listen_port(), 0,
                                              wire::Role::kApp);
  ASSERT_TRUE(application->is_welcome());
  const auto is_answered = [&] {
    return application->write(bytes_of(wire::StatusRequest{})) && application->hears_reply();
  };
  ASSERT_TRUE(is_answered());
  const std::uint64_t before = resident_bytes();
  std::uint64_t sent = 0;
  std::size_t next = 0;
  for (const std::size_t until : {std::size_t{3}, records.size()}) {  // one chunk, then all others
    for (; next < until; ++next) {
      ASSERT_TRUE(application->write(records[next]));
      sent += records[next].size();
    }
    ASSERT_TRUE(is_answered());
    const std::uint64_t grown = resident_bytes() - std::min(resident_bytes(), before);
    std::printf("%llu MiB announced, %llu KiB sent, %llu KiB grown, gaps of the loop up to %g s\n",
                static_cast<unsigned long long>(announced / kMib),
                static_cast<unsigned long long>(sent / 1024),
                static_cast<unsigned long long>(grown / 1024), longest_gap());
    EXPECT_TRUE(kIsFreedKept || grown <= sent + sent / 10 + kMib);
  }

  // The application is killed, and what it had sent is freed as soon as its connection ends.
  application.reset();
  const TimePoint killed = Clock::now();
  while ((*host)->status().has_application && Clock::now() - killed < test::kPatience)
    std::this_thread::yield();
  EXPECT_FALSE((*host)->status().has_application);  // by now what was posted with its end is done
  const std::uint64_t left = resident_bytes() - std::min(resident_bytes(), before);
  std::printf("%llu KiB kept of an upload that was killed\n",
              static_cast<unsigned long long>(left / 1024));
  EXPECT_TRUE(kIsFreedKept || left <= sent / 10 + kMib);
}

}  // namespace
}  // namespace tessera
