// SPDX-License-Identifier: Apache-2.0
#include "master/import/read_file.h"

namespace tessera::import {

Result<ReadScene> read_bpt_file(const std::string& path) { return read_bpt(path); }

}  // namespace tessera::import
