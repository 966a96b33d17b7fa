// SPDX-License-Identifier: Apache-2.0
// The slaves of a master: handshake, the pair of connections of each, scene versions on their way
// to them. A cluster knows sessions and messages, not frames; the frame loop decides what to lease.
//
// Threads. Io thread only; events come there, too. Only on_join() and expel() raise them from
// inside.
//
// Invariants. (1) The two connections of a slave are one unit: when one is lost or silent, both are
// closed and slave_lost comes once. (2) slave_joined comes when both connections stand, and nothing
// of a session comes before it or after slave_lost. (3) Names are unique among connected slaves.
// (4) Once bound, every slave has the session's instruction set, unless it is mixed.
#pragma once

#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <unordered_map>
#include <vector>

#include "common/base/clock.h"
#include "common/base/ids.h"
#include "common/frame/frame_stats.h"
#include "common/net/event_loop.h"
#include "common/scene/scene_summary.h"
#include "master/cluster/certificate_wish.h"
#include "master/cluster/common_cause.h"
#include "master/cluster/peer_link.h"
#include "master/cluster/quarantine.h"
#include "master/cluster/relay_plan.h"
#include "master/cluster/scene_sender.h"
#include "master/cluster/slave_entry.h"
#include "master/schedule/slave_identity.h"

namespace tessera::master {

struct ClusterEvents {
  std::function<void(SessionId, const SlaveIdentity&, std::uint32_t threads)> slave_joined;
  std::function<void(SessionId, SlaveEnd)> slave_lost;
  std::function<void(SessionId, double seconds)> round_trip;  // by heartbeats, now and then
  std::function<std::uint32_t(SessionId)> tiles_held;  // asked before slave_lost; may be null
  std::function<void(SessionId, const wire::SceneBuilt&)> scene_built;
  std::function<void(SessionId, SceneVersion, const std::string& reason)> scene_failed;
  std::function<void(SessionId, wire::TileResult)> tile_result;
  std::function<void(SessionId, wire::TileReturned)> tile_returned;
  CertificateWish certificate_wanted;  // null: this master makes none
};

class Cluster {
 public:
  Cluster(net::EventLoop& io, std::optional<Isa> isa, bool is_isa_mixed, ClusterEvents events,
          bool is_relaying = true, const net::Pulse& pulse = {});
  ~Cluster();

  // Called by the reception.
  void on_hello(std::unique_ptr<PeerLink> link, wire::Hello hello, std::uint16_t version);
  void on_join(std::unique_ptr<PeerLink> link, const wire::Join& join);

  std::size_t slave_count() const;  // joined ones

  // Binds the session to an instruction set: the one asked for, else the widest that all joined
  // slaves have. Requires: slave_count() >= 1 or an instruction set was asked for.
  Isa bind_isa();
  // The instruction set that this slave renders with. Requires: bound.
  Isa isa_of(SessionId session) const;

  // Sends to a joined slave; ignored when it is gone.
  void send(SessionId session, wire::Message message);
  // Ends the session of a slave that broke the protocol or sent wrong pixels, and holds the slave
  // back. slave_lost is called before this returns.
  void expel(SessionId session, const std::string& reason);

  // Likewise, of the slave with this SlaveIdentity::id(), whether it has a session now or not.
  void convict(const std::string& slave, const std::string& reason);
  // Counts wrong pixels of the slave, `reason`, against it; with too many it is convicted.
  void suspect(const std::string& slave, const std::string& reason);

  void commit_scene(SceneVersion version, SharedScene scene);
  void need_scene(SceneVersion version);
  // `keeps_newest`: the slaves keep what they built last for the version that comes next.
  void retire_scenes(SceneVersion first_kept, bool keeps_newest);

  // How the links are set and what was measured on them.
  ClusterPace pace() const;
  std::vector<QuarantinedSlave> quarantined() const;
  // Why no slave is here, where it is the master's own link; else empty.
  const std::string& alone_reason() const { return cause_.text(); }

  void add_busy_time(SessionId session, double render_seconds);
  // Counts a result that the slave sent once more. Returns: false when it has done so more often
  // than an honest slave can, that is, more times than tiles may be leased to it.
  bool forgive_repeat(SessionId session);
  void count_tile(SessionId session);  // one of its results was accepted
  // The slave's place among all ever joined, for tinting tiles.
  std::uint16_t ordinal_of(SessionId session) const;
  std::string name_of(SessionId session) const;  // empty when it is gone
  // How far the slave's clock is from ours, by the better of its two links.
  std::optional<ClockEstimate> clock_of(SessionId session, TimePoint now) const;
  std::vector<SessionId> joined_sessions() const;
  // Joined slaves, by name; `complete` adds what the scheduler knows of each.
  std::vector<SlaveStatus> status(
      const std::function<void(SessionId, SlaveStatus&)>& complete) const;
  // Bytes are summed over all slaves, gone ones included; threads over joined ones.
  std::uint64_t bytes_sent() const;
  std::uint64_t bytes_received() const;
  std::uint64_t scene_bytes_sent() const;  // on the connections that carry scenes
  std::uint32_t thread_count() const;
  std::uint32_t threads_of(SessionId session) const;  // 0 when it is gone

  void shutdown();

 private:
  // A hash map, since every tile takes five lookups.
  using SlaveMap = std::unordered_map<SessionId, std::unique_ptr<SlaveEntry>>;

  std::optional<std::pair<wire::RefuseCode, std::string>> refusal_of(
      const wire::Hello& hello, const net::PeerIdentity& peer) const;
  PeerLink::Callbacks callbacks_of(SessionId session, bool is_tile_link);
  void on_tile_message(SessionId session, wire::Message message);
  void on_scene_message(SessionId session, wire::Message message);
  void on_scene_failed(SessionId session, wire::SceneFailed failed);
  void on_certificate_request(SessionId session, wire::CertificateRequest request);
  void join_relay(SessionId session);
  bool feed_by_slave(SessionId session, SceneVersion version, std::uint64_t bytes);
  void tell_feed(const Feed& feed);
  void apply(const std::vector<Feed>& feeds);
  void on_relay_failed(SessionId session, const wire::RelayFailed& failed);
  void watch_relay();
  // Announces the version, unless the slave has said that it cannot hold as much.
  void offer(SessionId session, SceneVersion version, const SharedScene& scene);
  std::string cannot_hold_text(const EncodedScene& scene) const;
  bool is_behind(SessionId session) const;
  void watch_frames(SessionId session, const wire::Message& message);
  void set_pace(SessionId session);
  void pump_gently();
  void lose(SessionId session, const std::string& reason, LossKind kind = LossKind::kOther);
  LossKind kind_of(SessionId session, const Status& end, bool is_tile_link) const;
  void leave(SessionId session, const std::string& reason);  // in order, as announced
  void remove(SessionId session, SlaveEnd how);
  void take_name(const PeerLink& link, wire::Hello& hello);
  void welcome_back(const wire::Hello& hello, const net::PeerIdentity& peer);
  void sweep();
  static const std::string& key_of(const wire::Hello& hello, const net::PeerIdentity& peer);

  net::EventLoop& io_;
  const std::optional<Isa> wanted_isa_;
  const bool is_isa_mixed_;
  const ClusterEvents events_;
  const bool is_relaying_;
  const net::Pulse pulse_;  // of slaves that are near
  RelayPlan relay_;
  std::optional<Isa> bound_isa_;
  SlaveMap slaves_;
  Quarantine quarantine_;
  CommonCause cause_;
  std::uint16_t next_ordinal_ = 0;
  std::map<SceneVersion, SharedScene> scenes_;  // kept for whoever joins
  SceneSummarizer summarizer_;
  std::set<SceneVersion> needed_;  // by a frame, not retired
  std::uint64_t gone_bytes_sent_ = 0, gone_bytes_received_ = 0, gone_scene_bytes_sent_ = 0;
  std::set<std::string> names_seen_;  // of slaves, at most kConnectionsMax
  // What a slave of this name could not hold, and how much memory it had then.
  struct Unfit {
    std::uint64_t scene_bytes = 0, memory_bytes = 0;
  };
  static constexpr std::size_t kUnfitMax = 4096;  // names remembered; past it all are forgotten
  std::map<std::string, Unfit> unfit_;
  std::vector<std::pair<SessionId, SceneVersion>> not_offered_;  // to be reported
  std::set<std::pair<SessionId, FrameId>> open_frames_;
  bool is_pumping_gently_ = false;
  net::Timer sweep_, gentle_pump_, not_offered_timer_;
};

}  // namespace tessera::master
