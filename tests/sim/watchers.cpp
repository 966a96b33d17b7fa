// SPDX-License-Identifier: Apache-2.0
#include "tests/sim/watchers.h"

#include <string>
#include <utility>
#include <variant>

#include "common/wire/codec.h"

namespace tessera::sim {
namespace {

constexpr double kPauseSecondsMax = 0.5;  // between two visits
constexpr double kGapSecondsMax = 0.05;   // between two questions
constexpr double kVisitSecondsMax = 3;    // then it goes, answered or not
constexpr int kQuestionsMax = 8;

}  // namespace

Watchers::Watchers(EventQueue& queue, Network& network, int master_node, int count,
                   std::uint64_t seed)
    : queue_(queue), network_(network), master_node_(master_node), random_(seed) {
  for (int i = 0; i < count; ++i) {
    LinkModel link;
    link.delay = from_seconds(random_.between(50e-6, 5e-3));
    all_.push_back({network.add_node(link), nullptr, nullptr, nullptr, 0});
  }
}

Watchers::~Watchers() { end(); }

void Watchers::start() {
  for (std::size_t i = 0; i < all_.size(); ++i) come(i);
}

void Watchers::end() {
  is_over_ = true;
  for (std::size_t i = 0; i < all_.size(); ++i) go(i, false);
}

// A visit is a process: it comes, and it is gone when it leaves.
void Watchers::come(std::size_t index) {
  if (is_over_) return;
  One& one = all_[index];
  one.process = std::make_unique<Process>(queue_, "watcher" + std::to_string(index), one.node);
  one.questions = random_.pick(0, kQuestionsMax);
  one.attempt = network_.connect(*one.process, master_node_, [this, index](auto link) {
    on_connected(index, std::move(link));
  });
  one.process->run_at(queue_.now() + from_seconds(random_.between(0, kVisitSecondsMax)),
                      Duration::zero(), [this, index] { leave(index); });
}

void Watchers::on_connected(std::size_t index, Result<net::ConnectionPtr> link) {
  if (!link.is_ok()) return;
  One& one = all_[index];
  one.link = std::move(*link);
  net::ConnectionCallbacks callbacks;
  callbacks.on_record = [this, index](net::ReceivedRecord record) {
    on_record(index, std::move(record));
  };
  callbacks.on_closed = [](const Status&) {};
  one.link->start(std::move(callbacks), wire::session_limits());
  wire::Hello hello;
  hello.role = wire::Role::kStatus;
  hello.name = one.process->name();
  one.link->send(wire::encode(std::move(hello)));
}

void Watchers::on_record(std::size_t index, net::ReceivedRecord record) {
  One& one = all_[index];
  const auto message = wire::decode(std::move(record));
  if (!message.is_ok() || !one.link) return;
  if (const auto* ping = std::get_if<wire::Ping>(&*message))
    return one.link->send(wire::encode(wire::Pong{ping->sent_ns, 0}));
  answers_ += std::holds_alternative<wire::StatusReply>(*message) ? 1u : 0u;
  if (std::holds_alternative<wire::Welcome>(*message)) ask(index);
}

// Asks without waiting for the answer, so that some meet the end of the link.
void Watchers::ask(std::size_t index) {
  One& one = all_[index];
  if (!one.link) return;
  if (one.questions-- <= 0) return leave(index);
  one.link->send(wire::encode(wire::StatusRequest{true}));
  one.process->run_at(queue_.now() + from_seconds(random_.between(0, kGapSecondsMax)),
                      Duration::zero(), [this, index] { ask(index); });
}

void Watchers::leave(std::size_t index) {
  One& one = all_[index];
  const auto how = static_cast<Leaving>(random_.pick(0, static_cast<int>(Leaving::kCount) - 1));
  const auto say_twice = [&](const wire::Message& message) {
    for (int times = 0; one.link && times < 2; ++times) one.link->send(wire::encode(message));
  };
  if (how == Leaving::kGoodbye && one.link)
    one.link->send(wire::encode(wire::Goodbye{"that is all"}));
  if (how == Leaving::kTwoGoodbyes) say_twice(wire::Goodbye{"that is all"});
  if (how == Leaving::kBreach) say_twice(wire::FrameCancel{1});
  if (how == Leaving::kReset) {
    for (std::size_t i = network_.connections_between(one.node, master_node_); i > 0; --i)
      network_.reset(one.node, master_node_, i - 1);
  }
  // What was said is on its way; the process ends by an event, since this is its own task.
  const Process* const process = one.process.get();
  queue_.after(std::chrono::milliseconds(20), [this, index, how, process] {
    if (all_[index].process.get() == process) go(index, how == Leaving::kPowerLoss);
  });
}

void Watchers::go(std::size_t index, bool is_power_lost) {
  One& one = all_[index];
  if (!one.process) return;
  network_.on_process_ended(*one.process, is_power_lost);
  one.process->end();
  one.attempt.reset();
  one.link.reset();
  one.process.reset();
  queue_.after(from_seconds(random_.between(0, kPauseSecondsMax)), [this, index] { come(index); });
}

}  // namespace tessera::sim
