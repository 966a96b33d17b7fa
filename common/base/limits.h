// SPDX-License-Identifier: Apache-2.0
// Every cap of the system, with its reason. Border code refuses what is above a cap; code behind
// the border trusts them. Related caps are tied by static_assert.
#pragma once

#include <cstddef>
#include <cstdint>

namespace tessera {

// Image side, pixels. 16384 x 16384 float RGB is 3 GiB: what a master with 8 GiB holds once.
inline constexpr int kImageSideMaxPx = 16384;

// Edge of a square tile, pixels. The upper bound keeps one result (float RGB) below 1 MiB; the
// lower bound is one 4x4 bundle.
inline constexpr int kTileEdgeMinPx = 4;
inline constexpr int kTileEdgeMaxPx = 256;
inline constexpr int kTileEdgeAuto = 0;     // the master chooses
inline constexpr int kTileEdgeAutoPx = 32;  // its choice before it knows what a pixel costs
inline constexpr std::size_t kTilePayloadBytesMax =
    std::size_t{kTileEdgeMaxPx} * kTileEdgeMaxPx * 3 * sizeof(float);
// Bytes of a frame, planes included: what float RGB of the largest frame takes. A float pixel with
// all planes takes 68 bytes, so that such a frame has at most 47 million pixels; its tiles are
// smaller, too.
inline constexpr std::uint64_t kFrameBytesMax =
    std::uint64_t{kImageSideMaxPx} * kImageSideMaxPx * 3 * sizeof(float);

// Render threads of one slave. Debian's largest common machines have 256 hardware threads.
inline constexpr int kWorkersMax = 256;
// Tiles leased to one slave at once, per worker (prefetch 3, plus one being rendered, plus slack).
inline constexpr int kTilesPerWorkerMax = 16;
inline constexpr int kTilesLeasedMax = kTilesPerWorkerMax * kWorkersMax;

// Frames in flight: the thesis's two-frames scheduling.
inline constexpr int kFramesInFlightMax = 2;

// Samples per pixel and light samples; their caps bound the time of a tile.
inline constexpr int kSamplesPerPixelMax = 256;
inline constexpr int kLightSamplesMax = 256;
inline constexpr int kBouncesMax = 64;
// VPLs of a pixel; with 5x5 interleaving 25 times as many are made, 6 MB of them.
inline constexpr int kVplsMax = 4096;
// Pictures of a camera at rest that are averaged; each takes up to 256 samples of the sequence.
inline constexpr std::uint32_t kPassesMax = 1u << 16;

// Time of a frame in its scene's animation: a year, at which a double tells half a nanosecond.
inline constexpr double kFrameTimeMaxSeconds = 366.0 * 24 * 3600;

// Bytes of one record's header. The protobuf header is small; bulk data is the payload.
inline constexpr std::size_t kRecordHeaderBytesMax = 64 * 1024;
inline constexpr std::size_t kPreAuthRecordBytesMax = 16 * 1024;  // before the peer is known
// One chunk of a scene block, the unit that is digested, resumed, relayed and sent: 5 ms of a link
// of 100 Mbit/s, the time that a heartbeat may wait behind it.
inline constexpr std::size_t kSceneChunkBytes = 64 * 1024;
// Bytes of the digests of all chunks of one block.
inline constexpr std::size_t kSceneChunkListBytesMax = 4 * 1024 * 1024;
inline constexpr std::size_t kFrameChunkBytesMax = 4 * 1024 * 1024;  // one piece of a frame
static_assert(kTilePayloadBytesMax <= kFrameChunkBytesMax, "a tile fits into one record");

// Counts and sizes of a scene. The spatial index can address 2^30 triangles; blocks are bounded so
// that counts times sizes never overflow 64 bits.
inline constexpr std::uint64_t kTrianglesMax = std::uint64_t{1} << 30;
// Patches of the flattened scene, each of which a slave cuts into up to some hundred parts, and
// the segments of the loops that trim them.
inline constexpr std::uint64_t kPatchesMax = std::uint64_t{1} << 24;
inline constexpr std::uint64_t kTrimSegmentsMax = std::uint64_t{1} << 26;
static_assert(kPatchesMax < kTrianglesMax, "primitives of both kinds are counted together");
inline constexpr std::uint64_t kSceneBlockBytesMax = std::uint64_t{8} << 30;
inline constexpr std::uint32_t kSceneBlocksMax = 65536;
inline constexpr std::uint32_t kSceneBlockChunksMax =
    static_cast<std::uint32_t>(kSceneBlockBytesMax / kSceneChunkBytes);
static_assert(kSceneBlockChunksMax * std::size_t{32} <= kSceneChunkListBytesMax);
inline constexpr std::uint32_t kInstancesMax = 1u << 20;
inline constexpr std::uint32_t kMaterialsMax = 65536;
inline constexpr std::uint32_t kLightsMax = 65536;
// Nodes of a scene's animation, as many as instances; joints that pull at one vertex: files have 4
// or 8.
inline constexpr std::uint32_t kAnimationNodesMax = kInstancesMax;
inline constexpr std::uint32_t kInfluencesMax = 64;
inline constexpr std::uint32_t kCamerasMax = 1024;  // cameras that a person can choose from
inline constexpr int kTextureSideMaxPx = 16384;
// Environment maps: a latitude-longitude picture of 8192 x 4096 texels is 400 MB of floats.
inline constexpr int kEnvironmentSideMaxPx = 8192;
// The sun's disk has some 1e5 times the radiance of the sky; above 1e12 products of float32
// overflow.
inline constexpr float kEnvironmentRadianceMax = 1e12f;

// Connections of one listener: all, unauthenticated, unauthenticated of one address.
inline constexpr int kConnectionsMax = 4096;
inline constexpr int kConnectionsPreAuthMax = 64;
inline constexpr int kConnectionsPreAuthPerAddressMax = 16;
inline constexpr std::size_t kNameBytesMax = 64;  // slave and cluster names

// Liveness, milliseconds: heartbeat interval, missed heartbeats until a peer counts as dead,
// handshake deadline, reconnect pauses (first, greatest).
inline constexpr int kHeartbeatMs = 250;
inline constexpr int kHeartbeatsMissedMax = 4;
// The same between an application and its master: 15 s. A slave that was given up too early joins
// again and has lost some tiles; an application has lost its pictures. So both wait as long as a
// process may stand still on a machine that others keep busy. A process that ends, or a machine
// that answers, closes the link at once.
inline constexpr int kAppHeartbeatsMissedMax = 59;
inline constexpr int kHandshakeMs = 2000;
inline constexpr int kReconnectFirstMs = 100;
inline constexpr int kReconnectMaxMs = 5000;

// Attempts of one tile before its frame fails.
inline constexpr int kTileAttemptsMax = 3;
// Leases of one tile, those handed back unrendered included, before its frame fails; while a slave
// is there that has not had the tile since, it does not.
inline constexpr int kTileLeasesMax = 64;

}  // namespace tessera
