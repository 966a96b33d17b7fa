// SPDX-License-Identifier: Apache-2.0
// The receiving half of the scene pipeline, which is pure: announcements, lists and chunks go in;
// requests for what is lacking and complete scenes come out. Blocks and their chunks are named by
// their digests, checked here, and kept (SceneShelf), so that an update brings only the chunks that
// changed, and a transfer that was broken off goes on where it was.
//
//   announce -> [refused: cannot hold it] -> need (blocks) -> lists -> chunk needs -> chunks
//
// When a block is asked for, a block of one chunk is sent as it is; for a larger one the list is
// sent, and then the chunks that are asked for. Chunks may come from anybody: it is the list that
// is trusted, and the announcement that vouches for it.
//
// Announcements are served one after the other: the next one is answered when the one before it is
// complete, failed or retired, so that no block is asked for twice.
//
// Threads. One owner (the network thread). No socket, no clock.
// Invariants. (1) At most kAnnouncedMax announcements wait. (2) A block is at most as long as
// announced. (3) No bytes reach a scene before their digest has been checked. (4) A version for
// which memory runs out has failed, with one line; those that wait behind it are served.
#pragma once

#include <cstdint>
#include <deque>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <unordered_map>
#include <vector>

#include "common/base/digest.h"
#include "common/base/status.h"
#include "common/wire/announced_blocks.h"
#include "common/wire/messages.h"
#include "common/wire/scene_shelf.h"

namespace tessera::wire {

class SceneReceiver {
 public:
  static constexpr std::size_t kAnnouncedMax = 16;

  struct Complete {
    SceneVersion version = 0;
    EncodedScene scene;
    std::uint64_t total_bytes = 0;  // of its blocks
  };
  // A chunk of a block that is here and checked.
  struct Arrival {
    SceneVersion version = 0;
    std::uint32_t block = 0, chunk = 0;
  };
  // What the caller has to do, in the order of the members.
  struct Actions {
    std::vector<Complete> complete;
    std::vector<SceneFailed> failed;
    std::vector<SceneNeed> need;
    std::vector<SceneChunkNeed> chunk_need;
    // For slaves that this one feeds: versions of which find() may know chunks from now on, and
    // chunks that have come.
    std::vector<SceneVersion> begun;
    std::vector<Arrival> arrived;
  };
  enum class Verdict {
    kStored,
    kLate,         // the version is done, or the chunk is here
    kNotAskedFor,  // a breach of the protocol, as are those below
    kMalformed,
    kWrongDigest,
    kNoMemory,  // here, for the chunk; its sender has done nothing wrong
  };

  // Returns: how many bytes may be taken now, where `needed_bytes` are needed; nothing: no limit is
  // known. It is called once for each announcement.
  using Room = std::function<std::optional<std::uint64_t>(std::uint64_t needed_bytes)>;
  // A slave builds what it receives; a master keeps the blocks as they are.
  enum class Use { kBuilt, kKept };
  explicit SceneReceiver(Room room = nullptr, Use use = Use::kBuilt)
      : room_(std::move(room)), use_(use) {}

  // Returns: kDataLoss or kResourceExhausted when the sender broke the protocol.
  Status announce(SceneAnnounce announce, Actions& actions);
  Status list(SceneChunkList list, Actions& actions);
  Status chunk(const SceneChunk& chunk, Actions& actions);  // from the peer that announced
  void retire(SceneVersion first_kept, Actions& actions);

  // Takes a chunk from another peer; a chunk that does not fit changes nothing.
  Verdict take(const SceneChunk& chunk, Actions& actions);

  // The connection is gone: forgets announcements, keeps blocks and chunks.
  void reset();

  // The version that is being received, 0: none; the chunks that it still lacks in blocks whose
  // lists are here; the bytes of it that have come.
  SceneVersion head_version() const { return head_ ? head_->version : 0; }
  std::vector<SceneChunkNeed> lacking() const;
  std::uint64_t head_bytes() const;

  // Finds a checked chunk of a version that is complete and kept, or in work. kNotYet is also the
  // answer for a version that is newer than any announced here, which may be on its way.
  enum class Holding { kHere, kNotYet, kNever };
  Holding find(SceneVersion version, std::uint32_t block, std::uint32_t chunk,
               net::SharedBytes& bytes) const;

 private:
  // The announcement being served.
  struct Head {
    SceneVersion version = 0;
    std::uint64_t index_bytes = 0;
    double time_seconds = 0;
    BlockNames names;
    std::uint64_t total_bytes = 0;
    BlockTable::Editor blocks;           // those without bytes are lacking
    std::vector<std::uint32_t> changed;  // blocks not shared with the newest scene on the shelf
    // Indices at which each missing block belongs; the first one is asked for.
    std::unordered_map<Digest, std::vector<std::uint32_t>, DigestHash> lacking;
    std::map<std::uint32_t, BlockAssembly> assemblies;  // by first index
    std::uint64_t had_bytes = 0;                        // of blocks that were here or are whole
  };

  struct Announced {
    SceneAnnounce announce;  // without its blocks
    BlockNames names;
    std::uint64_t total_bytes = 0;
  };

  void serve_next(Actions& actions);
  void serve(Announced announced, Actions& actions);
  SceneNeed begin_head(Announced announced);
  void begin_block(std::uint32_t block, const SceneShelf::Newest& newest, SceneNeed& need);
  std::uint64_t bytes_to_take(const SceneNeed& need) const;
  bool refuse_head(const SceneNeed& need, Actions& actions);
  void take_list(SceneChunkList list, BlockAssembly& assembly, Actions& actions);
  void fill_from_shelf(BlockAssembly& assembly);
  void finish_block(std::uint32_t block, Actions& actions);
  void join_block(std::uint32_t block);
  void finish_head(Actions& actions);
  void break_off_head();
  void fail(SceneVersion version, std::uint64_t block_bytes, Actions& actions);
  std::uint64_t bytes_of(std::uint32_t block) const;
  void fail_head(std::string reason, Actions& actions);
  bool is_past(SceneVersion version) const;

  Room room_;
  Use use_;
  std::deque<Announced> waiting_;
  std::unique_ptr<Head> head_;
  SceneVersion newest_announced_ = 0;
  AnnouncedBlocks newest_blocks_;
  SceneShelf shelf_;
};

}  // namespace tessera::wire
