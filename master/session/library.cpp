// SPDX-License-Identifier: Apache-2.0
// libtessera's own symbol: which build was loaded, for those who load it by name.
#include "common/base/api.h"
#include "common/base/version.h"

extern "C" TESSERA_API const char* tessera_version();
extern "C" const char* tessera_version() { return tessera::kBuildId; }
