// The sending half of the scene pipeline: announces versions, sends the blocks that the holder
// lacks, piece by piece, as the link takes them. One for each slave, and one in an application that
// is connected to a master.
//
// Threads. Io thread only.
//
// Invariants. (1) At most kUnansweredMax versions are announced and neither built nor failed; of
// those that wait behind them only the ones that a frame needs, and the newest, are ever announced,
// and only those are kept.
// (2) Pieces are queued only while the send queue is short, so that one slow holder costs bounded
// memory and nobody else's time.
#pragma once

#include <deque>
#include <map>
#include <memory>
#include <set>

#include "common/base/status.h"
#include "common/scene/scene_codec.h"
#include "common/wire/messages.h"
#include "master/cluster/peer_link.h"

namespace tessera::master {

using SharedScene = std::shared_ptr<const EncodedScene>;

class SceneSender {
 public:
  static constexpr std::size_t kUnansweredMax = 4;
  // Versions on the holder that are not retired; above it only what a frame needs is announced. The
  // protocol allows 32.
  static constexpr std::size_t kLiveMax = 8;

  // `link` outlives the sender.
  explicit SceneSender(PeerLink& link) : link_(link) {}

  void commit(SceneVersion version, SharedScene scene);
  // A frame will be rendered from this version: it is announced even when a newer one exists.
  void need(SceneVersion version);
  // Returns: kDataLoss when the holder asks for what was not announced.
  Status on_need(const wire::SceneNeed& need);
  // Built or failed: the holder is done with this version.
  void on_answered(SceneVersion version);
  // Call when the link has drained.
  void pump();
  // Older versions are dropped, also by the holder.
  void retire(SceneVersion first_kept);

 private:
  struct Upload {
    SceneVersion version = 0;
    std::uint32_t block = 0;
    std::uint64_t offset = 0;
  };

  void announce_next();

  PeerLink& link_;
  std::map<SceneVersion, SharedScene> scenes_;  // not yet answered
  std::set<SceneVersion> announced_;            // subset of scenes_
  std::set<SceneVersion> live_;                 // ever announced, not retired
  std::set<SceneVersion> needed_;
  std::set<SceneVersion> asked_;  // blocks were asked for: once for each version
  std::deque<Upload> uploads_;
  SceneVersion first_kept_ = 0;
};

}  // namespace tessera::master
