// SPDX-License-Identifier: Apache-2.0
#include "master/frame_loop/frame_loop.h"

#include <algorithm>
#include <iterator>
#include <utility>

#include "common/base/limits.h"
#include "common/base/log.h"
#include "common/frame/tile_border.h"
#include "master/frame_loop/frame_loop_impl.h"
#include "master/schedule/tile_order.h"

namespace tessera::master {
ClusterEvents FrameLoop::Impl::cluster_events() {
  ClusterEvents events;
  events.slave_joined = [this](SessionId session, const SlaveIdentity& slave,
                               std::uint32_t threads) {
    observer.slave_joined(session, threads);
    authors.slave_joined(session, slave.id());
    scheduler.slave_joined(session, slave, threads, Clock::now());
    start_when_ready();
    look_at_waiting();
  };
  events.tiles_held = [this](SessionId session) { return scheduler.tiles_in_flight(session); };
  events.slave_lost = [this](SessionId session, SlaveEnd how) {
    observer.slave_lost(session);
    Actions actions = scheduler.slave_lost(session, Clock::now(), how);
    if (convictions > 0) {
      std::move(actions.begin(), actions.end(), std::back_inserter(after_conviction));
    } else {
      perform(actions);
    }
    look_at_waiting();
  };
  events.round_trip = [this](SessionId session, double seconds_taken) {
    scheduler.round_trip_measured(session, seconds_taken);
  };
  events.scene_built = [this](SessionId session, const wire::SceneBuilt& built) {
    scene_costs.built(built.version, built.build_seconds, built.built_primitives);
    observer.scene_built(session, built, Clock::now());
    perform(scheduler.scene_built(session, built.version, Clock::now()));
  };
  events.scene_failed = [this](SessionId session, SceneVersion version, const std::string& reason) {
    perform(scheduler.scene_failed(session, version, reason, Clock::now()));
  };
  events.tile_result = [this](SessionId session, wire::TileResult result) {
    on_result(session, std::move(result));
  };
  events.tile_returned = [this](SessionId session, const wire::TileReturned& r) {
    observer.handed_back(session, r);
    perform(scheduler.tile_returned(session, r.frame, r.tile, r.attempt, Clock::now()));
  };
  events.certificate_wanted = options.certificate_wanted;
  return events;
}

Reception::Callbacks FrameLoop::Impl::reception_callbacks() {
  Reception::Callbacks callbacks;
  callbacks.on_hello = [this](std::unique_ptr<PeerLink> link, wire::Hello hello,
                              std::uint16_t version) {
    if (hello.role == wire::Role::kSlave)
      return cluster.on_hello(std::move(link), std::move(hello), version);
    if (hello.role == wire::Role::kApp && !options.serves_applications) {
      return link->refuse(
          wire::RefuseCode::kRole,
          "this master renders for its own process; connect to 'tessera-master serve'");
    }
    apps.on_hello(std::move(link), hello, version);
  };
  callbacks.on_join = [this](std::unique_ptr<PeerLink> link, const wire::Join& join) {
    cluster.on_join(std::move(link), join);
  };
  return callbacks;
}

// The first frame waits for the slaves asked for; then the session is bound to an instruction set.
void FrameLoop::Impl::start_when_ready() {
  if (scheduler.is_started() || frames.empty()) return;
  if (cluster.slave_count() < static_cast<std::size_t>(std::max(options.slaves_min, 1))) return;
  log_info("session-bound",
           "instruction set of this session: " + std::string(isa_name(cluster.bind_isa())));
  perform(scheduler.start(Clock::now()));
}

void FrameLoop::Impl::perform(const Actions& actions) {
  ++performing;
  for (const Action& action : actions) {
    switch (action.kind) {
      case ActionKind::kBeginFrame:
        begin_frame(action);
        break;
      case ActionKind::kLease:
        if (action.tile.attempt > 1 && !action.tile.is_comparison) {
          if (const auto frame = frames.find(action.frame); frame != frames.end()) {
            FrameStats& stats = frame->second.assembly.stats();
            ++stats.tiles_reissued;
            if (action.tile.is_duplicate) ++stats.tiles_duplicated;
          }
        }
        observer.leased(action.session, action.frame, action.tile, Clock::now());
        cluster.send(action.session,
                     wire::TileLease{action.frame, action.tile.tile, action.tile.attempt});
        break;
      case ActionKind::kEndFrame:
        observer.frame_ended(action.session, action.frame);
        cluster.send(action.session, wire::FrameEnd{action.frame});
        break;
      case ActionKind::kExpel:
        ++convictions;
        cluster.convict(action.slave, conviction(action));
        --convictions;
        break;
      case ActionKind::kSuspect:
        ++convictions;
        cluster.suspect(action.slave, action.reason);
        --convictions;
        break;
      case ActionKind::kStalled:
        log_warn("slave-stalled",
                 "slave '" + cluster.name_of(action.session) + "' has stalled: " + action.reason);
        break;
      case ActionKind::kFrameComplete:
        complete(action.frame);
        break;
      case ActionKind::kFrameFailed:
        fail(action);
        break;
    }
  }
  if (--performing > 0 || after_conviction.empty()) return;
  perform(std::exchange(after_conviction, {}));
}

void FrameLoop::Impl::begin_frame(const Action& action) {
  const auto found = frames.find(action.frame);
  if (found == frames.end()) return;
  FrameWork& work = found->second;
  const Isa isa = cluster.isa_of(action.session);
  work.slave_begins(isa, cluster);
  look_at_waiting();
  const auto codings = options.is_pixel_coding ? wire::kByteCodingsAll : wire::kByteCodingsNone;
  cluster.send(action.session, wire::FrameBegin{action.frame, work.assembly.version(), isa,
                                                work.assembly.settings(), codings});
}

std::string FrameLoop::Impl::conviction(const Action& action) {
  for (const auto& [id, work] : frames) {  // those in work keep its tiles, too
    for (const SessionId session : work.slaves()) {
      if (authors.is_of(session, action.slave)) authors.add(session, id);
    }
  }
  const std::string frames_text = authors.frames_of(action.slave);
  if (frames_text.empty()) return action.reason;
  return action.reason + "; frames with tiles of it: " + frames_text;
}

void FrameLoop::Impl::complete(FrameId id) {
  const auto found = frames.find(id);
  if (found == frames.end()) return;
  FrameWork& work = found->second;
  FrameStats& stats = work.assembly.stats();
  work.settle(cluster, scheduler);
  for (const SessionId session : work.slaves()) authors.add(session, id);
  stats.completed_at_seconds = seconds(Clock::now() - started);
  scene_costs.charge(stats, cluster.scene_bytes_sent());
  tile_size.measured(
      work.assembly.pixel_count(), stats.render_seconds,
      {static_cast<int>(stats.tile_edge_px), tile_border_px(work.assembly.settings())});
  FrameOutcome outcome;
  outcome.frame = id;
  FrameDigest digest = work.assembly.take_digest();
  outcome.image = work.assembly.finish();
  finished.push_back(outcome.image);
  outcome.stats = stats;
  outcome.stats.scene_version = moments.committed_as(stats.scene_version);
  observer.frame_over(id, stats.scene_version, FrameEndKind::kDone, work.begin(), Clock::now());
  frames.erase(found);
  look_at_waiting();
  retire();
  release_scenes();
  const OutcomeLine::Ticket ticket = outcomes.add_waiting(std::move(outcome));
  digest.finish([this, is_here = std::weak_ptr<int>(alive), ticket](const Digest& sum) {
    if (!is_here.expired()) outcomes.digest_done(ticket, sum);
  });
}

void FrameLoop::Impl::fail(const Action& action) {
  const auto found = frames.find(action.frame);
  if (found == frames.end()) return;
  FrameOutcome outcome;
  outcome.frame = action.frame;
  outcome.stats = found->second.assembly.stats();
  outcome.status = action.is_cancelled ? Status::cancelled("the frame was cancelled")
                   : action.is_final   ? Status::resource_exhausted(action.reason)
                                       : Status::unavailable(action.reason);
  if (!action.is_cancelled)
    log_warn("frame-failed", action.reason, {{"frame", std::to_string(action.frame)}});
  observer.frame_over(action.frame, outcome.stats.scene_version,
                      action.is_cancelled ? FrameEndKind::kCancelled : FrameEndKind::kFailed,
                      found->second.begin(), Clock::now());
  outcome.stats.scene_version = moments.committed_as(outcome.stats.scene_version);
  frames.erase(found);
  look_at_waiting();
  retire();
  release_scenes();
  outcomes.add(std::move(outcome));
}

SceneVersion FrameLoop::Impl::oldest_version_needed(SceneVersion newest) const {
  SceneVersion oldest = scheduler.oldest_version_needed(newest);
  if (admission.is_empty()) return oldest;
  for (const auto& [id, work] : frames) oldest = std::min(oldest, work.assembly.version());
  return oldest;
}

// Scenes go out at once, or with a synchronous transfer when no frame of an older one is open.
void FrameLoop::Impl::release_scenes() {
  while (!held_scenes.empty()) {
    const auto next = held_scenes.begin();
    if (options.is_scene_transfer_sync && oldest_version_needed(next->first) < next->first) {
      return;
    }
    observer.scene_offered(next->first, Clock::now());
    cluster.commit_scene(next->first, std::move(next->second));
    held_scenes.erase(next);
    retire();  // versions that no frame needs and that this one replaces
  }
}

void FrameLoop::Impl::send(const SceneMoments::Moment& moment) {
  held_scenes.emplace(moment.number, moment.scene);
  release_scenes();
}

void FrameLoop::Impl::retire() {
  const SceneVersion first_kept = oldest_version_needed(moments.newest_number());
  moments.retire(first_kept);
  cluster.retire_scenes(first_kept, /*keeps_newest=*/true);
  scheduler.retire_scenes(first_kept);
  scene_costs.retire(first_kept);
}

void FrameLoop::Impl::look_at_waiting() {
  const bool is_any_in_work = std::any_of(frames.begin(), frames.end(), [](const auto& frame) {
    return frame.second.begin().has_value();
  });
  scene_costs.look(!frames.empty() && cluster.slave_count() > 0 && !is_any_in_work, Clock::now());
}

FrameHoldings FrameLoop::Impl::holdings() {
  FrameHoldings sum;
  for (const auto& [id, work] : frames) {
    sum.written += work.assembly.written_bytes();
    sum.promised += work.assembly.image_bytes() - work.assembly.written_bytes();
  }
  std::erase_if(finished, [](const auto& image) { return image.expired(); });
  for (const auto& image : finished) {
    if (const auto held = image.lock()) sum.written += held->bytes.size();
  }
  return sum;
}

void FrameLoop::Impl::admit() {
  using Verdict = FrameAdmission::Verdict;
  while (const auto decision = admission.next(holdings(), Clock::now())) {
    const FrameId id = decision->frame;
    FrameAssembly& assembly = frames.at(id).assembly;
    Status status;
    if (decision->verdict == Verdict::kRefused) {
      status = Status::resource_exhausted(
          FrameAssembly::refusal(decision->needed_bytes, decision->free_bytes));
    } else if (decision->verdict == Verdict::kCancelled) {
      status = Status::cancelled("cancelled");
    } else {
      status = assembly.allocate();
    }
    if (!status.is_ok()) {
      perform(
          scheduler.refuse_frame(id, status.message(), status.code() == StatusCode::kCancelled));
      continue;
    }
    const TileGrid& grid = assembly.grid();
    perform(scheduler.submit_frame(id, assembly.version(), tile_order(grid.columns(), grid.rows()),
                                   Clock::now()));
    start_when_ready();
    look_at_waiting();
  }
}

FrameLoop::FrameLoop(net::EventLoop& io, const FrameLoopOptions& options)
    : impl_(std::make_unique<Impl>(*this, io, options)) {}

FrameLoop::~FrameLoop() { shutdown(); }

std::optional<std::uint64_t> FrameLoop::free_bytes() const {
  return impl_->admission.free_bytes(impl_->holdings());
}

void FrameLoop::accept(net::ConnectionPtr connection, net::Listener* listener) {
  if (!impl_->is_over) impl_->reception.receive(std::move(connection), listener);
}

void FrameLoop::set_outcome_callback(std::function<void(FrameOutcome)> on_outcome) {
  impl_->outcomes.set_exit(std::move(on_outcome));
}

void FrameLoop::weigh(EncodedScene scene, std::function<void(EncodedScene)> on_weighed) {
  if (primitive_counts_of(scene).patches == 0 || impl_->options.hasher == nullptr) {
    scene.index_bytes = index_bytes_of(scene, impl_->options.surface_bytes);
    return on_weighed(std::move(scene));
  }
  impl_->options.hasher->post([is_here = std::weak_ptr<int>(impl_->alive), io = &impl_->io,
                               surface_bytes = impl_->options.surface_bytes,
                               weighed = std::make_shared<EncodedScene>(std::move(scene)),
                               on_weighed = std::move(on_weighed)] {
    weighed->index_bytes = index_bytes_of(*weighed, surface_bytes);
    io->post([is_here, weighed, on_weighed] {
      if (!is_here.expired()) on_weighed(std::move(*weighed));
    });
  });
}

void FrameLoop::commit_scene(SceneVersion version, EncodedScene scene) {
  if (scene.index_bytes == 0) scene.index_bytes = index_bytes_of(scene);
  impl_->send(
      impl_->moments.commit(version, std::make_shared<const EncodedScene>(std::move(scene))));
}

void FrameLoop::submit(FrameId frame, SceneVersion version, const FrameSettings& asked) {
  FrameSettings settings = asked;
  if (settings.tile_edge_px == kTileEdgeAuto) {
    settings.tile_edge_px =
        impl_->tile_size.edge_px(settings.width_px, settings.height_px,
                                 impl_->cluster.thread_count(), tile_border_px(settings));
    settings.tile_edge_px = std::min(settings.tile_edge_px, tile_edge_max_px(settings));
  }
  const auto moment = impl_->moments.at(version, settings.time_seconds);
  const SceneVersion number = moment ? moment->number : 0;
  const auto [work, is_new] = impl_->frames.try_emplace(
      frame, frame, number, settings, FrameDigest(impl_->io, impl_->options.hasher));
  if (!is_new) return;
  if (!moment) return impl_->perform(impl_->scheduler.refuse_frame(frame, "its scene is not here"));
  if (moment->scene) impl_->send(*moment);
  // Now, and not when there is memory: scenes that nobody needs are replaced by newer ones.
  impl_->cluster.need_scene(number);
  impl_->admission.add(frame, work->second.assembly.needed_bytes(), Clock::now());
  impl_->admit();
}

void FrameLoop::cancel(FrameId frame) {
  if (impl_->admission.cancel(frame)) return impl_->admit();
  impl_->perform(impl_->scheduler.cancel_frame(frame, Clock::now()));
}

void FrameLoop::cancel_all() {
  std::vector<FrameId> ids;
  for (const auto& [id, work] : impl_->frames) ids.push_back(id);
  for (const FrameId id : ids) cancel(id);
}

void FrameLoop::free_scenes() {
  impl_->held_scenes.clear();
  impl_->moments.clear();
  impl_->cluster.retire_scenes(impl_->moments.newest_number() + 1, /*keeps_newest=*/false);
  impl_->scheduler.retire_scenes(impl_->moments.newest_number() + 1);
  impl_->scene_costs.retire(impl_->moments.newest_number() + 1);
}

ClusterStatus FrameLoop::status() const {
  ClusterStatus status = counts();
  status.frames_open = static_cast<std::uint32_t>(status.has_application ? impl_->apps.frames_open()
                                                                         : impl_->frames.size());
  status.pace = impl_->cluster.pace();
  return status;
}

ClusterStatus FrameLoop::counts() const {
  ClusterStatus status = impl_->observer.counts(impl_->scheduler);
  status.quarantined = impl_->cluster.quarantined();
  status.alone_reason = impl_->cluster.alone_reason();
  status.has_application = impl_->apps.has_application();
  return status;
}

Observer& FrameLoop::observer() { return impl_->observer; }

void FrameLoop::shutdown() {
  if (std::exchange(impl_->is_over, true)) return;
  impl_->tick.cancel();
  impl_->apps.shutdown();  // first, so that applications hear why, not of cancelled frames
  cancel_all();
  impl_->outcomes.end(Status::closed("the master ended"));
  impl_->reception.close_all();
  impl_->cluster.shutdown();
}

}  // namespace tessera::master
