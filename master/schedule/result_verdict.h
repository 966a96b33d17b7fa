// SPDX-License-Identifier: Apache-2.0
// What the book of a frame says to one result of a tile.
//
// Threads. Plain values.
#pragma once

#include <cstddef>

namespace tessera::master {

enum class ResultVerdict {
  kAccepted,      // these are the tile's pixels; with an audit, perhaps not for good
  kDuplicate,     // answers a lease, but the tile was done already: dropped and counted
  kConfirmed,     // audit: the tile's pixels are right; these are not needed
  kFaulty,        // pixels that cannot be light: rendered once more, by another slave
  kDisputed,      // audit: they differ from the first ones, and a third slave must decide
  kUndecided,     // audit: three slaves, three pictures
  kRepeated,      // the same result once more: dropped and counted
  kFrameEnded,    // answers a frame that is over: dropped
  kUnknownFrame,  // never begun on that slave: a violation
  kWrongVersion,  // violation
  kNotLeased,     // no such lease of that session: violation
};
inline constexpr std::size_t kResultVerdicts = 11;
static_assert(static_cast<std::size_t>(ResultVerdict::kNotLeased) + 1 == kResultVerdicts);
const char* verdict_text(ResultVerdict verdict);
// Whether a result with this verdict answered an outstanding lease.
bool answers_lease(ResultVerdict verdict);

}  // namespace tessera::master
