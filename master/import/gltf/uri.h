// SPDX-License-Identifier: Apache-2.0
// The URIs of a glTF file (RFC 3986, RFC 2397): names of files below the scene's folder, percent
// encoded, or bytes in the text itself.
// Threads. Pure functions but for read_uri(), which reads files.
#pragma once

#include <string>
#include <string_view>

#include "common/base/status.h"

namespace tessera::import {

// Decodes percent encoding: "%20" becomes a space. Returns: kInvalidArgument where a '%' is not
// followed by two hexadecimal digits.
Result<std::string> percent_decoded(std::string_view text);

// Decodes base64 (RFC 4648) of either alphabet, with or without padding; white space is skipped.
Result<std::string> base64_decoded(std::string_view text);

// The bytes that `uri` stands for. Only files that confined_path() allows below `folder` are read,
// and a name with a zero byte is refused. Returns: a reason, which a message puts after the name of
// the object that has the URI.
Result<std::string> read_uri(const std::string& folder, const std::string& uri,
                             std::uint64_t bytes_max);

}  // namespace tessera::import
