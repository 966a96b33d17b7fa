// SPDX-License-Identifier: Apache-2.0
// Texts of files and peers, made fit for a terminal and a log: names of meshes, messages of
// libraries, what a slave calls itself. Whoever writes to a terminal or a log passes its texts
// through here, so that no name moves the cursor, turns the line round or sets the window's title.
//
// Threads. Pure functions.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>

namespace tessera {

// Most bytes of one line; what is longer ends in "...".
inline constexpr std::size_t kCleanBytesMax = 4000;

// Returns: valid UTF-8 without control characters (C0, DEL, C1, with them every escape sequence's
// beginning), line and paragraph separators, and marks that change the direction of writing, each
// of which becomes '?', as does each byte that is no part of UTF-8 (RFC 3629; so no byte of 8 bits
// is taken for a control). is_block: line breaks stay.
std::string clean_text(std::string_view text, std::size_t bytes_max = kCleanBytesMax,
                       bool is_block = false);

}  // namespace tessera
