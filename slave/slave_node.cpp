// SPDX-License-Identifier: Apache-2.0
#include "slave/slave_node.h"

#include <algorithm>
#include <deque>
#include <map>
#include <set>
#include <utility>

#include "common/base/check.h"
#include "common/base/limits.h"
#include "common/base/log.h"
#include "common/base/version.h"
#include "common/scene/scene_summary.h"
#include "common/wire/codec.h"
#include "slave/master_link.h"
#include "slave/scene_intake.h"
#include "slave/slave_metrics.h"

namespace tessera::slave {

namespace {

using std::chrono::milliseconds;

// Frames between FrameBegin and FrameEnd: those in flight, and as many whose end is under way.
constexpr std::size_t kFramesHeldMax = 2 * kFramesInFlightMax;
// Scene versions announced and not retired.
constexpr std::size_t kSceneVersionsHeldMax = 32;
// Results wait in our own queue while the connection's holds this much: the master reads slower
// than we render. Two of the largest tiles keep the wire busy.
constexpr std::uint64_t kSendQueueBytesMax = 4 * kTilePayloadBytesMax;
constexpr milliseconds kFarewell{500};  // to send the last record

}  // namespace

struct SlaveNode::Impl {
  Impl(net::EventLoop& event_loop, SlaveOptions slave_options, net::LinkFactory factory,
       Workshop& shop)
      : loop(event_loop),
        options(std::move(slave_options)),
        open_link(std::move(factory)),
        workshop(shop),
        intake(
            event_loop, [this](std::uint64_t bytes) { return room_for(bytes); }, options.relay,
            intake_events()) {}

  void start();
  std::optional<std::uint64_t> free_bytes() const;
  std::optional<std::uint64_t> room_for(std::uint64_t bytes);
  Status on_tile_message(wire::Message message);
  Status on_frame_begin(const wire::FrameBegin& begin);
  Status on_lease(const wire::TileLease& lease);
  Status on_frame_end(const wire::FrameEnd& end);
  Status on_scene_message(wire::Message message);
  SceneIntake::Events intake_events();
  void renew_when_due();
  Status on_complete(wire::SceneReceiver::Complete complete);
  void on_built(BuildOutcome outcome);
  void on_tile_done(const TileJob& job, std::optional<wire::TileResult> result);
  void give_back(const TileJob& job);
  void on_build_failed(SceneVersion version, const Status& failure);
  void flush_results();
  void on_lost();
  void cancel_all_frames();

  net::EventLoop& loop;
  const SlaveOptions options;
  const net::LinkFactory open_link;
  Workshop& workshop;

  std::unique_ptr<MasterLink> link;
  std::unique_ptr<net::Timer> flush_timer, renewal_timer;
  bool is_leaving = false;
  std::uint64_t generation = 1;  // counts sessions; what an older one left behind is dropped
  SceneIntake intake;
  SceneVersion first_kept = 0;
  std::map<SceneVersion, std::shared_ptr<const core::PreparedScene>> built;
  std::set<SceneVersion> failed_late;      // of those that were built, until they are retired
  std::map<SceneVersion, Digest> digests;  // of what is built, or being built
  SceneSummarizer summarizer;
  std::map<FrameId, std::shared_ptr<FrameWork>> frames;
  struct WaitingResult {
    TimePoint leased;
    wire::TileResult result;
  };
  std::deque<WaitingResult> results;  // waiting for the wire
};

SlaveNode::SlaveNode(net::EventLoop& loop, const SlaveOptions& options, net::LinkFactory open_link,
                     Workshop& workshop)
    : impl_(std::make_unique<Impl>(loop, options, std::move(open_link), workshop)) {}

SlaveNode::~SlaveNode() = default;

void SlaveNode::start() {
  TESSERA_CHECK(impl_->link == nullptr);
  impl_->start();
}

void SlaveNode::on_tile_done(const TileJob& job, std::optional<wire::TileResult> result) {
  impl_->on_tile_done(job, std::move(result));
}

void SlaveNode::on_built(BuildOutcome outcome) { impl_->on_built(std::move(outcome)); }

void SlaveNode::begin_leave() {
  impl_->is_leaving = true;
  for (const TileJob& job : impl_->workshop.remove_all()) impl_->give_back(job);
}

void SlaveNode::give_up_tiles() { impl_->cancel_all_frames(); }

bool SlaveNode::flush() {
  impl_->flush_results();
  return impl_->results.empty() && impl_->link->tile_queue_bytes() == 0;
}

void SlaveNode::say_goodbye() {
  impl_->link->leave("the slave was stopped", kFarewell);
  impl_->flush_timer->cancel();
  impl_->renewal_timer.reset();
}

void SlaveNode::Impl::start() {
  wire::Hello hello;
  hello.role = wire::Role::kSlave;
  hello.name = options.name;
  hello.instance = options.instance;
  hello.threads = static_cast<std::uint32_t>(options.threads);
  hello.isas = options.isas;
  hello.build_id = kBuildId;
  if (options.memory) {
    if (const auto room = options.memory()) hello.memory_bytes = room->limit_bytes;
  }
  MasterLinkEvents events;
  events.on_ready = [this] {
    workshop.set_open_frames(0);
    renew_when_due();
  };
  events.on_lost = [this] { on_lost(); };
  events.on_reached = [this](const std::string& local_host, wire::Hello& h) {
    intake.open_relay(local_host, h);
  };
  events.on_tile_message = [this](wire::Message m) { return on_tile_message(std::move(m)); };
  events.on_scene_message = [this](wire::Message m) { return on_scene_message(std::move(m)); };
  events.on_drained = [this] { flush_results(); };
  flush_timer = std::make_unique<net::Timer>(loop);
  link = std::make_unique<MasterLink>(loop, std::move(hello), open_link, std::move(events));
  if (options.renewal.request) {
    renewal_timer = std::make_unique<net::Timer>(loop);
    renewal_timer->start_repeating(net::kRenewalLook, [this] { renew_when_due(); });
  }
  link->start();
}

void SlaveNode::Impl::renew_when_due() {
  if (!options.renewal.request || !link->can_get_certificates()) return;
  if (auto request = options.renewal.request())
    link->send_scene(wire::CertificateRequest{std::move(*request)});
}

// ---- tiles
// -----------------------------------------------------------------------------------------

Status SlaveNode::Impl::on_tile_message(wire::Message message) {
  if (const auto* lease = std::get_if<wire::TileLease>(&message)) return on_lease(*lease);
  if (const auto* begin = std::get_if<wire::FrameBegin>(&message)) return on_frame_begin(*begin);
  if (const auto* end = std::get_if<wire::FrameEnd>(&message)) return on_frame_end(*end);
  return Status::data_loss(std::string(wire::message_name(message)) +
                           " does not belong on the tile connection");
}

Status SlaveNode::Impl::on_frame_begin(const wire::FrameBegin& begin) {
  const std::string frame = "FrameBegin of frame " + std::to_string(begin.frame);
  if (frames.contains(begin.frame)) return Status::data_loss(frame + ": it has begun before");
  if (frames.size() >= kFramesHeldMax) {
    return Status::resource_exhausted(frame + ": more than " + std::to_string(kFramesHeldMax) +
                                      " frames at once");
  }
  if ((options.isas & isa_bit(begin.isa)) == 0) {
    return Status::data_loss(frame + ": instruction set " + std::string(isa_name(begin.isa)) +
                             " was not offered");
  }
  // A retired version is no error: SceneRetire travels on the other connection and may overtake the
  // frame. Its tiles are handed back.
  const auto scene = built.find(begin.version);
  const bool was_built = scene != built.end() || failed_late.contains(begin.version);
  if (!was_built && begin.version >= first_kept) {
    return Status::data_loss(frame + ": scene version " + std::to_string(begin.version) +
                             " is not built here");
  }
  frames.emplace(begin.frame,
                 std::make_shared<FrameWork>(begin, scene == built.end() ? nullptr : scene->second,
                                             generation));
  workshop.set_open_frames(frames.size());
  return Status::ok();
}

Status SlaveNode::Impl::on_lease(const wire::TileLease& lease) {
  const auto frame = frames.find(lease.frame);
  if (frame == frames.end()) {
    return Status::data_loss("TileLease of frame " + std::to_string(lease.frame) +
                             ", which has not begun");
  }
  if (lease.tile >= frame->second->grid.tile_count()) {
    return Status::data_loss("TileLease of tile " + std::to_string(lease.tile) +
                             ": the frame has " + std::to_string(frame->second->grid.tile_count()));
  }
  TileJob job{frame->second, lease.tile, lease.attempt, Clock::now()};
  if (is_leaving || job.frame->scene == nullptr) {
    give_back(job);
  } else if (!workshop.try_push(std::move(job))) {
    return Status::resource_exhausted("more than " + std::to_string(kTilesLeasedMax) +
                                      " tiles leased at once");
  }
  return Status::ok();
}

Status SlaveNode::Impl::on_frame_end(const wire::FrameEnd& end) {
  const auto frame = frames.find(end.frame);
  if (frame == frames.end()) {
    return Status::data_loss("FrameEnd of frame " + std::to_string(end.frame) +
                             ", which has not begun");
  }
  frame->second->is_cancelled = true;
  workshop.remove_frame(frame->second.get());
  std::erase_if(results, [&end](const WaitingResult& r) { return r.result.frame == end.frame; });
  frames.erase(frame);
  workshop.set_open_frames(frames.size());
  return Status::ok();
}

void SlaveNode::Impl::on_tile_done(const TileJob& job, std::optional<wire::TileResult> result) {
  if (job.frame->generation != generation) return;       // of a session that is gone
  if (!frames.contains(job.frame->begin.frame)) return;  // ended meanwhile: nobody waits for it
  if (!result) {
    if (const Status failure = job.frame->failure.get(); !failure.is_ok())
      on_build_failed(job.frame->begin.version, failure);
    return give_back(job);
  }
  results.push_back({job.arrived, std::move(*result)});
  flush_results();
}

// A scene that is built as rays meet it may fail after it was told to be ready.
void SlaveNode::Impl::on_build_failed(SceneVersion version, const Status& failure) {
  if (built.erase(version) == 0) return;  // told before
  log_error("scene-failed", failure.message(), {{"version", std::to_string(version)}});
  link->send_scene(wire::SceneFailed{version, failure.message()});
  failed_late.insert(version);
}

void SlaveNode::Impl::give_back(const TileJob& job) {
  link->send_tile(wire::TileReturned{job.frame->begin.frame, job.tile, job.attempt});
}

void SlaveNode::Impl::flush_results() {
  if (!link) return;
  while (!results.empty() && link->tile_queue_bytes() < kSendQueueBytesMax) {
    workshop.observe_link(link->tile_counters());  // before more is on the way
    wire::TileResult& result = results.front().result;
    result.held_seconds = seconds(Clock::now() - results.front().leased);
    link->send_tile(std::move(result));
    results.pop_front();
  }
  // on_drained tells of the connection's own bound, which may be far above ours.
  if (!results.empty()) flush_timer->start_once(milliseconds(2), [this] { flush_results(); });
}

void SlaveNode::Impl::cancel_all_frames() {
  for (const auto& [id, frame] : frames) frame->is_cancelled = true;
}

void SlaveNode::Impl::on_lost() {
  cancel_all_frames();
  workshop.remove_all();
  frames.clear();
  workshop.set_open_frames(0);
  results.clear();
  flush_timer->cancel();
  workshop.forget_link();
  built.clear();
  intake.lost();
  digests.clear();
  failed_late.clear();
  first_kept = 0;
  ++generation;
  workshop.retire(generation, 0);
  workshop.forget_newest();
}

// ---- scenes
// ----------------------------------------------------------------------------------------

std::optional<std::uint64_t> SlaveNode::Impl::free_bytes() const {
  const std::optional<MemoryRoom> room = options.memory ? options.memory() : std::nullopt;
  return room ? std::optional(room->free_bytes) : std::nullopt;
}

// Where there is too little room, frees what is kept for the sake of speed.
std::optional<std::uint64_t> SlaveNode::Impl::room_for(std::uint64_t bytes) {
  const std::optional<std::uint64_t> free = free_bytes();
  if (!free || *free >= bytes) return free;
  workshop.forget_newest();
  return free_bytes();
}

SceneIntake::Events SlaveNode::Impl::intake_events() {
  SceneIntake::Events events;
  events.send = [this](wire::Message message) { link->send_scene(std::move(message)); };
  events.complete = [this](wire::SceneReceiver::Complete complete) {
    return on_complete(std::move(complete));
  };
  events.breach = [this](const Status& status) { link->break_off(status); };
  return events;
}

Status SlaveNode::Impl::on_scene_message(wire::Message message) {
  if (const auto* retire = std::get_if<wire::SceneRetire>(&message)) {
    first_kept = std::max(first_kept, retire->first_kept);
    built.erase(built.begin(), built.lower_bound(first_kept));
    digests.erase(digests.begin(), digests.lower_bound(first_kept));
    failed_late.erase(failed_late.begin(), failed_late.lower_bound(first_kept));
    workshop.retire(generation, first_kept);
    if (!retire->keeps_newest) workshop.forget_newest();
    return intake.retire(first_kept);
  }
  if (const auto* grant = std::get_if<wire::CertificateGrant>(&message);
      grant != nullptr && options.renewal.granted) {
    options.renewal.granted(grant->der, grant->reason);
    return Status::ok();
  }
  if (std::holds_alternative<wire::SceneAnnounce>(message) &&
      built.size() >= kSceneVersionsHeldMax) {
    return Status::resource_exhausted("more than " + std::to_string(kSceneVersionsHeldMax) +
                                      " scene versions not retired");
  }
  return intake.on_message(std::move(message));
}

Status SlaveNode::Impl::on_complete(wire::SceneReceiver::Complete complete) {
  Digest& digest = digests[complete.version];
  digest = summarizer.of(complete.scene.blocks).digest;
  if (options.hooks.is_scene_wrong) digest.bytes[0] ^= 1;
  if (!is_leaving &&
      !workshop.try_push(BuildTask{generation, complete.version, std::move(complete.scene)})) {
    return Status::resource_exhausted("more than " + std::to_string(BuildOrder::kWaitingMax) +
                                      " scenes wait to be built");
  }
  return Status::ok();
}

void SlaveNode::Impl::on_built(BuildOutcome outcome) {
  if (outcome.generation != generation || outcome.version < first_kept) return;
  if (!outcome.scene.is_ok()) {
    if (outcome.scene.status().code() == StatusCode::kCancelled) return;
    log_error("scene-failed", outcome.scene.status().message(),
              {{"version", std::to_string(outcome.version)}});
    link->send_scene(wire::SceneFailed{outcome.version, outcome.scene.status().message()});
    return;
  }
  slave_metrics().build_seconds.observe(outcome.seconds);
  const std::uint64_t triangle_count = (*outcome.scene)->primitive_count();
  // An animation brings a scene with each frame: only what a person waits for is news.
  const bool is_news = built.empty() || outcome.seconds >= 1;
  log_event(is_news ? LogLevel::kInfo : LogLevel::kDebug, "scene-built", "a scene is ready",
            {{"version", std::to_string(outcome.version)},
             {"triangles", std::to_string(triangle_count)},
             {"seconds", std::to_string(outcome.seconds)}});
  built.emplace(outcome.version, std::move(*outcome.scene));
  link->send_scene(wire::SceneBuilt{outcome.version, outcome.seconds, triangle_count,
                                    digests[outcome.version], outcome.built_primitives});
}

}  // namespace tessera::slave
