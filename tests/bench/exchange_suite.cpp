// SPDX-License-Identifier: Apache-2.0
#include "tests/bench/exchange_suite.h"

#include <time.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <cstdio>
#include <fstream>
#include <memory>
#include <thread>
#include <utility>

#include "common/base/check.h"
#include "common/base/json.h"
#include "common/base/log.h"
#include "common/net/key_store.h"
#include "common/net/listener.h"
#include "common/scene/scene_codec.h"
#include "master/frame_loop/frame_loop.h"
#include "tests/bench/contender.h"
#include "tests/bench/exchange_bare.h"
#include "tests/bench/exchange_slaves.h"
#include "tests/support/small_scene.h"
#include "tests/support/temp_folder.h"

namespace tessera::bench {
namespace {

constexpr double kWarmUpSeconds = 1;
constexpr int kLeasesPerThread = 4;  // one in work, three ahead

// 6 KiB a tile: 32 x 32 pixels of three half floats.
FrameSettings exchange_settings() {
  FrameSettings settings;
  settings.width_px = 1920;
  settings.height_px = 1088;
  settings.tile_edge_px = 32;
  settings.pixel_format = PixelFormat::kHalf;
  settings.camera = {{0, 0, 5}, {0, 0, 0}, {0, 1, 0}, 45};
  return settings;
}

// The product's master on its network thread, fed with two frames at a time for as long as it
// stands.
class Master {
 public:
  Master(int connections, std::shared_ptr<net::TlsContext> tls) {
    FrameLoopOptions options;
    options.prefetch_per_thread = kLeasesPerThread - 1;
    options.slaves_min = connections;
    options.isa = Isa::kScalar;
    options.hasher = &hasher_;
    io_.run_and_wait([&] {
      loop_ = std::make_unique<master::FrameLoop>(io_, options);
      loop_->set_outcome_callback([this](const master::FrameOutcome& outcome) {
        if (!outcome.status.is_ok()) return;
        tiles_ += outcome.stats.tile_count;
        io_.post([this] { submit(); });
      });
      auto listener =
          net::listen(io_, {"127.0.0.1", 0}, std::move(tls), [this](net::ConnectionPtr connection) {
            loop_->accept(std::move(connection), listener_.get());
          });
      TESSERA_CHECK(listener.is_ok());
      listener_ = std::move(*listener);
      SceneEncoder encoder;
      loop_->commit_scene(1, encoder.encode(test::make_small_scene()));
      for (int i = 0; i < 2; ++i) submit();
    });
  }
  ~Master() {
    io_.run_and_wait([this] {
      is_ending_ = true;
      listener_.reset();
      loop_->shutdown();
    });
    io_.run_and_wait([this] { loop_.reset(); });
  }

  std::uint16_t port() const { return listener_->port(); }
  std::uint64_t tiles() const { return tiles_; }
  std::size_t slaves() {
    std::size_t count = 0;
    io_.run_and_wait([&] { count = loop_->status().slaves.size(); });
    return count;
  }
  double net_cpu_seconds() {
    double seconds = 0;
    io_.run_and_wait([&] { seconds = thread_cpu_seconds(); });
    return seconds;
  }

 private:
  using FrameLoopOptions = master::FrameLoopOptions;

  void submit() {
    if (!is_ending_) loop_->submit(next_frame_++, 1, exchange_settings());
  }

  net::IoThread io_{"master-net"};
  net::IoThread hasher_{"master-hash"};
  std::unique_ptr<master::FrameLoop> loop_;  // io thread, as all below but tiles_
  std::unique_ptr<net::Listener> listener_;
  FrameId next_frame_ = 0;
  bool is_ending_ = false;
  std::atomic<std::uint64_t> tiles_{0};
};

struct ProductRate {
  ExchangeRate rate;
  double process_cpu_us = 0;  // of all threads of the master's process, per tile
  double slaves_share = 0;    // of a core that the other side took
  std::size_t slaves = 0;
};

void sleep_seconds(double seconds) {
  std::this_thread::sleep_for(std::chrono::duration<double>(seconds));
}

// The key folder of a cluster and its master's credentials; empty and null without TLS.
struct Credentials {
  test::TempFolder folder;
  std::string cluster;
  std::shared_ptr<net::TlsContext> tls;

  explicit Credentials(bool has_tls) {
    if (!has_tls) return;
    cluster = folder / "keys";
    TESSERA_CHECK(net::init_key_store(cluster).is_ok());
    TESSERA_CHECK(net::add_key(cluster, "master", "master", 1).is_ok());
    auto loaded = net::TlsContext::load(cluster + "/master", "master");
    TESSERA_CHECK(loaded.is_ok());
    tls = *loaded;
  }
};

ExchangePeers peers_of(const ExchangeOptions& options, int connections, const Credentials& keys) {
  ExchangePeers peers;
  peers.connections = connections;
  peers.threads = options.threads;
  peers.keys_folder = keys.cluster;
  return peers;
}

void wait_for_slaves(Master& master, int connections) {
  while (master.slaves() < static_cast<std::size_t>(connections)) sleep_seconds(0.02);
}

ProductRate measure_product(const ExchangeOptions& options, int connections, bool has_tls) {
  const Credentials keys(has_tls);
  ExchangeProcess process(peers_of(options, connections, keys));  // before any thread
  Master master(connections, keys.tls);
  process.connect_to(master.port());
  wait_for_slaves(master, connections);
  sleep_seconds(kWarmUpSeconds);
  const double wall = wall_seconds(), cpu = master.net_cpu_seconds(), all = process_cpu_seconds(),
               others = process.cpu_seconds();
  const std::uint64_t before = master.tiles();
  sleep_seconds(options.seconds);
  const auto tiles = std::max(1.0, static_cast<double>(master.tiles() - before));
  const double window = wall_seconds() - wall;
  ProductRate result;
  result.rate = {tiles / window, 1e6 * (master.net_cpu_seconds() - cpu) / tiles};
  result.process_cpu_us = 1e6 * (process_cpu_seconds() - all) / tiles;
  result.slaves_share = (process.cpu_seconds() - others) / window;
  result.slaves = master.slaves();
  return result;
}

void print_row(const char* link, int connections, const ProductRate& product,
               const ExchangeRate& bare, std::vector<std::string>& rows) {
  const double ratio = product.rate.exchanges_per_second / bare.exchanges_per_second;
  const double cpu_ratio = bare.cpu_us / product.rate.cpu_us;
  std::printf("%-6s %11d %7zu %12.0f %12.0f %6.0f%% %9.2f %9.2f %6.0f%% %9.2f %7.0f%%\n", link,
              connections, product.slaves, product.rate.exchanges_per_second,
              bare.exchanges_per_second, 100 * ratio, product.rate.cpu_us, bare.cpu_us,
              100 * cpu_ratio, product.process_cpu_us, 100 * product.slaves_share);
  std::fflush(stdout);
  JsonObject row;
  row.add("link", link)
      .add("connections", connections)
      .add("slaves", std::uint64_t{product.slaves})
      .add("exchanges_per_second", product.rate.exchanges_per_second)
      .add("bare_exchanges_per_second", bare.exchanges_per_second)
      .add("ratio", ratio)
      .add("net_thread_cpu_us_per_tile", product.rate.cpu_us)
      .add("bare_cpu_us_per_exchange", bare.cpu_us)
      .add("cpu_ratio", cpu_ratio)
      .add("process_cpu_us_per_tile", product.process_cpu_us)
      .add("slaves_cpu_share", product.slaves_share);
  rows.push_back(row.text());
}

double resident_megabytes() {
  std::ifstream file("/proc/self/statm");
  double total = 0, resident = 0;
  file >> total >> resident;
  return resident * static_cast<double>(sysconf(_SC_PAGESIZE)) / 1e6;
}

// Prints the growth of the master's memory since minute 1, when the pools are filled, so that a
// leak of one byte in each tile would show.
void watch_memory(const ExchangeOptions& options, int connections, std::vector<std::string>& rows) {
  const Credentials keys(false);
  ExchangeProcess process(peers_of(options, connections, keys));
  Master master(connections, keys.tls);
  process.connect_to(master.port());
  wait_for_slaves(master, connections);
  double first = 0;
  std::printf("%7s %14s %12s %14s\n", "minute", "tiles", "MB", "since minute 1");
  for (int minute = 1; minute <= static_cast<int>(options.minutes); ++minute) {
    sleep_seconds(60);
    const double now = resident_megabytes();
    if (minute == 1) first = now;
    std::printf("%7d %14llu %12.2f %+14.2f\n", minute,
                static_cast<unsigned long long>(master.tiles()), now, now - first);
    std::fflush(stdout);
    JsonObject row;
    row.add("minute", minute)
        .add("connections", connections)
        .add("tiles", master.tiles())
        .add("megabytes", now)
        .add("growth_megabytes", now - first);
    rows.push_back(row.text());
  }
}

}  // namespace

Status run_exchange_suite(const ExchangeOptions& options, std::vector<std::string>& rows) {
  init_log(LogLevel::kError, LogFormat::kText);
  std::vector<int> counts = options.connections;
  if (counts.empty()) counts = {8, 64, 500};
  if (options.minutes > 0) {
    watch_memory(options, counts.back(), rows);
    return Status::ok();
  }
  std::printf("exchange: %zu-byte results, tiles of 32x32 half, %d of them out on each slave\n",
              kResultBytes, kLeasesPerThread * options.threads);
  std::printf("%-6s %11s %7s %12s %12s %7s %9s %9s %7s %9s %8s\n", "link", "connections", "slaves",
              "tiles/s", "bare/s", "ratio", "cpu us", "bare us", "ratio", "all us", "others");
  for (const int connections : counts) {
    const ExchangeRate bare =
        measure_bare_exchange(connections, kLeasesPerThread * options.threads, options.seconds);
    for (const bool has_tls : {false, true}) {
      if (options.link == (has_tls ? "plain" : "tls")) continue;
      const ProductRate product = measure_product(options, connections, has_tls);
      print_row(has_tls ? "tls" : "plain", connections, product, bare, rows);
    }
  }
  return Status::ok();
}

}  // namespace tessera::bench
