// SPDX-License-Identifier: Apache-2.0
#include "tests/sim/sim_app.h"

#include <algorithm>
#include <utility>

namespace tessera::sim {
namespace {

// A person starts the application again when it did not find a master.
constexpr std::chrono::milliseconds kStartAgain{300};

}  // namespace

SimApp::SimApp(EventQueue& queue, Network& network, int node, int master_node, AppScript script,
               std::uint64_t seed, Events events)
    : queue_(queue),
      network_(network),
      node_(node),
      master_node_(master_node),
      script_(script),
      random_(seed),
      times_(mix(seed ^ 0x74696d6573u)),
      events_(std::move(events)) {
  // Frames are few, and edits many.
  if (script.weight == SceneWeight::kEdited) tag_ = times_.pick(0, kSceneTagsMax - 1);
}

void SimApp::start() {
  if (process_) return;
  process_ = std::make_unique<Process>(queue_, "app", node_);
  process_->post([this] { begin(); });
}

void SimApp::kill(bool is_power_lost) {
  if (!process_) return;
  network_.on_process_ended(*process_, is_power_lost);
  process_->end();
  client_.reset();
  frames_.clear();
  is_welcomed_ = false;
  process_.reset();
}

void SimApp::set_hung(bool is_hung) {
  if (process_) process_->set_hung(is_hung);
}

void SimApp::cancel() {
  if (!process_) return;
  process_->post([this] {
    if (!client_) return;
    for (Frame& frame : frames_) frame.is_cancelled = true;
    client_->cancel_all();
  });
}

void SimApp::begin() {
  master::LastingClient::Callbacks callbacks;
  callbacks.on_welcome = [this] {
    if (std::exchange(is_welcomed_, true)) return;
    version_ = 0;
    submit_more();
  };
  callbacks.on_frame = [this](const FrameResult& result) { on_frame(result); };
  callbacks.on_away = [this](const Status& why) { look_at_loss(why); };
  callbacks.on_ended = [this](const Status& status) { on_ended(status); };
  client_ = std::make_unique<master::LastingClient>(
      *process_, master::AppIdentity{wire::Role::kApp, "app", mix(++starts_)},
      [this](auto on_connected) {
        return network_.connect(*process_, master_node_, std::move(on_connected));
      },
      std::move(callbacks));
  client_->start();
}

void SimApp::look_at_loss(const Status& why) {
  if (why.code() != StatusCode::kDataLoss) return;
  violation("I2: the application was sent nonsense: " + why.message());
}

void SimApp::on_ended(const Status& status) {
  look_at_loss(status);
  if (is_welcomed_) violation("I2: the application gave up: " + status.message());
  is_welcomed_ = false;
  frames_.clear();
  client_.reset();
  process_->run_at(queue_.now() + kStartAgain, Duration::zero(), [this] { begin(); });
}

void SimApp::submit_more() {
  if (!client_ || !is_welcomed_) return;
  const int wanted =
      is_ending_ ? std::min(script_.in_flight, script_.frames - delivered_) : script_.in_flight;
  while (static_cast<int>(frames_.size()) < wanted) {
    if (version_ == 0 || random_.chance(script_.scene_change)) {
      tag_ = (tag_ + 1) % kSceneTagsMax;
      client_->commit_scene(++version_, scene_of_tag(tag_, script_.weight));
    }
    Frame frame;
    frame.frame = next_frame_++;
    const bool is_edited = script_.weight == SceneWeight::kEdited;
    frame.shown = is_edited ? shown_of_edited(tag_) : Shown{tag_};
    if (script_.weight == SceneWeight::kMoving)
      frame.shown.seconds = frame.settings.time_seconds = time_of(times_.pick(0, kTimes - 1));
    frame.settings.width_px = script_.width_px;
    frame.settings.height_px = script_.height_px;
    frame.settings.tile_edge_px = script_.tile_edge_px;
    frame.settings.pixel_format = PixelFormat::kDisplay8;
    frame.settings.seed = next_seed_++;
    frames_.push_back(frame);
    client_->submit(frame.frame, version_, frame.settings);
  }
}

void SimApp::on_frame(const FrameResult& result) {
  if (frames_.empty() || frames_.front().frame != result.frame) {
    return violation("I2: frame " + std::to_string(result.frame) + " came out of its turn");
  }
  const Frame frame = frames_.front();
  frames_.pop_front();
  queue_.fold(result.frame * 2 + (result.status.is_ok() ? 1u : 0u));
  if (result.status.is_ok()) {
    check_picture(frame, *result.image);
    ++delivered_;
  } else if (result.status.code() == StatusCode::kCancelled && !frame.is_cancelled) {
    violation("I2: frame " + std::to_string(result.frame) + " was cancelled by nobody");
  }
  events_.on_outcome(result.frame, result.status);
  if (random_.chance(script_.cancel)) cancel();
  const Duration pause = from_seconds(random_.between(0, script_.pause_seconds));
  process_->run_at(queue_.now() + pause, Duration::zero(), [this] { submit_more(); });
}

void SimApp::check_picture(const Frame& frame, const FrameImage& image) {
  std::vector<std::byte> expected(image.bytes.size());
  draw(frame.shown, frame.settings, {0, 0, frame.settings.width_px, frame.settings.height_px},
       expected);
  if (std::equal(expected.begin(), expected.end(), image.bytes.begin(), image.bytes.end())) return;
  std::size_t at = 0;
  while (at < expected.size() && expected[at] == image.bytes[at]) ++at;
  const int pixel = static_cast<int>(at / 3);
  violation("I3: frame " + std::to_string(frame.frame) + " is not its picture from pixel (" +
            std::to_string(pixel % frame.settings.width_px) + ", " +
            std::to_string(pixel / frame.settings.width_px) + ") on");
}

}  // namespace tessera::sim
