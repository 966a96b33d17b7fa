// SPDX-License-Identifier: Apache-2.0
// The sending half of the scene pipeline: announces versions, sends the lists and chunks that the
// holder lacks as the link takes them, coded where the link is slow. A master has one for each
// slave, and an application that is connected to a master has one.
//
// Threads. Io thread only.
//
// Invariants. (1) At most kUnansweredMax versions are announced and neither built nor failed; of
// those that wait behind them only the ones that a frame needs, and the newest, are ever announced,
// and only those are kept.
// (2) Chunks are queued only while the send queue is short, so that one slow holder costs bounded
// memory and nobody else's time.
// (3) A version that another slave feeds (set_fed) gets lists from here and no chunk that was not
// asked for here.
#pragma once

#include <deque>
#include <functional>
#include <map>
#include <memory>
#include <set>
#include <vector>

#include "common/base/status.h"
#include "common/scene/scene_codec.h"
#include "common/wire/announced_blocks.h"
#include "common/wire/codec_chooser.h"
#include "common/wire/link_rate.h"
#include "common/wire/messages.h"
#include "master/cluster/gentle_pace.h"
#include "master/cluster/peer_link.h"

namespace tessera::master {

using SharedScene = std::shared_ptr<const EncodedScene>;

class SceneSender {
 public:
  static constexpr std::size_t kUnansweredMax = 4;
  // Versions on the holder that are not retired; from this number on only what a frame needs is
  // announced. The protocol allows 32.
  static constexpr std::size_t kLiveMax = 8;
  // SceneChunkNeeds for each block of a version, on average: a holder whose relay failed asks again
  // for what it lacks.
  static constexpr std::uint32_t kAskedAgainMax = 16;

  // Called with the bytes of a need before it is served. Returns: whether another slave feeds them.
  using FeedBy = std::function<bool(SceneVersion version, std::uint64_t bytes)>;

  // `link` outlives the sender.
  explicit SceneSender(PeerLink& link, FeedBy feed_by = nullptr)
      : link_(link), feed_by_(std::move(feed_by)) {}

  void commit(SceneVersion version, SharedScene scene);
  // A frame will be rendered from this version: it is announced even when a newer one exists.
  void need(SceneVersion version);
  // Returns: kDataLoss when the holder asks for what was not announced.
  Status on_need(const wire::SceneNeed& need);
  Status on_chunk_need(wire::SceneChunkNeed need);
  // The holder has built this version, or failed to, and is done with it.
  void on_answered(SceneVersion version);
  // Call when the link has drained, and now and then while data yields.
  void pump();
  // Drops older versions, and tells the holder to do so.
  void retire(SceneVersion first_kept, bool keeps_newest);

  // Data for this holder yields (GentlePace) while others are rendering and do not wait for it.
  void set_gentle(bool is_gentle) { is_gentle_ = is_gentle; }
  // True until the holder's first scene is built, or a version became old while it was under way:
  // then the scene changes faster than a yielding link carries it, and the holder would stay behind
  // for good.
  bool is_joining() const { return is_joining_; }
  bool has_uploads() const { return !uploads_.empty(); }

 private:
  // What is to be sent of one block: its list, or some of its chunks.
  struct Upload {
    SceneVersion version = 0;
    std::uint32_t block = 0;
    bool is_list = false;
    std::vector<bool> chunks;  // empty: all
    std::uint32_t next = 0;
  };

  void announce_next();
  void announce(SceneVersion version, const SharedScene& scene);
  // Sends one record of the upload. Returns: whether that was its last.
  bool send_some(Upload& upload, const SceneBlock& block);
  void send_chunk(const Upload& upload, const SceneBlock& block, std::uint32_t index);

  PeerLink& link_;
  const FeedBy feed_by_;
  std::map<SceneVersion, SharedScene> scenes_;  // not yet answered
  std::set<SceneVersion> announced_;            // subset of scenes_
  wire::AnnouncedBlocks newest_blocks_;         // as the link's other end knows them
  std::set<SceneVersion> live_;                 // ever announced, not retired
  std::set<SceneVersion> needed_;
  std::set<SceneVersion> asked_;  // blocks were asked for: once for each version
  std::map<SceneVersion, std::uint32_t> chunk_asks_;  // how often chunks were asked for
  std::deque<Upload> uploads_;
  SceneVersion first_kept_ = 0;
  wire::ByteCodingMask codings_ = wire::kByteCodingsNone;
  wire::LinkRate rate_;
  wire::CodecChooser chooser_;
  GentlePace pace_;
  bool is_gentle_ = false;
  bool is_joining_ = true;
};

}  // namespace tessera::master
