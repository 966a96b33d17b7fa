// SPDX-License-Identifier: Apache-2.0
#include "master/cluster/master_metrics.h"

namespace tessera::master {

MasterMetrics& master_metrics() {
  static MasterMetrics cells;
  return cells;
}

}  // namespace tessera::master
