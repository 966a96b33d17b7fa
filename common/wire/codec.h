// SPDX-License-Identifier: Apache-2.0
// Turns messages into records and back: protobuf headers with raw payloads beside them.
// Threads. Pure functions, any thread. Invariant: what decode() hands out has passed every check
// that a single message can be put to: counts against bytes, ranges, finite numbers.
#pragma once

#include "common/base/status.h"
#include "common/net/record.h"
#include "common/wire/messages.h"

namespace tessera::wire {

// Limits of every record type, for net::Connection. Types without limits are refused before
// allocation. Before the handshake only Hello, Join and Refuse are allowed.
const net::RecordLimits& pre_auth_limits();
const net::RecordLimits& session_limits();
// Limits between slaves: a feeder's for a child that has not said its token, a feeder's for one
// that has, and a child's for its feeder.
const net::RecordLimits& relay_join_limits();
const net::RecordLimits& relay_feeder_limits();
const net::RecordLimits& relay_child_limits();

// Bulk payloads (SceneChunk, FrameChunk, TileResult) are moved or shared, never copied.
net::Record encode(Message message);

// Returns: kDataLoss naming message and field for anything malformed or out of range.
Result<Message> decode(net::ReceivedRecord record);

// "Hello", "TileResult", ... for logs.
const char* message_name(const Message& message);

}  // namespace tessera::wire
