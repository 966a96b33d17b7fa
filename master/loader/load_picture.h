// SPDX-License-Identifier: Apache-2.0
// Reads a picture that a person names, of any format that is read: tessera-import decodes it in a
// separate, limited process, as it reads scenes, so that nothing in a file can crash, hang or
// exhaust the master.
//
// Threads. Any; blocks until done.
#pragma once

#include <functional>
#include <string>

#include "common/base/status.h"
#include "master/image/image_read.h"
#include "master/loader/import_process.h"

namespace tessera::master {

// `should_go_on` is asked now and then. Returns: one line naming the file; kResourceExhausted for a
// limit, kInternal where the decoder died, kCancelled.
Result<FloatImage> load_picture(const std::string& path, const ImportLimits& limits,
                                const std::function<bool()>& should_go_on);

}  // namespace tessera::master
