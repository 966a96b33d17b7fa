// SPDX-License-Identifier: Apache-2.0
#include "tests/sim/process.h"

#include <utility>

namespace tessera::sim {

// State of a process that planned events keep alive after the process has ended.
struct Process::Life : std::enable_shared_from_this<Life> {
  explicit Life(EventQueue& q) : queue(q) {}

  struct Ready {
    Duration cost;
    std::function<void()> task;
  };
  EventQueue& queue;
  bool is_alive = true, is_hung = false, is_busy = false;
  std::deque<Ready> ready;
  std::uint64_t task_count = 0;
  Duration busy{};

  void arrive(Ready next) {
    if (!is_alive) return;
    ready.push_back(std::move(next));
    serve();
  }

  void serve() {
    const auto kept = shared_from_this();  // a task may end the process
    while (is_alive && !is_hung && !is_busy && !ready.empty()) {
      Ready next = std::move(ready.front());
      ready.pop_front();
      ++task_count;
      if (next.cost > Duration::zero()) {
        busy += next.cost;
        is_busy = true;
        queue.after(next.cost, [kept] {
          kept->is_busy = false;
          kept->serve();
        });
      }
      next.task();
    }
  }
};

namespace {

class SimTimer final : public net::TimerBackend {
 public:
  explicit SimTimer(Process& process) : state_(std::make_shared<State>(State{&process})) {}
  ~SimTimer() override { SimTimer::cancel(); }

  void start(std::chrono::milliseconds delay, std::chrono::milliseconds interval,
             std::function<void()> callback) override {
    ++state_->generation;
    state_->callback = std::move(callback);
    state_->interval = interval;
    State::wait(state_, delay);
  }

  void cancel() override {
    ++state_->generation;
    state_->callback = nullptr;
  }

 private:
  struct State {
    Process* process;
    std::function<void()> callback{};
    std::chrono::milliseconds interval{0};
    std::uint64_t generation = 0;

    static void wait(const std::shared_ptr<State>& self, Duration delay) {
      const auto fire = [self, generation = self->generation] {
        if (generation != self->generation) return;
        const auto callback = self->callback;
        if (self->interval.count() > 0) {
          wait(self, self->interval);
        } else {
          self->callback = nullptr;
        }
        callback();
      };
      self->process->run_at(self->process->queue().now() + delay, Duration::zero(), fire);
    }
  };
  std::shared_ptr<State> state_;
};

}  // namespace

Process::Process(EventQueue& queue, std::string name, int node)
    : queue_(queue), name_(std::move(name)), node_(node), life_(std::make_shared<Life>(queue)) {}

Process::~Process() { end(); }

void Process::run_at(TimePoint time, Duration cost, std::function<void()> task) {
  queue_.at(time, [life = life_, cost, task = std::move(task)]() mutable {
    life->arrive({cost, std::move(task)});
  });
}

void Process::run_now(Duration cost, std::function<void()> task) {
  life_->arrive({cost, std::move(task)});
}

void Process::post(std::function<void()> task) {
  run_at(queue_.now(), Duration::zero(), std::move(task));
}

std::unique_ptr<net::TimerBackend> Process::make_timer() {
  return std::make_unique<SimTimer>(*this);
}

void Process::set_hung(bool is_hung) {
  life_->is_hung = is_hung;
  if (!is_hung) queue_.after(Duration::zero(), [life = life_] { life->serve(); });
}

bool Process::is_hung() const { return life_->is_hung; }

void Process::end() {
  life_->is_alive = false;
  std::exchange(life_->ready, {});
}

bool Process::is_alive() const { return life_->is_alive; }
std::uint64_t Process::task_count() const { return life_->task_count; }
double Process::busy_seconds() const { return seconds(life_->busy); }

}  // namespace tessera::sim
