// SPDX-License-Identifier: Apache-2.0
#include "slave/slave_host.h"

#include <thread>
#include <utility>

#include "common/base/check.h"
#include "common/base/entropy.h"
#include "slave/render_service.h"

namespace tessera::slave {

namespace {

using std::chrono::milliseconds;

// Limits of leaving: how long tiles being rendered may take to finish, and how long the wire to
// take the rest.
constexpr milliseconds kFinishTilesMs{2000};
constexpr milliseconds kFlushMs{2000};

std::function<std::optional<std::uint64_t>()> free_bytes(const SlaveOptions& options) {
  if (!options.memory) return nullptr;
  return [memory = options.memory]() -> std::optional<std::uint64_t> {
    const std::optional<MemoryRoom> room = memory();
    return room ? std::optional(room->free_bytes) : std::nullopt;
  };
}

// A workshop of render threads and a builder thread.
class ThreadWorkshop final : public Workshop {
 public:
  ThreadWorkshop(const SlaveOptions& options, RenderService::OnDone on_done,
                 SceneBuilder::OnBuilt on_built)
      : builder_({options.threads, nullptr, options.structure, core::Instancing::kAuto,
                  options.is_on_demand, nullptr, free_bytes(options)},
                 std::move(on_built)),
        render_(options.threads, options.hooks, coder_, std::move(on_done),
                [this, threads = options.threads](int idle) {
                  builder_.set_rendering(threads - idle);
                }) {}

  bool try_push(TileJob job) override { return render_.queue().try_push(std::move(job)); }
  void remove_frame(const FrameWork* frame) override { render_.queue().remove_frame(frame); }
  std::deque<TileJob> remove_all() override { return render_.queue().remove_all(); }
  void set_open_frames(std::size_t frames) override { render_.queue().set_open_frames(frames); }
  bool try_push(BuildTask task) override { return builder_.try_push(std::move(task)); }
  void retire(std::uint64_t generation, SceneVersion first_kept) override {
    builder_.retire(generation, first_kept);
  }
  void forget_newest() override { builder_.forget_newest(); }
  void observe_link(const net::LinkCounters& counters) override { coder_.observe(counters); }
  void forget_link() override { coder_.forget_link(); }

  RenderService& render() { return render_; }
  SceneBuilder& builder() { return builder_; }

 private:
  PixelCoder coder_;
  SceneBuilder builder_;
  RenderService render_;  // tells the builder
};

SlaveOptions with_instance(SlaveOptions options) {
  while (options.instance == 0) options.instance = entropy();
  return options;
}

}  // namespace

struct SlaveHost::Impl {
  Impl(net::IoThread& io_thread, SlaveOptions slave_options, net::LinkFactory factory)
      : io(io_thread),
        options(with_instance(std::move(slave_options))),
        open_link(std::move(factory)) {}

  net::IoThread& io;
  const SlaveOptions options;
  const net::LinkFactory open_link;
  std::unique_ptr<ThreadWorkshop> workshop;
  std::unique_ptr<SlaveNode> node;  // io thread
  bool is_started = false;          // owner's thread
};

SlaveHost::SlaveHost(net::IoThread& io, const SlaveOptions& options, net::LinkFactory open_link)
    : impl_(std::make_shared<Impl>(io, options, std::move(open_link))) {}

SlaveHost::~SlaveHost() { stop(); }

void SlaveHost::start() {
  TESSERA_CHECK(!impl_->is_started);
  Impl& self = *impl_;
  self.is_started = true;
  const std::weak_ptr<Impl> weak = impl_;
  net::IoThread& io = self.io;
  self.workshop = std::make_unique<ThreadWorkshop>(
      self.options,
      [weak, &io](const TileJob& job, std::optional<wire::TileResult> result) {
        io.post([weak, job, result = std::move(result)]() mutable {
          const auto impl = weak.lock();
          if (impl && impl->node) impl->node->on_tile_done(job, std::move(result));
        });
      },
      [weak, &io](BuildOutcome outcome) {
        io.post([weak, outcome = std::move(outcome)]() mutable {
          const auto impl = weak.lock();
          if (impl && impl->node) impl->node->on_built(std::move(outcome));
        });
      });
  io.run_and_wait([&self] {
    self.node = std::make_unique<SlaveNode>(self.io, self.options, self.open_link, *self.workshop);
    self.node->start();
  });
}

void SlaveHost::stop() {
  Impl& self = *impl_;
  if (!self.is_started) return;
  self.is_started = false;
  self.io.run_and_wait([&self] { self.node->begin_leave(); });
  self.workshop->builder().stop();
  self.workshop->render().stop(
      kFinishTilesMs, [&self] { self.io.run_and_wait([&self] { self.node->give_up_tiles(); }); });
  // The last results were posted before the threads ended, so they are sent before flush() looks.
  const TimePoint deadline = Clock::now() + kFlushMs;
  bool is_flushed = false;
  while (!is_flushed && Clock::now() < deadline) {
    self.io.run_and_wait([&self, &is_flushed] { is_flushed = self.node->flush(); });
    if (!is_flushed) std::this_thread::sleep_for(milliseconds(2));
  }
  self.io.run_and_wait([&self] { self.node->say_goodbye(); });
  // The goodbye is on its way: give it a moment before the connections are destroyed.
  std::this_thread::sleep_for(milliseconds(20));
  self.io.run_and_wait([&self] { self.node.reset(); });
}

}  // namespace tessera::slave
