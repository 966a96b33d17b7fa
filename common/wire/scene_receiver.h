// The receiving half of the scene pipeline, pure: announcements and pieces go in; what is lacking
// and scenes that are complete come out. Blocks are named by their SHA-256, checked here, and kept
// for the two newest complete scenes, so that an update brings only what changed, also after a
// reconnect.
//
// Announcements are served one after the other: the next one is answered when the one before it is
// complete, failed or retired, so that no block is asked for twice.
//
// Threads. One owner (the network thread). No socket, no clock.
// Invariants. (1) At most kAnnouncedMax announcements wait. (2) A block is at most as long as
// announced. (3) No bytes reach a scene before their digest has been checked.
#pragma once

#include <cstdint>
#include <deque>
#include <memory>
#include <optional>
#include <string>
#include <unordered_map>
#include <vector>

#include "common/base/digest.h"
#include "common/base/status.h"
#include "common/scene/scene_codec.h"
#include "common/wire/messages.h"

namespace tessera::wire {

class SceneReceiver {
 public:
  static constexpr std::size_t kAnnouncedMax = 16;
  static constexpr std::size_t kScenesKept = 2;

  struct Complete {
    SceneVersion version = 0;
    EncodedScene scene;
  };
  // To be done by the caller, in the order of the members.
  struct Actions {
    std::vector<Complete> complete;
    std::vector<SceneFailed> failed;
    std::vector<SceneNeed> need;
  };

  // Returns: kDataLoss or kResourceExhausted when the sender broke the protocol.
  Status announce(SceneAnnounce announce, Actions& actions);
  Status chunk(const SceneChunk& chunk, Actions& actions);
  void retire(SceneVersion first_kept, Actions& actions);

  // The connection is gone: forgets announcements, keeps the blocks.
  void reset();

 private:
  struct Partial {
    std::vector<std::byte> bytes;
    Sha256 hash;
  };
  // The announcement being served.
  struct Head {
    SceneAnnounce announce;
    std::vector<BlockBytes> blocks;  // null: lacking
    // Where each missing block belongs; its first index is asked for.
    std::unordered_map<Digest, std::vector<std::uint32_t>, DigestHash> lacking;
    std::unordered_map<std::uint32_t, Partial> partial;
  };

  void serve_next(Actions& actions);
  void finish_head(Actions& actions);
  void keep(const EncodedScene& scene);
  void fail_head(std::string reason, Actions& actions);

  std::deque<SceneAnnounce> waiting_;
  std::unique_ptr<Head> head_;
  SceneVersion newest_announced_ = 0;
  std::deque<EncodedScene> kept_;
  std::unordered_map<Digest, BlockBytes, DigestHash> cache_;
};

}  // namespace tessera::wire
