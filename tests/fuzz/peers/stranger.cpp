// SPDX-License-Identifier: Apache-2.0
#include "tests/fuzz/peers/stranger.h"

#include <utility>

#include "common/base/log.h"
#include "common/wire/codec.h"

namespace tessera::test {
namespace {

// A stranger reads whatever comes.
net::RecordLimits all_records() {
  net::RecordLimits limits{};
  for (net::RecordLimit& limit : limits) limit = {kRecordHeaderBytesMax, std::int64_t{1} << 32};
  return limits;
}

}  // namespace

Stranger::Stranger(sim::EventQueue& queue, sim::Network& network, int node)
    : queue_(queue),
      network_(network),
      process_(std::make_unique<sim::Process>(queue, "stranger", node)) {}

void Stranger::listen() {
  network_.listen(*process_, [this](net::ConnectionPtr link) { adopt(std::move(link)); });
}

void Stranger::call(int node) {
  if (links_.size() + attempts_.size() >= 2 * kLinksMax) return;
  attempts_.push_back(network_.connect(*process_, node, [this](Result<net::ConnectionPtr> link) {
    if (link.is_ok()) adopt(std::move(*link));
  }));
}

void Stranger::adopt(net::ConnectionPtr link) {
  if (links_.size() >= kLinksMax) return;  // closed with the object
  const std::size_t index = links_.size();
  links_.push_back(std::move(link));
  net::ConnectionCallbacks callbacks;
  callbacks.on_record = [this, index](net::ReceivedRecord record) {
    on_record(index, std::move(record));
  };
  links_.back()->start(std::move(callbacks), all_records());
}

void Stranger::on_record(std::size_t link, net::ReceivedRecord record) {
  const auto message = wire::decode(std::move(record));
  if (!message.is_ok()) return;
  if (const auto* welcome = std::get_if<wire::Welcome>(&*message)) {
    heard.session = welcome->session;
    heard.token = welcome->token;
  } else if (const auto* ping = std::get_if<wire::Ping>(&*message)) {
    if (links_[link]) links_[link]->send(wire::encode(wire::Pong{ping->sent_ns}));
  }
}

void Stranger::step(FuzzInput& input, int peer_node,
                    const std::function<void(std::uint8_t)>& other) {
  const std::uint8_t kind = input.below(16);
  if (kind == 0) return call(peer_node);
  if (kind == 1) return run_for(queue_, std::chrono::milliseconds(input.byte()));
  if (kind == 2) return run_for(queue_, std::chrono::milliseconds(20 * input.byte()));
  if (kind >= 13) return other(kind - 13);
  if (links_.empty()) return run_for(queue_, std::chrono::milliseconds(5));
  net::ConnectionPtr& link = links_[input.byte() % links_.size()];
  if (kind == 3) {
    link.reset();
  } else {
    net::Record record = Speech(input).record(heard);
    if (link) link->send(std::move(record));
    // What is said at once may arrive together, and may not.
    if (kind >= 8) run_for(queue_, std::chrono::milliseconds(1));
  }
}

void Stranger::leave() {
  if (!process_) return;
  network_.on_process_ended(*process_, false);
  process_->end();
  attempts_.clear();
  links_.clear();
  process_.reset();
}

void run_for(sim::EventQueue& queue, Duration time) {
  bool is_over = false;
  queue.after(time, [&is_over] { is_over = true; });
  while (!is_over) queue.step();
}

bool run_until(sim::EventQueue& queue, double seconds, const std::function<bool()>& is_done) {
  const double end = queue.now_seconds() + seconds;
  while (!is_done()) {
    if (queue.now_seconds() > end || !queue.step()) return is_done();
  }
  return true;
}

void silence_log() {
  static const bool is_silent = [] {
    init_log(LogLevel::kOff, LogFormat::kText);
    return true;
  }();
  (void)is_silent;
}

}  // namespace tessera::test
