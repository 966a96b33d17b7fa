// SPDX-License-Identifier: Apache-2.0
#include "master/import/read_file.h"

namespace tessera::import {

Result<ReadScene> read_stl_file(const std::string& path) { return read_stl(path); }

}  // namespace tessera::import
