// SPDX-License-Identifier: Apache-2.0
// Runs tessera-import on one file, watches its limits, and turns its end or death into what it
// wrote or one line.
//
// Threads. Any; blocks until the process has ended.
#pragma once

#include <cstddef>
#include <functional>
#include <string>
#include <vector>

#include "common/base/status.h"
#include "common/scene/scene_stream.h"

namespace tessera::master {

struct ImportLimits {
  double seconds_max = 60;  // by the clock, and of processor time
  std::uint64_t bytes_max = std::uint64_t{16} << 30;
};

enum class ImportKind { kScene, kPicture };

// `progress` is called every now and then with the bytes received so far; it returns false to give
// up.
// Returns: what the importer wrote, or its own refusal, kResourceExhausted for a limit, kInternal
// when it died, kCancelled.
Result<std::vector<std::byte>> run_importer(
    const std::string& path, ImportKind kind, const ImportLimits& limits,
    const std::function<bool(std::uint64_t bytes)>& progress);

// The same for a scene, decoded.
Result<SceneStream> run_import(const std::string& path, const ImportLimits& limits,
                               const std::function<bool(std::uint64_t bytes)>& progress);

}  // namespace tessera::master
