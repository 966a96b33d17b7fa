// SPDX-License-Identifier: Apache-2.0
#include "master/schedule/result_verdict.h"

namespace tessera::master {

const char* verdict_text(ResultVerdict verdict) {
  switch (verdict) {
    case ResultVerdict::kAccepted:
      return "accepted";
    case ResultVerdict::kDuplicate:
      return "a duplicate";
    case ResultVerdict::kConfirmed:
      return "that confirms another one";
    case ResultVerdict::kFaulty:
      return "with faulty pixels";
    case ResultVerdict::kDisputed:
      return "that differs from another slave's";
    case ResultVerdict::kUndecided:
      return "that differs from two others";
    case ResultVerdict::kRepeated:
      return "that it sends again and again";
    case ResultVerdict::kFrameEnded:
      return "for a frame that is over";
    case ResultVerdict::kUnknownFrame:
      return "for a frame never begun";
    case ResultVerdict::kWrongVersion:
      return "of another scene version than the frame's";
    case ResultVerdict::kNotLeased:
      return "for a tile that was not leased to it";
  }
  return "unknown";
}

bool answers_lease(ResultVerdict verdict) { return verdict <= ResultVerdict::kUndecided; }

}  // namespace tessera::master
