// SPDX-License-Identifier: Apache-2.0
// Numbers of the records and the caps that hold for the wire alone (the shared ones are in
// common/base/limits.h). The numbers never change and are never given away again; PROTOCOL.md lists
// the same ones.
//
// Threads. Constants.
#pragma once

#include <cstddef>
#include <cstdint>

#include "common/base/event_memory.h"
#include "common/base/limits.h"
#include "common/base/log_limiter.h"
#include "common/net/record.h"

namespace tessera::wire {

enum class RecordType : std::uint16_t {
  kHello = 1,
  kWelcome = 2,
  kJoin = 3,
  kJoined = 4,
  kRefuse = 5,
  kPing = 6,
  kPong = 7,
  kGoodbye = 8,
  kCertificateRequest = 9,
  kCertificateGrant = 10,
  kSceneAnnounce = 16,
  kSceneNeed = 17,
  kSceneChunk = 18,
  kSceneBuilt = 19,
  kSceneFailed = 20,
  kSceneRetire = 21,
  kSceneChunkList = 22,
  kSceneChunkNeed = 23,
  kRelayFrom = 24,
  kRelayFailed = 25,
  kSceneProgress = 26,
  kRelayJoin = 27,
  kFrameBegin = 32,
  kTileLease = 33,
  kFrameEnd = 34,
  kTileResult = 35,
  kTileReturned = 36,
  kFrameSubmit = 48,
  kFrameCancel = 49,
  kFrameChunk = 50,
  kFrameDone = 51,
  kStatusRequest = 52,
  kStatusReply = 53,
};
static_assert(static_cast<int>(RecordType::kStatusReply) < net::kRecordTypesMax);

// Bytes of the header of a message of plain numbers: fewer than 40 fields of at most 11 bytes each,
// with room for fields of later versions.
inline constexpr std::size_t kSmallHeaderBytesMax = 1024;
// Bytes of a line for a person; the sender cuts longer ones.
inline constexpr std::size_t kReasonBytesMax = 1024;
// Bytes of the header of a message with such a line.
inline constexpr std::size_t kTextHeaderBytesMax = 4096;
static_assert(kReasonBytesMax + kSmallHeaderBytesMax <= kTextHeaderBytesMax);
static_assert(kTextHeaderBytesMax <= kPreAuthRecordBytesMax);
static_assert(kPreAuthRecordBytesMax <= kRecordHeaderBytesMax);
inline constexpr std::size_t kBuildIdBytesMax = 64;
// Bytes of a certificate and of the request for one; both have some hundreds.
inline constexpr std::size_t kCertificateBytesMax = 4096;

// Tiles of the largest frame at the smallest tile: 4096 x 4096.
inline constexpr std::uint32_t kTilesPerFrameMax =
    std::uint32_t{kImageSideMaxPx / kTileEdgeMinPx} * (kImageSideMaxPx / kTileEdgeMinPx);

// SceneAnnounce: 32 bytes of digest and 8 of size for each block.
inline constexpr std::size_t kAnnounceEntryBytes = 40;
// The place of a block that is not what it was in the announcement before.
inline constexpr std::size_t kAnnouncePlaceBytes = 4;
// StatusReply: one slave, its name length byte and the longest name included (codec_app.cpp).
inline constexpr std::size_t kStatusEntryBytesMax = 1 + kNameBytesMax + 49 + 256;

// StatusReply: the reason why a slave is held back is cut to so many bytes; its length is one byte.
inline constexpr std::size_t kQuarantineReasonBytesMax = 160;
inline constexpr std::size_t kQuarantineEntryBytesMax =
    1 + kNameBytesMax + 1 + kQuarantineReasonBytesMax + 8 + 4;

// StatusReply: the last lines of the master's log, and the events of which some were suppressed. A
// line has 2 bytes of length, 8 of time, 1 of level; an event 2 of length and 8 of a count.
inline constexpr std::size_t kEventsMax = EventMemory::kEventsKept;
inline constexpr std::size_t kEventLineBytesMax = 512;
inline constexpr std::size_t kSuppressedMax = LogLimiter::kEventsMax + 1;  // and all others
inline constexpr std::size_t kLogBytesMax =
    kEventsMax * (2 + kEventLineBytesMax + 8 + 1) + kSuppressedMax * (2 + kNameBytesMax + 8);
// StatusReply: why no slave is here is cut to so many bytes of its header.
inline constexpr std::size_t kAloneReasonBytesMax = 400;
static_assert(kAloneReasonBytesMax + 400 <= kSmallHeaderBytesMax, "beside all its numbers");

// Longest heartbeat that a master may ask for, a minute, and most missed ones.
inline constexpr std::uint32_t kHeartbeatMsMax = 60'000;
inline constexpr std::uint32_t kHeartbeatsMissedLimit = 100;

}  // namespace tessera::wire
