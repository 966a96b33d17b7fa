// SPDX-License-Identifier: Apache-2.0
// The page of metrics of a master: what it counts of itself, and the cluster as it is now.
// Each name says what it is in its HELP line; deploy/metrics draws them.
//
// Threads. Pure but for the cells, which any thread may read.
#pragma once

#include <string>

#include "common/frame/frame_stats.h"

namespace tessera::master {

std::string metrics_page(const ClusterStatus& status);

}  // namespace tessera::master
