// SPDX-License-Identifier: Apache-2.0
// The URIs of a glTF file (RFC 3986, RFC 2397): names of files below the scene's folder, percent
// encoded, or bytes in the text itself.
// Threads. Pure functions but for read_uri(), which reads files.
#pragma once

#include <string>
#include <string_view>

#include "common/base/status.h"

namespace tessera::import {

// "%20" becomes a space. Returns: kInvalidArgument where digits are missing or a name would hold a
// zero byte.
Result<std::string> percent_decoded(std::string_view text);

// RFC 4648, both alphabets, with or without padding; white space is passed over.
Result<std::string> base64_decoded(std::string_view text);

// The bytes that `uri` stands for; files are those that confined_path() allows below `folder`.
// Returns: a reason that follows the name of what has the URI.
Result<std::string> read_uri(const std::string& folder, const std::string& uri,
                             std::uint64_t bytes_max);

}  // namespace tessera::import
