// SPDX-License-Identifier: Apache-2.0
#include "common/frame/frame_stats.h"

namespace tessera {

std::string_view slave_state_name(SlaveState state) {
  switch (state) {
    case SlaveState::kWaiting:
      return "waiting";
    case SlaveState::kReady:
      return "ready";
    case SlaveState::kStalled:
      return "stalled";
  }
  return "unknown";
}

}  // namespace tessera
