// SPDX-License-Identifier: Apache-2.0
#include "master/loader/load_picture.h"

#include <utility>

#include "common/base/log.h"
#include "master/image/picture_stream.h"

namespace tessera::master {

Result<FloatImage> load_picture(const std::string& path, const ImportLimits& limits,
                                const std::function<bool()>& should_go_on) {
  const auto bytes = run_importer(path, ImportKind::kPicture, limits,
                                  [&](std::uint64_t) { return should_go_on(); });
  if (!bytes.is_ok()) return bytes.status();
  auto stream = decode_picture_stream(*bytes);
  if (!stream.is_ok())
    return Status(stream.status().code(), path + ": " + stream.status().message());
  if (!stream->warning.empty()) log_warn("picture-read", stream->warning);
  return std::move(stream->image);
}

}  // namespace tessera::master
